#include "base/write_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "base/error.h"
#include "base/sha256.h"

namespace write_file_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class WriteFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("kerbstone_write_file_" + std::to_string(::getpid()) + "_" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override {
    fs::permissions(folder_, fs::perms::owner_all);
    fs::remove_all(folder_);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string content(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
  }
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  fs::path folder_;
};

TEST_F(WriteFile, WritesEveryByteAndLeavesNothingElseBehind) {
  std::string bytes(3'000'000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 31 % 251);
  base::write_file(path("a.bin"), bytes);
  EXPECT_EQ(content(path("a.bin")), bytes);
  base::write_file(path("a.bin"), "short");
  EXPECT_EQ(content(path("a.bin")), "short");
  base::write_file(path("empty"), "");
  EXPECT_EQ(content(path("empty")), "");
  EXPECT_EQ(files(), 2u);
}

TEST_F(WriteFile, IsReadableLikeAnOrdinaryFileAndKeepsPermissions) {
  base::write_file(path("a"), "x");
  const mode_t mask = ::umask(022);
  ::umask(mask);
  struct stat status {};
  ASSERT_EQ(::stat(path("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0666 & ~mask);
  ASSERT_EQ(::chmod(path("a").c_str(), 0640), 0);
  base::write_file(path("a"), "y");
  ASSERT_EQ(::stat(path("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST_F(WriteFile, NamesPathAndReasonWhenTheFolderIsMissingOrTheTargetIsAFolder) {
  try {
    base::write_file(path("missing/a"), "x");
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(path("missing/a")));
    EXPECT_THAT(error.what(), HasSubstr("No such file or directory"));
  }
  fs::create_directories(path("folder"));
  EXPECT_THROW(base::write_file(path("folder"), "x"), base::Error);
  EXPECT_EQ(files(), 1u);
}

TEST_F(WriteFile, KeepsTheOldFileWhenTheFolderCannotBeWritten) {
  if (::geteuid() == 0) GTEST_SKIP() << "the superuser may write everywhere";
  base::write_file(path("a"), "old");
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_THROW(base::write_file(path("a"), "new"), base::Error);
  EXPECT_EQ(content(path("a")), "old");
}

TEST_F(WriteFile, ShowsReadersTheOldOrTheNewFileNeverAMixture) {
  const std::string a(200'000, 'a');
  const std::string b(300'000, 'b');
  base::write_file(path("f"), a);
  std::jthread writer([&](const std::stop_token& stop) {
    for (int i = 0; !stop.stop_requested(); ++i) base::write_file(path("f"), i % 2 == 0 ? b : a);
  });
  for (int i = 0; i < 300; ++i) {
    const std::string seen = content(path("f"));
    ASSERT_TRUE(seen == a || seen == b) << seen.size() << " bytes";
  }
}

TEST_F(WriteFile, GivenUpLeavesNothingUnfinishedAndLetsNothingNewAppear) {
  base::write_file(path("a"), "old");
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    std::vector<std::jthread> writers;
    for (int k = 0; k < 4; ++k)
      writers.emplace_back([&, k] {
        for (int i = 0;; ++i)
          base::write_file(path("w" + std::to_string(k)),
                           std::string(100'000, static_cast<char>('a' + i % 26)));
      });
    base::FileWriter begun(path("a"));
    begun.append("new");
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    base::abandon_writes();
    std::string seen;
    for (const auto& entry : fs::directory_iterator(folder_))
      seen += entry.path().filename().string() + content(entry.path().string());
    std::jthread late([&] { begun.commit(); });
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    std::string after;
    for (const auto& entry : fs::directory_iterator(folder_))
      after += entry.path().filename().string() + content(entry.path().string());
    ::_exit(seen == after ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_EQ(content(path("a")), "old");
  for (const auto& entry : fs::directory_iterator(folder_))
    EXPECT_NE(entry.path().filename().string()[0], '.') << entry.path();
}

TEST_F(WriteFile, RemovesWhatAKilledWriterLeftAndNothingElse) {
  const auto make = [&](const std::string& name) { std::ofstream(path(name)) << "x"; };
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    base::FileWriter begun(path("a"));
    begun.append("half");
    ::_exit(0);  // as killed: nothing is cleaned up
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_EQ(files(), 1u) << "the test needs a leftover";
  make(".b.12-3.part");
  make(".a.12.part");
  make(".a.old-1.part");
  make("a.12-3.part");
  base::FileWriter other(path("a"));  // still at work
  base::write_file(path("a"), "new");
  EXPECT_EQ(content(path("a")), "new");
  EXPECT_EQ(files(), 6u);
  other.append("newer");
  other.commit();
  EXPECT_EQ(content(path("a")), "newer");
  EXPECT_EQ(files(), 5u);
}

TEST_F(WriteFile, FollowsLinksAndWritesThroughWhatIsNoFile) {
  base::write_file(path("real"), "old");
  fs::create_symlink("real", path("link"));
  fs::create_symlink("link", path("link to link"));
  base::check_writable(path("link to link"));
  base::write_file(path("link to link"), "new");
  EXPECT_TRUE(fs::is_symlink(path("link")) && fs::is_symlink(path("link to link")));
  EXPECT_EQ(content(path("real")), "new");
  fs::create_symlink("not there yet", path("dangling"));
  base::write_file(path("dangling"), "made");
  EXPECT_TRUE(fs::is_symlink(path("dangling")));
  EXPECT_EQ(content(path("not there yet")), "made");
  fs::create_symlink("loop", path("loop"));
  EXPECT_THROW(base::write_file(path("loop"), "x"), base::Error);
  EXPECT_THROW(base::check_writable(path("loop")), base::Error);

  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);
  std::string received;
  {
    std::jthread reader([&] { received = content(path("fifo")); });
    base::check_writable(path("fifo"));
    base::write_file(path("fifo"), "through");
  }
  EXPECT_EQ(received, "through");
  EXPECT_TRUE(fs::is_fifo(path("fifo")));

  if (::geteuid() == 0 && ::mknod(path("null").c_str(), S_IFCHR | 0666, makedev(1, 3)) == 0) {
    const int opened = ::open(path("null").c_str(),
                              O_WRONLY | O_CLOEXEC);  // refused where devices may not be used
    if (opened >= 0) base::write_file(path("null"), "gone");
    ::close(opened);
    EXPECT_TRUE(fs::is_character_file(path("null")));
  }
  base::write_file("/dev/null", "gone");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  if (::geteuid() == 0 && ::mknod(path("disk").c_str(), S_IFBLK | 0600, makedev(7, 250)) == 0) {
    EXPECT_THROW(base::write_file(path("disk"), "x"), base::Error);
    EXPECT_TRUE(fs::is_block_file(path("disk")));
  }
}

TEST_F(WriteFile, WritesStandardOutputWhereverThatGoes) {
  for (const char* name : {"-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"}) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const int out = ::open(path("out").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      ::dup2(out, 1);
      bool good = ::write(1, "before ", 7) == 7;
      try {
        base::check_writable(name);
        base::write_file(name, "bytes");
      } catch (const base::Error&) {
        good = false;
      }
      good = good && ::write(1, " after", 6) == 6;
      ::_exit(good ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << name;
    EXPECT_EQ(content(path("out")), "before bytes after") << name;
    EXPECT_EQ(files(), 1u) << name;
  }
}

TEST_F(WriteFile, SaysBeforehandWhetherItCouldWrite) {
  base::check_writable(path("a"));
  base::check_writable_folder(folder_.string());
  base::check_writable_folder(path("new/and/deep"));
  EXPECT_EQ(files(), 0u);
  EXPECT_THROW(base::check_writable(path("missing/a")), base::Error);
  EXPECT_THROW(base::check_writable(folder_.string()), base::Error);
  base::write_file(path("a"), "x");
  EXPECT_THROW(base::check_writable_folder(path("a")), base::Error);
  EXPECT_THROW(base::check_writable_folder(path("a/b")), base::Error);
  EXPECT_THROW(base::check_writable(path("a/b")), base::Error);
  if (::geteuid() == 0) return;
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_THROW(base::check_writable(path("a")), base::Error);
  EXPECT_THROW(base::check_writable_folder(path("b")), base::Error);
}

TEST_F(WriteFile, HashesLikeThePublishedExamples) {
  // FIPS 180-2, appendix B.1 and B.3.
  base::write_file(path("abc"), "abc");
  EXPECT_EQ(base::sha256_of_file(path("abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  base::write_file(path("million"), std::string(1'000'000, 'a'));
  EXPECT_EQ(base::sha256_of_file(path("million")),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_THROW(base::sha256_of_file(path("missing")), base::Error);
  EXPECT_THROW(base::sha256_of_file(folder_.string()), base::Error);
}

}  // namespace write_file_test
