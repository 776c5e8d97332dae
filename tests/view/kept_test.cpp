#include "kept.h"

#include <gtest/gtest.h>

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

}  // namespace kept_test
