#include "sim/unpack.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <set>

#include "base/error.h"
#include "base/read_file.h"
#include "fmu/archive.h"
#include "support/temporary_folder.h"

namespace unpack_test {

using ::testing::HasSubstr;

std::string refusal(const std::string& path) {
  try {
    const sim::UnpackedUnit unit(path);
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}

TEST(Unpack, TakesWhatThisPlatformNeedsAndLeavesNothing) {
  const support::TemporaryFolder folder;
  folder.file("u.fmu", fmu::make_archive({{"modelDescription.xml", "<x/>"},
                                          {"resources/", ""},
                                          {"resources/deep/a.txt", "a"},
                                          {"resources/deep/a.txt", "a"},
                                          {"resources/", ""},
                                          {"binaries/linux64/u.so", "so"},
                                          {"binaries/win64/u.dll", "dll"},
                                          {"documentation/index.html", "doc"}}));
  std::string made;
  {
    const sim::UnpackedUnit unit(folder.path("u.fmu"));
    made = unit.folder();
    EXPECT_EQ(base::read_file(made + "/resources/deep/a.txt"), "a");
    EXPECT_EQ(base::read_file(made + "/binaries/linux64/u.so"), "so");
    EXPECT_FALSE(std::filesystem::exists(made + "/binaries/win64"));
    EXPECT_FALSE(std::filesystem::exists(made + "/documentation"));
  }
  EXPECT_FALSE(std::filesystem::exists(made));
  const sim::UnpackedUnit one(folder.path("u.fmu")), other(folder.path("u.fmu"));
  EXPECT_NE(one.folder(), other.folder());
  EXPECT_EQ(sim::model_description_of(folder.path("u.fmu")), "<x/>");
}

TEST(Unpack, RefusesHostileArchivesInOneLine) {
  const support::TemporaryFolder folder;
  const auto of = [&](const std::vector<fmu::ArchiveFile>& files) {
    folder.file("u.fmu", fmu::make_archive(files));
    return refusal(folder.path("u.fmu"));
  };
  for (const char* const name : {"../out.txt", "resources/../../out.txt", "/tmp/out.txt",
                                 "resources\\..\\..\\out.txt", "resources/.."})
    EXPECT_THAT(of({{"modelDescription.xml", "<x/>"}, {name, "x"}}),
                HasSubstr("would lie outside of the unit's folder"))
        << name;
  EXPECT_FALSE(std::filesystem::exists("/tmp/out.txt"));
  EXPECT_THAT(of({{"modelDescription.xml", "<x/>"}, {"modelDescription.xml", "<y/>"}}),
              HasSubstr("two files are called"));
  EXPECT_THAT(of({{"resources/a", "a"}}), HasSubstr("no modelDescription.xml in it"));
  folder.file("u.fmu", "not a zip");
  EXPECT_THAT(refusal(folder.path("u.fmu")), HasSubstr("cannot be opened as a zip"));
  EXPECT_THAT(refusal(folder.path("none.fmu")), HasSubstr("none.fmu"));
  // 120 MB of blanks in 120 kB.
  const std::string blanks(120'000'000, ' ');  // NOLINT(bugprone-string-constructor)
  folder.file("u.fmu", fmu::make_archive({{"modelDescription.xml", blanks}}));
  EXPECT_THROW(sim::model_description_of(folder.path("u.fmu")), base::Error);
  // Cut short, and with a byte changed.
  const std::string whole = fmu::make_archive(
      {{"modelDescription.xml", "<x/>"}, {"resources/a", std::string(5000, 'a')}});
  for (const std::size_t size : {whole.size() - 30, whole.size() / 2, std::size_t{30}}) {
    folder.file("u.fmu", whole.substr(0, size));
    EXPECT_NE(refusal(folder.path("u.fmu")), "") << size;
  }
  std::string changed = whole;
  changed[whole.find("resources/a") + 15] ^= 0x10;
  folder.file("u.fmu", changed);
  EXPECT_THAT(refusal(folder.path("u.fmu")), HasSubstr("resources/a is damaged"));
}

TEST(Unpack, FoldersOfKilledRunsAreRemovedAndNoOthers) {
  const support::TemporaryFolder folder;
  folder.file("u.fmu", fmu::make_archive({{"modelDescription.xml", "<x/>"}}));
  const std::string tmp = folder.path("tmp");
  for (const char* const made : {"/kerbstone-unit-abcdef/deep", "/kerbstone-unit-locked",
                                 "/kerbstone-unit-longer1", "/of_another_program", "/linked"})
    std::filesystem::create_directories(tmp + made);
  std::filesystem::create_directory_symlink(tmp + "/linked", tmp + "/kerbstone-unit-alink1");
  std::filesystem::create_directories(folder.path("elsewhere"));
  std::filesystem::create_directory_symlink(folder.path("elsewhere"),
                                            tmp + "/kerbstone-unit-abcdef/deep/link");
  folder.file("elsewhere/kept.txt", "kept");
  std::filesystem::create_directories(tmp + "/kerbstone-unit-others");
  const bool is_root = ::geteuid() == 0;
  if (is_root) {
    ASSERT_EQ(::chown((tmp + "/kerbstone-unit-others").c_str(), 65534, 65534), 0);
  }
  const int lock = ::open((tmp + "/kerbstone-unit-locked").c_str(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(::flock(lock, LOCK_EX), 0);
  ::setenv("TMPDIR", tmp.c_str(), 1);
  {
    const sim::UnpackedUnit one(folder.path("u.fmu")), two(folder.path("u.fmu"));
    EXPECT_TRUE(std::filesystem::exists(one.folder())) << "it is locked while it is in use";
  }
  ::unsetenv("TMPDIR");
  ::close(lock);
  std::set<std::string> left;
  for (const auto& entry : std::filesystem::directory_iterator(tmp))
    left.insert(entry.path().filename().string());
  std::set<std::string> wanted{"kerbstone-unit-locked", "kerbstone-unit-longer1",
                               "of_another_program", "linked", "kerbstone-unit-alink1"};
  if (is_root) wanted.insert("kerbstone-unit-others");
  EXPECT_EQ(left, wanted);
  EXPECT_EQ(folder.read("elsewhere/kept.txt"), "kept");
}

TEST(Unpack, ATemporaryFolderThatIsNotThereIsOneLine) {
  const support::TemporaryFolder folder;
  folder.file("u.fmu", fmu::make_archive({{"modelDescription.xml", "<x/>"}}));
  ::setenv("TMPDIR", folder.path("none").c_str(), 1);
  EXPECT_EQ(refusal(folder.path("u.fmu")),
            "TMPDIR is '" + folder.path("none") + "', which is no folder; name one that is there");
  ::unsetenv("TMPDIR");
}

}  // namespace unpack_test
