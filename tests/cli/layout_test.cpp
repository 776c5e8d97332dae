// The borders between the libraries.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <utility>

#include "support/listed.h"
#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"
#include "support/sources.h"

namespace cli {
namespace layout_test {

namespace fs = std::filesystem;
using support::listed, support::sources_of_lib_and_tools;

std::vector<std::pair<fs::path, std::string>> includes_below(const fs::path& folder) {
  std::vector<std::pair<fs::path, std::string>> found;
  static const std::regex include("#\\s*include\\s*[<\"]([^>\"]+)[>\"].*");
  static const std::set<std::string> kSources = {".cpp", ".h", ".in"};
  for (auto entry = fs::recursive_directory_iterator(folder); entry != fs::end(entry); ++entry) {
    // Packages fetched for the report page are not ours.
    if (entry->path().filename() == "node_modules") entry.disable_recursion_pending();
    if (!entry->is_regular_file() || !kSources.contains(entry->path().extension().string()))
      continue;
    std::istringstream lines(read(entry->path()));
    std::smatch name;
    for (std::string line; std::getline(lines, line);)
      if (line.starts_with("#") && std::regex_match(line, name, include))
        found.emplace_back(entry->path(), name[1].str());
  }
  return found;
}

TEST(Layout, CrgConfiguresAlone) {
  const Folder folder;
  EXPECT_EQ(std::system(fmt::format("cmake -S '{}/lib/crg' -B '{}' > '{}' 2>&1", places::source(),
                                    folder / "build", folder / "log")
                            .c_str()),
            0)
      << read(folder / "log");
}

// A program that configure did not find must not be started by the build.
TEST(Layout, BuildStartsNothingThatConfigureDidNotFind) {
  const fs::path build = fs::path(places::crgbuild()).parent_path().parent_path().parent_path();
  const std::string rules = read(build / "build.ninja");
  ASSERT_THAT(rules, ::testing::HasSubstr("crgbuild"));
  EXPECT_THAT(rules, ::testing::Not(::testing::HasSubstr("NOTFOUND")));
}

TEST(Layout, CrgIncludesItselfAndTheStandardLibraryOnly) {
  // Headers of the system that memory mapping and CPU dispatch need.
  const std::regex system(
      "(sys/.*|std[a-z]+\\.h|unistd\\.h|fcntl\\.h|[ei]mmintrin\\.h|windows\\.h|io\\.h|cpuid\\.h)");
  const fs::path crg = fs::path(places::source()) / "lib/crg";
  std::set<std::string> of_its_own;
  for (const auto& entry : fs::recursive_directory_iterator(crg / "src"))
    of_its_own.insert(entry.path().filename().string());
  for (const auto& [file, name] : includes_below(crg))
    EXPECT_TRUE(name.starts_with("crg/") || name.starts_with("crg.") ||
                name.find_first_of("/.") == std::string::npos || of_its_own.contains(name) ||
                std::regex_match(name, system))
        << file << " includes " << name;
}

TEST(Layout, NoHeavyHeaderBelowAnyIncludeFolder) {
  const std::regex heavy(
      "(assimp|embree|yaml-cpp|nlohmann|GeographicLib|pcl|ceres|cairo|openssl|CLI|fmt|boost|"
      "re2)"
      "([0-9]*)[/.].*|(cairo|png)\\.h");
  for (const auto& library : fs::directory_iterator(fs::path(places::source()) / "lib")) {
    if (!fs::exists(library.path() / "include")) continue;
    for (const auto& [file, name] : includes_below(library.path() / "include"))
      EXPECT_FALSE(std::regex_match(name, heavy) && file.filename() != "program.h" &&
                   name != "nlohmann/json_fwd.hpp")  // names alone
          << file << " includes " << name;
  }
}

TEST(Layout, CommandLinesStayInOneFilePerTool) {
  std::set<fs::path> files;
  for (const char* below : {"lib", "tools"})
    for (const auto& [file, name] : includes_below(fs::path(places::source()) / below))
      if (name == "command/program.h" || name.starts_with("CLI/"))
        files.insert(file.lexically_relative(places::source()));
  for (const fs::path& file : files)
    EXPECT_TRUE(file.filename() == "main.cpp" || file.native().starts_with("lib/command/")) << file;
  EXPECT_GE(files.size(), 4u);
}

// What builds slowly, may be missing one day or is replaced by another stays behind few sources.
TEST(Layout, EachHeavyLibraryStaysInTwoFilesOfALibrary) {
  // JSON alone stands in more: the page's files, numbers and messages.
  const std::map<std::pair<std::string, std::string>, std::size_t> more = {
      {{"view", "nlohmann/json.hpp"}, 3}};
  std::map<std::string, std::vector<std::pair<fs::path, std::string>>> includes;
  for (const auto& library : fs::directory_iterator(fs::path(places::source()) / "lib"))
    includes[library.path().filename().string()] = includes_below(library.path());
  for (const char* heavy :
       {"assimp/", "embree3/", "GeographicLib/", "yaml-cpp/", "nlohmann/json.hpp", "pcl/", "ceres/",
        "pugixml", "re2/", "draco/", "openssl/", "meshoptimizer", "httplib", "sqlite3", "minizip/",
        "zstd", "lz4"}) {
    std::size_t in_all = 0;
    for (const auto& [library, all] : includes) {
      std::set<fs::path> files;
      for (const auto& [file, name] : all)
        if (name.starts_with(heavy)) files.insert(file);
      const auto known = more.find({library, heavy});
      EXPECT_LE(files.size(), known == more.end() ? 2u : known->second)
          << library << " has " << heavy << " in " << ::testing::PrintToString(files);
      if (known != more.end()) {
        EXPECT_EQ(files.size(), known->second) << "lower the number";
      }
      in_all += files.size();
    }
    EXPECT_GE(in_all, 1u) << heavy << " is required but not used";
  }
}

// PCL's headers take half a minute to compile, and it may be missing.
TEST(Layout, PclStaysInOneSourceFile) {
  std::set<fs::path> files;
  for (const char* below : {"lib", "tools"})
    for (const auto& [file, name] : includes_below(fs::path(places::source()) / below))
      if (name.starts_with("pcl/")) files.insert(file.lexically_relative(places::source()));
  EXPECT_EQ(files, std::set<fs::path>{"lib/cloud/src/points/pcl_headers.h"});
}

// It may be missing.
TEST(Layout, CycloneDdsStaysInTwoSourceFiles) {
  std::set<fs::path> files;
  for (const char* below : {"lib", "tools"})
    for (const auto& [file, name] : includes_below(fs::path(places::source()) / below))
      if (name.starts_with("dds/") || name == "ros2.h" || name == "kerbstone.h")
        files.insert(file.lexically_relative(places::source()));
  EXPECT_EQ(files, (std::set<fs::path>{"lib/sim/src/serve/dds.cpp",
                                       "lib/sim/src/serve/dds_messages.cpp"}));
}

TEST(Layout, BaseKnowsNoNeighbourAndAloneHashes) {
  const fs::path base = fs::path(places::source()) / "lib/base";
  for (const auto& [file, name] : includes_below(base))
    EXPECT_FALSE(name.starts_with("mesh/") || name.starts_with("road/") ||
                 name.starts_with("crg/") || name.starts_with("vehicle/") ||
                 name.starts_with("report/"))
        << file << " includes " << name;
  for (const char* folder : {"lib", "tools"})
    for (const auto& [file, name] : includes_below(fs::path(places::source()) / folder))
      EXPECT_FALSE(name.starts_with("openssl/") && file != base / "src/sha256.cpp")
          << file << " includes " << name;
}

// base::abandon_writes() and the removal of leftovers reach every file only so.
TEST(Layout, ToolsWriteFilesThroughBaseAlone) {
  const auto writes = [](const std::string& text) {
    static constexpr const char* kWriters[] = {"crg::write(", "ofstream", "fopen(",
                                               "O_WRONLY",    "O_CREAT",  "mkstemp"};
    return std::any_of(std::begin(kWriters), std::end(kWriters),
                       [&](const char* writer) { return text.find(writer) != text.npos; });
  };
  for (const std::string& name : support::cpp_of_lib_and_tools()) {
    if (name.starts_with("lib/base/") || name.starts_with("lib/crg/")) continue;
    EXPECT_FALSE(writes(read(fs::path(places::source()) / name))) << name;
  }
}

// What is longer is read by nobody from end to end: it is split along its subjects.
TEST(Layout, FilesAreShort) {
  constexpr std::ptrdiff_t kMostLines = 400;
  constexpr std::size_t kMostWithAReason = 5;
  std::map<std::string, std::string> known = listed("long_files.txt");
  std::size_t with_a_reason = 0;
  for (const auto& [name, reason] : known) with_a_reason += reason != "to split";
  EXPECT_LE(with_a_reason, kMostWithAReason);
  const std::vector<std::string> sources = sources_of_lib_and_tools();
  ASSERT_GT(sources.size(), 300u);
  for (const std::string& name : sources) {
    const std::string text = read(fs::path(places::source()) / name);
    const auto lines = std::count(text.begin(), text.end(), '\n');
    if (lines <= kMostLines) continue;
    EXPECT_EQ(known.erase(name), 1u) << name << " has " << lines << " lines, at most " << kMostLines
                                     << " wanted: split it along its subjects";
  }
  for (const auto& [name, reason] : known)
    ADD_FAILURE() << name << ": not there or short enough now; take it off tests/long_files.txt";
}

// What is wider is read by nobody without scrolling. The pages' scripts have a width of their own.
TEST(Layout, LinesKeepToTheColumnsOfTheFormat) {
  constexpr std::ptrdiff_t kColumns = 100;
  for (const std::string& name : sources_of_lib_and_tools()) {
    const std::string ending = fs::path(name).extension().string();
    if (ending != ".cpp" && ending != ".h" && ending != ".def") continue;
    if (name == "lib/opencrg/include/crgBaseLib.h") continue;  // a C header of others' names
    std::istringstream lines(read(fs::path(places::source()) / name));
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      const auto columns = std::count_if(line.begin(), line.end(), [](char c) {
        return (static_cast<unsigned char>(c) & 0xc0) != 0x80;  // no further byte of a letter
      });
      EXPECT_LE(columns, kColumns) << name << ":" << number;
    }
  }
}

TEST(Layout, ReportKnowsNeitherRoadNorCrg) {
  for (const auto& [file, name] : includes_below(fs::path(places::source()) / "lib/report"))
    EXPECT_FALSE(name.starts_with("mesh/") || name.starts_with("road/") ||
                 name.starts_with("crg/") || name.starts_with("vehicle/"))
        << file << " includes " << name;
}

/// The .cpp and .h below these folders with a line that the pattern of Perl finds. By grep:
/// std::regex takes ten seconds for them.
std::set<std::string> files_with(const std::string& pattern,
                                 const std::vector<std::string>& folders) {
  std::vector<std::string> words{"-rlP", "--include=*.cpp", "--include=*.h", "--", pattern};
  for (const std::string& folder : folders) words.push_back(places::source() + "/" + folder);
  std::istringstream found(support::run_tool("/bin/grep", words).out);
  std::set<std::string> files;
  for (std::string file; std::getline(found, file);)
    files.insert(file.substr(places::source().size() + 1));
  return files;
}

// A copy of a law drifts from it: what tells a constant or a law of the car, literal or parameter,
// stands in one file of the libraries, and everybody else calls the law. The room sheet only writes
// values of parameters.
TEST(Layout, EachLawOfTheCarStandsInOneFile) {
  struct Telling {
    const char* what;
    const char* pattern;
    const char* file;
  };
  static constexpr Telling kTelling[] = {
      {"gas constant", R"(\b287(\.0)?\b)", "laws/turbocharger.h"},
      {"heat capacity of air", R"(\b1004\.5)", "laws/turbocharger.h"},
      {"conductivity of air", R"([=*/] *0\.026\b|\b0\.026 *[*/])", "laws/brake_disc.h"},
      {"viscosity of air", R"(\b1\.6e-0?5\b)", "laws/brake_disc.h"},
      {"Stefan and Boltzmann", R"(\b5\.67\d*e-0?8)", "laws/disc_heat.h"},
      {"radiation", R"(brake_emissivity)", "laws/disc_heat.h"},
      {"convection", R"(brake_nusselt_(disc|car|still))", "laws/disc_heat.h"},
      {"heat capacity of discs", R"(brake_capacity_slope_1pk)", "laws/disc_heat.h"},
      {"fade of pads", R"(\b0\.95\b.*\bfade|fade.*\b0\.95\b)", "laws/brake_pads.h"},
      {"heat per which fade is told", R"(0\.75e0?6|\b750e3|\b750000)",
       "mechanisms/brake_friction_temperature.cpp"},
      {"boost", R"(turbo_(idle_flow|fall_s))", "laws/boost.h"},
      {"warm-up", R"(/ 8(\.0)?\b.*0\.2|0\.2 .*/ 8(\.0)?\b)", "laws/tyre_warm_up.h"},
      {"tread temperature", R"(tyre_(cold_width|hot_width|slip_share|road_cooling))",
       "laws/tyre_heat.h"},
      {"limiter", R"(0\.02 \* (p\[P::engine_)?limit)", "laws/engine.h"},
      {"idle control", R"(engine_idle_gain)", "laws/engine.h"},
      {"fuel", R"(fuel_(efficiency|energy_jpkg)\] *[*)/])", "laws/fuel.h"},
      {"limited slip", R"(differential_(preload|drive_ramp|coast_ramp))", "laws/driveline.h"},
      {"steering geometry", R"(steering_ackermann)", "laws/suspension.h"},
      {"dampers", R"(damper_(knee|fast_share))", "laws/suspension.h"},
      {"side force of the air", R"(aero_side_area)", "laws/aero.h"},
  };
  ASSERT_GT(files_with("^", {"lib/vehicle", "lib/explain"}).size(), 100u);
  for (const Telling& telling : kTelling) {
    std::set<std::string> files = files_with(telling.pattern, {"lib/vehicle", "lib/explain"});
    std::erase_if(
        files, [](const std::string& name) { return name.starts_with("lib/vehicle/src/sheet/"); });
    EXPECT_EQ(files.size(), 1u) << telling.what << ": " << ::testing::PrintToString(files);
    for (const std::string& file : files)
      EXPECT_THAT(file, ::testing::EndsWith(telling.file)) << telling.what;
  }
}

// Quotes, decimal commas and rows of another length are looked after there alone.
TEST(Layout, TablesAreSplitByBaseAlone) {
  const std::map<std::string, std::string> others{
      {"lib/campaign/src/table.cpp", "quotes what it writes"},
      {"lib/cloud/src/files/text_records.cpp", "clouds: blanks separate too, millions of rows"},
      {"lib/cloud/src/files/wkt.cpp", "parts of a coordinate system"},
      {"lib/crg/src/file/header.cpp", "channels of a CRG header; knows no neighbour"},
      {"lib/explain/src/signals/late_together.cpp", "names of columns that it joined itself"},
      {"lib/explain/src/signals/sides.cpp", "names of columns that it joined itself"},
      {"lib/make/src/make/key_kinds.cpp", "x,y of a flag"},
      {"lib/recording/src/log/csv.cpp", "commas inside of numbers"},
      {"lib/recording/src/log/csv_shape.cpp", "what separates cells; base splits"},
      {"lib/recording/src/log/message_types.cpp", "types of messages"},
      {"lib/recording/src/table/table.cpp", "an axis of a map with a decimal comma"},
      {"lib/road/src/guide/guide_file.cpp", "coordinates of KML"},
      {"tools/crgidentify/drive_part.cpp", "two numbers of a flag"},
      {"tools/crgsim/table.cpp", "quotes what it writes"},
      {"tools/kerbstone/open.cpp", "quotes what it writes"}};
  std::set<std::string> files = files_with(
      "(find|find_first_of|getline)\\([^()]*'[,;]'|find_first_of\\(\"[^\"]*[,;]|[=!]= '[,;]'",
      {"lib", "tools"});
  std::erase_if(files, [](const std::string& name) { return name.starts_with("lib/base/"); });
  for (const std::string& file : files)
    EXPECT_TRUE(others.contains(file))
        << file << " splits text at commas by hand; use base/table_form.h";
  for (const auto& [file, reason] : others)
    EXPECT_TRUE(files.contains(file)) << file << " (" << reason << ") no longer does; take it out";
}

TEST(Layout, CommandLineParserStaysInOneFilePerTool) {
  for (const auto& tool : fs::directory_iterator(fs::path(places::source()) / "tools")) {
    if (!tool.is_directory()) continue;
    int files = 0;
    for (const auto& [file, name] : includes_below(tool.path())) files += name.starts_with("CLI/");
    EXPECT_LE(files, 1) << tool.path();
  }
}

}  // namespace layout_test
}  // namespace cli
