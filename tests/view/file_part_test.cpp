#include "file_part.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/temporary_folder.h"
#include "wish.h"

namespace file_part_test {

int status(const std::string& path, const std::string& begin, const std::string& bytes) {
  try {
    view::part_of_file(path, begin, bytes);
  } catch (const view::Refusal& refusal) {
    return refusal.status;
  }
  return 200;
}

TEST(FilePart, IsWhatLiesThere) {
  const support::TemporaryFolder folder;
  const std::string path = folder.file("points.tiles", std::string("ab\0defg", 7));
  EXPECT_EQ(view::part_of_file(path, "0", "7"), std::string("ab\0defg", 7));
  EXPECT_EQ(view::part_of_file(path, "2", "3"), std::string("\0de", 3));
  EXPECT_EQ(view::part_of_file(path, "7", "0"), "");
}

TEST(FilePart, OfAnythingElseIsRefusedBeforeMemoryIsTaken) {
  const support::TemporaryFolder folder;
  const std::string path = folder.file("points.tiles", "abcdefg");
  const std::string most = std::to_string(std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(status(folder.file("secret.csv", "abcdefg"), "0", "1"), 403);
  for (const char* wrong : {"", "x", "-1", "1.5", " 1", "0x1", "99999999999999999999999"}) {
    EXPECT_EQ(status(path, wrong, "1"), 400) << wrong;
    EXPECT_EQ(status(path, "0", wrong), 400) << wrong;
  }
  EXPECT_EQ(status(path, "0", "8"), 416);
  EXPECT_EQ(status(path, "8", "0"), 416);
  EXPECT_EQ(status(path, "7", "1"), 416);
  EXPECT_EQ(status(path, most, "1"), 416);
  EXPECT_EQ(status(path, "1", "16000000"), 416);
  EXPECT_EQ(status(path, "0", most), 400);
  EXPECT_EQ(status(path, "0", "16000001"), 400);
}

}  // namespace file_part_test
