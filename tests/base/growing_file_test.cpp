#include "base/growing_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <functional>

#include "base/error.h"
#include "base/write_file.h"
#include "support/temporary_folder.h"

namespace growing_file_test {

namespace fs = std::filesystem;

/// In a process of its own, which ends at once afterwards.
void in_a_process(const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    try {
      work();
    } catch (const base::Error&) {
    }
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
}

TEST(GrowingFile, LinesAreThereAtOnceAndGetTheNameAtTheEnd) {
  const support::TemporaryFolder folder;
  const std::string path = folder.file("drive.csv", "old\n");
  base::GrowingFile file(path);
  EXPECT_EQ(folder.read("drive.csv"), "old\n") << "nothing was driven yet";
  file.append("a,b\n");
  file.append("1,2\n");
  EXPECT_EQ(folder.read("drive.partial.csv"), "a,b\n1,2\n");
  EXPECT_FALSE(fs::exists(path)) << "an old one would stand for this run";
  file.finish();
  EXPECT_EQ(folder.read("drive.csv"), "a,b\n1,2\n");
  EXPECT_FALSE(fs::exists(folder.path("drive.partial.csv")));
}

TEST(GrowingFile, WhatThrowsKeepsTheLinesAndNothingAppendedKeepsTheOldOnes) {
  const support::TemporaryFolder folder;
  const std::string path = folder.file("drive.csv", "old\n");
  { const base::GrowingFile unused(path); }
  EXPECT_EQ(folder.read("drive.csv"), "old\n");
  {
    base::GrowingFile file(path);
    file.append("1\n");
  }
  EXPECT_EQ(folder.read("drive.csv"), "1\n");
  base::GrowingFile none(path);
  none.finish();
  EXPECT_FALSE(fs::exists(path)) << "this run said nothing";
}

TEST(GrowingFile, ASignalGivesTheName) {
  const support::TemporaryFolder folder;
  in_a_process([&] {
    base::GrowingFile file(folder.path("drive.csv"));
    file.append("1\n");
    base::abandon_writes();
  });
  EXPECT_EQ(folder.read("drive.csv"), "1\n");
}

TEST(GrowingFile, WhatAKilledRunWroteIsKeptWithoutHalfALine) {
  const support::TemporaryFolder folder;
  in_a_process([&] {
    base::GrowingFile file(folder.path("drive.csv"));
    file.append("1\n2\n3");
    ::_exit(0);
  });
  EXPECT_EQ(folder.read("drive.partial.csv"), "1\n2\n3");
  base::GrowingFile next(folder.path("drive.csv"));
  EXPECT_EQ(next.killed(), folder.path("drive.killed.csv"));
  EXPECT_EQ(folder.read("drive.killed.csv"), "1\n2\n");
  EXPECT_EQ(base::GrowingFile(folder.path("other.csv")).killed(), "");
}

TEST(GrowingFile, OneProcessAtATimeHasIt) {
  const support::TemporaryFolder folder;
  base::GrowingFile file(folder.path("drive.csv"));
  file.append("1\n");
  EXPECT_THAT([&] { base::GrowingFile second(folder.path("drive.csv")); },
              ::testing::ThrowsMessage<base::Error>(::testing::HasSubstr("another process")));
  file.append("2\n");
  file.finish();
  EXPECT_EQ(folder.read("drive.csv"), "1\n2\n");
}

TEST(GrowingFile, AFullDiskLeavesWholeLines) {
  const support::TemporaryFolder folder;
  in_a_process([&] {
    const rlimit most{1000, 1000};
    ::setrlimit(RLIMIT_FSIZE, &most);
    std::signal(SIGXFSZ, SIG_IGN);
    base::GrowingFile file(folder.path("drive.csv"));
    for (int k = 0; k < 1000; ++k) file.append("0123456\n89\n");
  });
  const std::string text = folder.read("drive.csv");
  EXPECT_EQ(text.size(), 990u);
  EXPECT_TRUE(text.ends_with("89\n"));
  EXPECT_THROW(base::GrowingFile("/dev/full").append("1\n"), base::Error);
}

}  // namespace growing_file_test
