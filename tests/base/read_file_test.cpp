#include "base/read_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>

#include "base/error.h"
#include "base/sha256.h"
#include "support/temporary_folder.h"

namespace read_file_test {

using ::testing::HasSubstr;

std::string refusal(const std::string& path, std::size_t largest_bytes) {
  try {
    base::read_file(path, largest_bytes);
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}

TEST(ReadFile, GivesEveryByteUpToTheLargestSize) {
  const support::TemporaryFolder folder;
  std::string bytes(200'000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 31 % 251);
  const std::string path = folder.file("a", bytes);
  EXPECT_EQ(base::read_file(path, bytes.size()), bytes);
  EXPECT_EQ(base::read_file(folder.file("empty", ""), 0), "");
  EXPECT_THAT(refusal(path, bytes.size() - 1), HasSubstr("200000 bytes, wanted at most 199999, "));
}

TEST(ReadFile, RefusesATooLargeFileWithoutReadingIt) {
  const support::TemporaryFolder folder;
  const std::string path = folder.file("a", "");
  ASSERT_EQ(::truncate(path.c_str(), off_t{1} << 33), 0);  // takes no room on the disk
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(refusal(path, std::size_t{1} << 32),
              HasSubstr(path + ": 8589934592 bytes, wanted at most 4294967296, "));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(200));
  EXPECT_THAT(refusal("/proc/self/maps", 10),
              HasSubstr(": more than 10 bytes, wanted at most 10, "));  // says that it is empty
}

TEST(ReadFile, NamesPathAndReason) {
  const support::TemporaryFolder folder;
  EXPECT_THAT(refusal(folder.path("missing"), 9),
              HasSubstr(folder.path("missing") + ": cannot open: No such file"));
  EXPECT_THAT(refusal(folder.path("."), 9), HasSubstr("is a folder, wanted a file"));
}

TEST(ReadFile, NamesAPointerOfGitLfs) {
  const support::TemporaryFolder folder;
  const std::string pointer =
      "version https://git-lfs.github.com/spec/v1\noid sha256:7711\nsize 202118652\n";
  EXPECT_THAT(
      refusal(folder.file("a.glb", pointer), 999),
      testing::AllOf(HasSubstr("a.glb: is a pointer of Git LFS"), HasSubstr("'git lfs pull'")));
  EXPECT_EQ(refusal(folder.file("b.md", "# " + pointer), 999), "");
  EXPECT_EQ(refusal(folder.file("c.md", pointer + std::string(2000, ' ')), 9999), "");
}

TEST(ReadFile, RefusesAtOnceWhatIsNoFile) {
  const support::TemporaryFolder folder;
  ASSERT_EQ(::mkfifo(folder.path("fifo").c_str(), 0600), 0);
  for (const std::string& path :
       {folder.path("fifo"), std::string("/dev/zero"), std::string("/dev/null")}) {
    EXPECT_THAT(refusal(path, 1'000'000),
                HasSubstr(path + ": is a device, a FIFO or a socket, wanted a regular file"));
    EXPECT_THROW(base::want_regular_file(path), base::Error);
    EXPECT_THROW(base::sha256_of_file(path), base::Error);
    EXPECT_FALSE(base::try_read_file(path));
    EXPECT_FALSE(base::try_sha256_of_file(path));
  }
  EXPECT_FALSE(base::try_sha256_of_file(folder.path("missing")));
}

}  // namespace read_file_test
