#include "fmu/archive.h"

#include <gtest/gtest.h>

#include "unit_under_test.h"

namespace archive_test {

TEST(Archive, HoldsWhatWasPutInAndIsTheSameEachTime) {
  std::string large;
  for (int i = 0; i < 300000; ++i) large += static_cast<char>((i * i) >> 3);
  const std::vector<fmu::ArchiveFile> files{{"a.xml", "<a/>"}, {"b/c/d.bin", large}, {"e", ""}};
  const std::string bytes = fmu::make_archive(files);
  EXPECT_EQ(bytes, fmu::make_archive(files));
  const support::TemporaryFolder folder;
  const auto back = fmu_tests::unpacked(folder.file("x.zip", bytes));
  ASSERT_EQ(back.size(), 3u);
  for (const fmu::ArchiveFile& file : files) EXPECT_EQ(back.at(file.name), file.bytes);
}

}  // namespace archive_test
