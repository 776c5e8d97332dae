#include "view/jobs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <functional>
#include <thread>

#include "base/error.h"
#include "support/temporary_folder.h"

namespace jobs_test {

/// False after a minute.
bool comes_true(const std::function<bool()>& condition) {
  for (int k = 0; k < 6000; ++k) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

view::Job ended(const view::Jobs& jobs, int id) {
  view::Job found;
  EXPECT_TRUE(comes_true([&] {
    for (const view::Job& job : jobs.list())
      if (job.id == id) found = job;
    return !found.is_running;
  }));
  return found;
}

TEST(Jobs, TellWhatACommandPrintedSaidAndGave) {
  support::TemporaryFolder folder;
  view::Jobs jobs("/nowhere");
  const view::Job job = ended(
      jobs, jobs.start({"sh", "-c", "pwd; printf 'half\\rwhole\\n' >&2; exit 3"}, folder.path("")));
  EXPECT_EQ(job.exit_code, 3);
  EXPECT_EQ(jobs.output(job.id) + "|",
            std::filesystem::canonical(folder.path("")).string() + "\n|");
  EXPECT_THAT(job.messages, ::testing::HasSubstr("whole\n"));
  EXPECT_THAT(job.messages, ::testing::Not(::testing::HasSubstr("half")));
}

TEST(Jobs, TheirStandardErrorIsATerminalAndTheirInputEmpty) {
  view::Jobs jobs("/nowhere");
  const view::Job job =
      ended(jobs, jobs.start({"sh", "-c", "test -t 2 && ! test -t 0 && ! read line"}, "/"));
  EXPECT_EQ(job.exit_code, 0);
}

TEST(Jobs, AreStoppedWithAllThatTheyStarted) {
  support::TemporaryFolder folder;
  view::Jobs jobs("/nowhere");
  // The outer one does not end by SIGTERM; both have to be gone.
  const int id = jobs.start({"sh", "-c", "trap '' TERM; sleep 300 & echo $! > pid; wait; wait"},
                            folder.path(""));
  ASSERT_TRUE(comes_true([&] { return folder.read("pid").ends_with('\n'); }));
  jobs.stop(id);
  EXPECT_EQ(ended(jobs, id).exit_code, 128 + SIGKILL);
  const pid_t inner = std::stoi(folder.read("pid"));
  EXPECT_TRUE(comes_true([&] { return ::kill(inner, 0) != 0; }));
}

TEST(Jobs, EndWithTheirOwner) {
  support::TemporaryFolder folder;
  {
    view::Jobs jobs("/nowhere");
    jobs.start({"sh", "-c", "echo $$ > pid; exec sleep 300"}, folder.path(""));
    ASSERT_TRUE(comes_true([&] { return folder.read("pid").ends_with('\n'); }));
  }
  EXPECT_NE(::kill(std::stoi(folder.read("pid")), 0), 0);
}

TEST(Jobs, TooManyAtOnceAndWhatCannotStartAreRefused) {
  view::Jobs jobs("/nowhere");
  EXPECT_THROW(jobs.start({"no-such-program-of-kerbstone"}, "/"), base::Error);
  for (std::size_t k = 0; k < view::kMostRunning; ++k) jobs.start({"sleep", "300"}, "/");
  EXPECT_THROW(jobs.start({"true"}, "/"), base::Error);
  EXPECT_THROW(jobs.output(1), base::Error);
  EXPECT_THROW(jobs.output(99), base::Error);
}

TEST(Jobs, ManyAfterOneAnotherKeepTheNewest) {
  view::Jobs jobs("/nowhere");
  int last = 0;
  for (int k = 0; k < 60; ++k) {
    last = jobs.start({"echo", std::to_string(k)}, "/");
    ended(jobs, last);
  }
  EXPECT_EQ(jobs.list().size(), view::kMostKept);
  EXPECT_EQ(jobs.output(last), "59\n");
  EXPECT_EQ(jobs.output(1), "");
}

}  // namespace jobs_test
