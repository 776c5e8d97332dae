// Damaged files: whatever is refused names the file and the place in it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>

#include "crg/error.h"
#include "crg/surface.h"
#include "fuzz/mutated.h"
#include "roads.h"
#include "support/places.h"

namespace crg {
namespace damaged_test {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// What reading the file at `path` and making a road of it is refused with; "" when it is not.
std::string refusal_of(const std::string& path) {
  try {
    const Surface surface(read(path));
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

/// A line, a byte, a key of the header or one of its sections.
bool names_a_place(const std::string& message, const std::string& path) {
  static const std::regex place(
      R"(^(:\d+:|: byte \d+:| ?:.*(\$[A-Z][A-Z_]+|[A-Z]+_[A-Z_]+[A-Z])))");
  const std::size_t at = message.find(path);
  return at != std::string::npos &&
         std::regex_search(message.begin() + static_cast<std::ptrdiff_t>(at + path.size()),
                           message.end(), place);
}

TEST(Damaged, EveryRefusalNamesTheFileAndThePlaceInIt) {
  std::vector<fs::path> seeds;
  std::error_code absent;
  for (const fs::path& folder : {fs::path(places::source()) / "tests/corpus/crg",
                                 fs::path(places::data()) / "opencrg/samples"}) {
    for (const auto& entry : fs::directory_iterator(folder, absent)) seeds.push_back(entry.path());
  }
  std::sort(seeds.begin(), seeds.end());
  ASSERT_GE(seeds.size(), 20U);
  const test::Folder folder;
  std::mt19937_64 random(16);
  std::size_t refused = 0, read_all_the_same = 0, nameless = 0;
  for (const fs::path& seed : seeds) {
    const std::string whole = bytes_of(seed);
    if (whole.size() > 200'000) continue;
    const std::string path = folder.file(seed.filename().string());
    for (int k = 0; k < 80; ++k) {
      std::ofstream(path, std::ios::binary) << fuzz::mutated(whole, random, 2000);
      const std::string message = refusal_of(path);
      if (message.empty()) {
        ++read_all_the_same;
        continue;
      }
      ++refused;
      if (!names_a_place(message, path) && nameless++ < 20) ADD_FAILURE() << message;
    }
  }
  EXPECT_EQ(nameless, 0U) << "of " << refused;
  EXPECT_GT(refused, 1000U);
  EXPECT_GT(read_all_the_same, 100U);
  std::printf("%zu refused, %zu read all the same\n", refused, read_all_the_same);
}

TEST(Damaged, AnIncludeThatCannotBeOpenedNamesTheIncludingFileAndItsLine) {
  const test::Folder folder;
  const std::string path = folder.file("outer.crg");
  const auto refusal = [&](const std::string& target) {
    std::ofstream(path) << "$CT\na road elsewhere\n$ROAD_CRG_FILE\n" << target << "\n$\n$$$$\n";
    return refusal_of(path);
  };
  EXPECT_EQ(refusal("missing.crg"),
            path + ":4: $ROAD_CRG_FILE: missing.crg: cannot open: No such file or directory");
  EXPECT_EQ(
      refusal(" $NO_SUCH_FOLDER_OF_ROADS/road.crg"),
      path + ":4: $ROAD_CRG_FILE: the environment variable NO_SUCH_FOLDER_OF_ROADS is not set");
  EXPECT_EQ(refusal("."),
            path + ":4: $ROAD_CRG_FILE: " + folder.file(".") + ": not a regular file");
  EXPECT_EQ(refusal("outer.crg"), path + ":4: $ROAD_CRG_FILE: " + path +
                                      " has no data of its own: includes go one level deep");
  // What is wrong in the included file is told of that file.
  std::ofstream(folder.file("inner.crg")) << "$ROAD_CRG\nREFERENCE_LINE_INCREMENT = x\n$$$$\n";
  EXPECT_EQ(refusal("inner.crg").substr(0, folder.file("inner.crg:2: ").size()),
            folder.file("inner.crg:2: "));
}

}  // namespace damaged_test
}  // namespace crg
