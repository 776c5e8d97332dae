// What the documents say holds: commands run, every recipe key is described.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <vector>

#include "make/recipe.h"
#include "support/demo_circuit.h"
#include "support/places.h"
#include "support/run_crgbuild.h"

namespace cli {
namespace docs_test {

using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::string source(const std::string& path) { return read(places::source() + "/" + path); }

/// README.md, SECURITY.md and what lies in docs/.
std::vector<std::filesystem::path> pages() {
  const std::filesystem::path root(places::source());
  std::vector<std::filesystem::path> found{root / "README.md", root / "SECURITY.md"};
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") found.push_back(entry.path());
  return found;
}

int shell(const std::string& command) { return std::system(command.c_str()); }

TEST(Docs, FormatsDescribesEveryRecipeKeyWithItsDefault) {
  const std::string text = source("docs/formats.md");
  for (const road::RecipeKey& key : road::recipe_keys())
    EXPECT_THAT(text, HasSubstr(fmt::format("| `{}` | {} | {} | {} |", key.name, key.wanted,
                                            key.show(road::Recipe{}), key.meaning)));
}

TEST(Docs, FormatsDescribesEveryKeyOfTheExampleRecipe) {
  const std::string text = source("docs/formats.md");
  const std::size_t begin = text.find("```yaml\n") + 8, end = text.find("```", begin);
  const Folder folder;
  write(folder / "track.yaml", text.substr(begin, end - begin));
  EXPECT_NO_THROW(road::read_recipe(folder / "track.yaml"));
}

TEST(Docs, ReadmeFlagsExist) {
  const std::string help = crgbuild({"build", "--help"}).out, text = source("README.md");
  const std::regex flag("`(--[a-z][a-z-]*)");
  int count = 0;
  for (std::sregex_iterator i(text.begin(), text.end(), flag), end; i != end; ++i, ++count)
    EXPECT_THAT(help, HasSubstr((*i)[1].str()));
  EXPECT_GT(count, 5);
}

/// What a link to a heading of this page may be, as on GitHub.
std::set<std::string> anchors(const std::string& text) {
  std::set<std::string> found;
  std::istringstream lines(text);
  bool in_code = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) in_code = !in_code;
    if (in_code || !line.starts_with("#")) continue;
    std::string anchor = "#";
    for (const char c : line.substr(line.find(' ') + 1))
      if (c == ' ')
        anchor += '-';
      else if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_')
        anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    found.insert(anchor);
  }
  return found;
}

TEST(Docs, LinksLeadSomewhere) {
  const std::regex link("\\]\\(([^)#:]*)(#[^)]*)?\\)");
  for (const auto& page : pages()) {
    const std::string text = read(page);
    for (std::sregex_iterator i(text.begin(), text.end(), link), end; i != end; ++i) {
      const std::filesystem::path file =
          (*i)[1].length() == 0 ? page : page.parent_path() / (*i)[1].str();
      EXPECT_TRUE(exists(file)) << page << " links to " << (*i)[1];
      if ((*i)[2].matched && exists(file)) {
        EXPECT_THAT(anchors(read(file)), Contains((*i)[2].str())) << page;
      }
    }
  }
}

/// Words as wc -w counts them.
std::ptrdiff_t words_of(const std::string& text) {
  std::istringstream words(text);
  return std::distance(std::istream_iterator<std::string>(words), {});
}

// The page that `crgdrive parameters` makes (Parameters.AreDocumentedAsListed) is as long as it is.
TEST(Docs, AreShort) {
  std::ptrdiff_t in_all = 0;
  for (const auto& page : pages()) {
    const std::string name = page.filename().string();
    if (name == "vehicle_parameters.md") continue;
    const std::ptrdiff_t words = words_of(read(page));
    EXPECT_LE(words, name == "README.md" ? 900 : name == "evidence.md" ? 5000 : 2500) << page;
    if (page.parent_path() != std::filesystem::path(places::source())) in_all += words;
  }
  EXPECT_LE(in_all, 45000);
  EXPECT_GT(in_all, 20000);
  const std::string changes = source("CHANGELOG.md");
  EXPECT_LE(std::count(changes.begin(), changes.end(), '\n'), 80);
}

TEST(Docs, EvidenceIsMadeOfItsFigures) {
  EXPECT_EQ(shell("'" + places::source() + "/scripts/evidence' check"), 0);
}

TEST(Docs, LinksLeadFromTheReadmeToEveryPage) {
  namespace fs = std::filesystem;
  const std::regex link("\\]\\(([^)#:]+\\.md)(#[^)]*)?\\)");
  const fs::path root(places::source());
  std::set<fs::path> reached{root / "README.md"};
  std::vector<fs::path> unread{root / "README.md"};
  while (!unread.empty()) {
    const fs::path page = unread.back();
    unread.pop_back();
    const std::string text = read(page);
    for (std::sregex_iterator i(text.begin(), text.end(), link), end; i != end; ++i) {
      const fs::path target = (page.parent_path() / (*i)[1].str()).lexically_normal();
      if (reached.insert(target).second) unread.push_back(target);
    }
  }
  for (const fs::path& page : pages())
    EXPECT_TRUE(reached.contains(page.lexically_normal())) << page;
}

/// The sentences of a page longer than `most` words, each as "line N: W words: its beginning". Code
/// blocks are left out, each cell of a table stands by itself, inline code counts as one word.
std::vector<std::string> long_sentences(const std::string& text, int most) {
  static const std::regex code("`[^`]*`"), item("^([-*]|\\d+\\.) (.*)"), word("\\S+");
  std::vector<std::string> found;
  int line = 0, begin = 0, words = 0;
  std::string sentence;
  const auto end_sentence = [&] {
    if (words > most)
      found.push_back(fmt::format("line {}: {} words: {}", begin, words, sentence.substr(0, 80)));
    words = 0;
    sentence.clear();
  };
  const auto add = [&](const std::string& part) {
    const std::string plain = std::regex_replace(part, code, "x");
    for (std::sregex_iterator i(plain.begin(), plain.end(), word), end; i != end; ++i) {
      const std::string seen = i->str();
      if (words++ == 0) begin = line;
      sentence += seen + " ";
      if (seen.find_last_of(".!?") == seen.size() - 1) end_sentence();
    }
  };
  std::istringstream lines(text);
  bool in_code = false;
  for (std::string raw; std::getline(lines, raw);) {
    ++line;
    const std::size_t first = raw.find_first_not_of(" \t");
    std::string row = first == std::string::npos ? "" : raw.substr(first);
    if (row.starts_with("```")) in_code = !in_code;
    const bool apart = in_code || row.empty() || row.starts_with("```") || row.starts_with("#");
    const bool in_list = std::regex_match(row, item);
    if (apart || row.starts_with("|") || in_list) end_sentence();
    if (in_list) row = std::regex_replace(row, item, "$2");
    if (apart) continue;
    if (!row.starts_with("|")) {
      add(row);
      continue;
    }
    std::istringstream cells(row);
    for (std::string cell; std::getline(cells, cell, '|'); end_sentence()) add(cell);
  }
  end_sentence();
  return found;
}

TEST(Docs, SentencesAreShort) {
  EXPECT_THAT(long_sentences("One two three.\nFour `five six` (seven\neight) nine. Ten.", 4),
              ElementsAre("line 2: 5 words: Four x (seven eight) nine. "));
  EXPECT_THAT(long_sentences("| a b | c d |\n- e f\n```\ng h i j k\n```\n", 2), IsEmpty());
  EXPECT_GT(pages().size(), 20u);
  for (const auto& page : pages()) EXPECT_THAT(long_sentences(read(page), 35), IsEmpty()) << page;
}

TEST(Docs, EveryCommandOfTheHowToRuns) {
  const std::string text = source("docs/crgbuild.md");
  std::string script = "set -euo pipefail\n";
  std::size_t blocks = 0;
  for (std::size_t at = 0; (at = text.find("```sh\n", at)) != std::string::npos; ++blocks) {
    const std::size_t end = text.find("\n```", at);
    script += text.substr(at + 6, end - at - 5);
    at = end;
  }
  ASSERT_GE(blocks, 4u);
  const Folder folder;
  support::put_demo_circuit(folder.path());
  write(folder / "all.sh", script);
  const std::string path = std::filesystem::path(places::crgbuild()).parent_path().string();
  EXPECT_EQ(shell(fmt::format("cd '{}' && PATH='{}':\"$PATH\" bash all.sh > log 2>&1",
                              folder.path(), path)),
            0)
      << read(folder / "log");
  EXPECT_THAT(read(folder / "heights.csv"), ContainsRegex("\n0,5000,[^,]+,[^,]+,,[^,]+,[^,]+,,\n"))
      << "a point without road";
  for (const char* exported :
       {"ring.csv", "edges/ring.xodr", "edges/ring.rdf", "ring.glb", "ring.svg", "ring.png",
        "ring.png.json", "ring.mat", "global.geojson", "global.kml"})
    EXPECT_GT(std::filesystem::file_size(folder / exported), 100u) << exported;
}

// The first block of the page makes every file that the rest of it names.
TEST(Docs, EveryFileForOtherSimulatorsIsMade) {
  const std::string text = source("docs/simulators.md");
  const std::size_t begin = text.find("```sh\n") + 6, end = text.find("\n```", begin);
  const Folder folder;
  support::put_demo_circuit(folder.path());
  std::filesystem::create_symlink(places::source() + "/vehicles", folder / "vehicles");
  write(folder / "all.sh", "set -euo pipefail\n" + text.substr(begin, end - begin + 1));
  const auto folder_of = [](const std::string& program) {
    return std::filesystem::path(program).parent_path().string();
  };
  EXPECT_EQ(
      shell(fmt::format("cd '{}' && PATH='{}:{}':\"$PATH\" bash all.sh > log 2>&1", folder.path(),
                        folder_of(places::crgbuild()), folder_of(places::crgdrive()))),
      0)
      << read(folder / "log");
  const std::regex name(
      "`((?:road/)?[a-z-]+[.](?:crg|rdf|xodr|glb|png|json|mat|fmu)(?:[.]json)?)`");
  int count = 0;
  for (std::sregex_iterator i(text.begin() + static_cast<std::ptrdiff_t>(end), text.end(), name),
       last;
       i != last; ++i, ++count) {
    const std::string file = (*i)[1];
    EXPECT_TRUE(exists(folder / file) || exists(folder / ("road/" + file))) << file;
  }
  EXPECT_GE(count, 8);
}

TEST(Docs, EveryFormatOfExportStandsInACommandOfTheHowTo) {
  const std::string help = crgbuild({"export", "--help"}).out, text = source("docs/crgbuild.md");
  std::string commands;
  for (std::size_t at = 0; (at = text.find("```sh\n", at)) != std::string::npos;) {
    const std::size_t end = text.find("\n```", at);
    commands += text.substr(at + 6, end - at - 5);
    at = end;
  }
  const std::regex ending("\n  (\\.[a-z]+) ");  // the first of each line
  int count = 0;
  for (std::sregex_iterator i(help.begin(), help.end(), ending), end; i != end; ++i, ++count) {
    const std::string name = (*i)[1].str();
    EXPECT_THAT(commands, ContainsRegex("crgbuild export [^\n]*-o [^\n]*\\" + name)) << name;
  }
  EXPECT_EQ(count, 8);
}

TEST(Docs, EveryCommandOfTheLidarHowToRuns) {
  const std::string text = source("docs/lidar2mesh.md");
  const std::size_t begin = text.find("```sh\n") + 6;
  const Folder folder;
  support::put_demo_circuit(folder.path());
  std::string commands = text.substr(begin, text.find("\n```", begin) - begin);
  // 80 m in place of 240 show the same.
  const std::string to = "--u-end-m 420";
  if (std::getenv("KERBSTONE_HEAVY") == nullptr)
    commands.replace(commands.find(to), to.size(), "--u-end-m 260");
  write(folder / "all.sh", "set -euo pipefail\n" + commands + "\n");
  const std::string path =
      std::filesystem::path(places::crgbuild()).parent_path().parent_path().string() +
      "/lidar2mesh";
  EXPECT_EQ(shell(fmt::format("cd '{}' && PATH='{}':\"$PATH\" bash all.sh > log 2>&1",
                              folder.path(), path)),
            0)
      << read(folder / "log");
  for (const char* file : {"refined.crg", "refined.ply", "refined.stddev.crg",
                           "refined.provenance.crg", "summary.json", "trajectory.csv"})
    EXPECT_TRUE(exists(folder / ("refined/" + std::string(file)))) << file;
  EXPECT_TRUE(exists(folder / "scans-tiles/points.tiles"));
}

TEST(Scripts, AreSoundShell) {
  std::string scripts;
  for (const char* name :
       {"scripts/setup", "scripts/demo", "scripts/test", "scripts/package", "scripts/wheel",
        "scripts/fresh", "scripts/release", "scripts/empty_system", "scripts/campaign",
        "scripts/check", "packaging/try_packages", "packaging/try_wheel", ".ci/run",
        ".ci/fresh_packages"}) {
    EXPECT_EQ(shell(fmt::format("bash -n '{}/{}'", places::source(), name)), 0) << name;
    scripts += fmt::format(" '{}/{}'", places::source(), name);
  }
  if (shell("command -v shellcheck >/dev/null") != 0) GTEST_SKIP() << "shellcheck is not installed";
  EXPECT_EQ(
      shell(fmt::format("cd '{}' && shellcheck --external-sources{}", places::source(), scripts)),
      0);
}

TEST(Scripts, WhatABuildTookFromElsewhereIsNamed) {
  if (shell("command -v dpkg-query >/dev/null") != 0)
    GTEST_SKIP() << "needs Debian's package lists";
  const Folder folder;
  const auto check = [&](const std::string& compiler) {
    write(folder / "build/CMakeCache.txt", "CMAKE_CXX_COMPILER:FILEPATH=" + compiler + "\n");
    return shell(fmt::format("'{}/.ci/fresh_packages' check '{}' > '{}' 2>&1", places::source(),
                             folder / "build", folder / "said"));
  };
  std::filesystem::create_directories(folder / "build/tools");
  std::filesystem::create_directories(folder / "build/tests");
  write(folder / "build/build.ninja", "");
  write(folder / "compiler", "");
  EXPECT_EQ(check("/usr/bin/c++"), 0) << read(folder / "said");
  EXPECT_NE(check(folder / "compiler"), 0);
  EXPECT_THAT(read(folder / "said"), HasSubstr(folder / "compiler was used"));
}

TEST(Scripts, SetupRefusesWhatItDoesNotKnow) {
  EXPECT_NE(shell(fmt::format("'{}/scripts/setup' nonsense 2>/dev/null", places::source())), 0);
}

TEST(Scripts, FreshAndReleaseRefuseInOneLine) {
  const Folder folder;
  const auto fresh = [&](const std::string& before, const std::string& arguments) {
    return shell(fmt::format("{} '{}/scripts/fresh' {} > '{}' 2>&1", before, places::source(),
                             arguments, folder / "said"));
  };
  EXPECT_NE(fresh("", "nonsense"), 0);
  EXPECT_EQ(read(folder / "said"),
            "fresh: 'nonsense' seen; demo, test, package, all or --help wanted\n");
  EXPECT_EQ(fresh("", "--help"), 0);
  EXPECT_THAT(read(folder / "said"), HasSubstr("scripts/fresh [demo|test|package|all]"));
  // What an ordinary user sees, also where the tests run as root.
  write(folder / "id", "#!/bin/sh\necho 1000\n");
  std::filesystem::permissions(folder / "id", std::filesystem::perms::owner_all);
  EXPECT_NE(fresh(fmt::format("PATH='{}':\"$PATH\"", folder.path()), "demo"), 0);
  EXPECT_EQ(read(folder / "said"),
            "fresh: an empty system can be made by root only; run: sudo scripts/fresh demo\n");
  EXPECT_NE(
      shell(fmt::format("'{}/scripts/release' 2.0 2> '{}'", places::source(), folder / "said")), 0);
  EXPECT_EQ(read(folder / "said"), "release: '2.0' seen; no word or --help wanted\n");
}

TEST(Scripts, PagePackagesRunOnTheNodeOfDebian12) {
  const std::string lock = source("lib/report/web/package-lock.json");
  const std::regex node("\"node\": \"([^\"]*)\""), at_least("\\D*(\\d+)[.\\d]*");
  int count = 0;
  for (std::sregex_iterator i(lock.begin(), lock.end(), node), end; i != end; ++i, ++count) {
    const std::string wanted = (*i)[1];
    std::smatch least;
    ASSERT_TRUE(std::regex_match(wanted, least, at_least)) << wanted;
    EXPECT_LE(std::stoi(least[1]), 18) << wanted;
  }
  EXPECT_GE(count, 2);
  // Where they come from is the reader's setting.
  EXPECT_THAT(lock, Not(HasSubstr("://")));
}

}  // namespace docs_test
}  // namespace cli
