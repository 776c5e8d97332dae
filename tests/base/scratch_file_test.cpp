#include "base/scratch_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/error.h"
#include "support/temporary_folder.h"

namespace scratch_file_test {

TEST(ScratchFile, GivesBackWhatItWasGivenAndIsSeenByNobody) {
  const support::TemporaryFolder folder;
  base::ScratchFile file(folder.path("scratch"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path("")));
  const std::string bytes = std::string("ab\0c", 4) + std::string(3'000'000, 'd') + "e";
  file.append(bytes);
  file.append("");
  file.append("fg");
  EXPECT_EQ(file.size(), bytes.size() + 2);
  std::string read(bytes.size() + 2, '\0');
  file.read(0, read.data(), read.size());
  EXPECT_TRUE(read == bytes + "fg");
  file.read(3'000'004, read.data(), 3);
  EXPECT_EQ(read.substr(0, 3), "efg");
  EXPECT_THROW(file.read(3'000'004, read.data(), 4), base::Error);
}

TEST(ScratchFile, IsRefusedWhereItCannotBe) {
  const support::TemporaryFolder folder;
  EXPECT_THROW(base::ScratchFile(folder.path("none/scratch")), base::Error);
  folder.file("there", "kept");
  EXPECT_THROW(base::ScratchFile(folder.path("there")), base::Error);
  EXPECT_EQ(folder.read("there"), "kept");
}

}  // namespace scratch_file_test
