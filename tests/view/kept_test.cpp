#include "kept.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "support/temporary_folder.h"

namespace kept_test {

TEST(Kept, ReadsAFileAgainOnlyWhenItHasChanged) {
  const support::TemporaryFolder folder;
  int reads = 0;
  view::Kept<std::string, 2> kept([&](const std::string& path) {
    ++reads;
    return path;
  });
  const std::string a = folder.file("a", "1"), b = folder.file("b", "1"), c = folder.file("c", "1");
  EXPECT_EQ(*kept.of(a), a);
  EXPECT_EQ(*kept.of(b), b);
  EXPECT_EQ(*kept.of(a), a);
  EXPECT_EQ(reads, 2);
  folder.file("a", "12");  // another size
  EXPECT_EQ(*kept.of(a), a);
  EXPECT_EQ(reads, 3);
  kept.of(b);
  EXPECT_EQ(reads, 3) << "still there";
  kept.of(c);
  EXPECT_EQ(reads, 4);
  kept.of(b);
  EXPECT_EQ(reads, 4) << "asked for after a";
  kept.of(a);
  EXPECT_EQ(reads, 5) << "two are kept: the one that nobody asked for went";
}

TEST(Kept, ReadsAFileAgainThatHasTheSameSizeAndTime) {
  namespace fs = std::filesystem;
  const support::TemporaryFolder folder;
  view::Kept<std::string> kept(
      [&](const std::string& path) { return folder.read(fs::path(path).filename().string()); });
  const std::string path = folder.file("a", "old");
  const auto time = fs::last_write_time(path);
  EXPECT_EQ(*kept.of(path), "old");
  folder.file("b", "new");
  fs::last_write_time(folder.path("b"), time);
  fs::rename(folder.path("b"), path);  // as an archive that is unpacked puts it
  ASSERT_EQ(fs::last_write_time(path), time);
  EXPECT_EQ(*kept.of(path), "new");
  folder.file("a", "own");  // written in place, its time set back
  fs::last_write_time(path, time);
  EXPECT_EQ(*kept.of(path), "own");
}

}  // namespace kept_test
