#include "files/write_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "files/error.h"
#include "files/sha256.h"

namespace {

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
  files::write_file(path("a.bin"), bytes);
  EXPECT_EQ(content(path("a.bin")), bytes);
  files::write_file(path("a.bin"), "short");
  EXPECT_EQ(content(path("a.bin")), "short");
  files::write_file(path("empty"), "");
  EXPECT_EQ(content(path("empty")), "");
  EXPECT_EQ(files(), 2u);
}

TEST_F(WriteFile, IsReadableLikeAnOrdinaryFileAndKeepsPermissions) {
  files::write_file(path("a"), "x");
  const mode_t mask = ::umask(022);
  ::umask(mask);
  struct stat status {};
  ASSERT_EQ(::stat(path("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0666 & ~mask);
  ASSERT_EQ(::chmod(path("a").c_str(), 0640), 0);
  files::write_file(path("a"), "y");
  ASSERT_EQ(::stat(path("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST_F(WriteFile, NamesPathAndReasonWhenTheFolderIsMissingOrTheTargetIsAFolder) {
  try {
    files::write_file(path("missing/a"), "x");
    FAIL();
  } catch (const files::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(path("missing/a")));
    EXPECT_THAT(error.what(), HasSubstr("No such file or directory"));
  }
  fs::create_directories(path("folder"));
  EXPECT_THROW(files::write_file(path("folder"), "x"), files::Error);
  EXPECT_EQ(files(), 1u);
}

TEST_F(WriteFile, KeepsTheOldFileWhenTheFolderCannotBeWritten) {
  if (::geteuid() == 0) GTEST_SKIP() << "the superuser may write everywhere";
  files::write_file(path("a"), "old");
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_THROW(files::write_file(path("a"), "new"), files::Error);
  EXPECT_EQ(content(path("a")), "old");
}

TEST_F(WriteFile, ShowsReadersTheOldOrTheNewFileNeverAMixture) {
  const std::string a(200'000, 'a');
  const std::string b(300'000, 'b');
  files::write_file(path("f"), a);
  std::jthread writer([&](const std::stop_token& stop) {
    for (int i = 0; !stop.stop_requested(); ++i) files::write_file(path("f"), i % 2 == 0 ? b : a);
  });
  for (int i = 0; i < 300; ++i) {
    const std::string seen = content(path("f"));
    ASSERT_TRUE(seen == a || seen == b) << seen.size() << " bytes";
  }
}

TEST_F(WriteFile, HashesLikeThePublishedExamples) {
  // FIPS 180-2, appendix B.1 and B.3.
  files::write_file(path("abc"), "abc");
  EXPECT_EQ(files::sha256_of_file(path("abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  files::write_file(path("million"), std::string(1'000'000, 'a'));
  EXPECT_EQ(files::sha256_of_file(path("million")),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_THROW(files::sha256_of_file(path("missing")), files::Error);
  EXPECT_THROW(files::sha256_of_file(folder_.string()), files::Error);
}

}  // namespace
