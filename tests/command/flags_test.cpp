// Few flags, and one name for each thing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace flags_test {

using cli::Folder;
using support::all_tools, support::run_tool;
using ::testing::HasSubstr;
using Words = std::vector<std::string>;

/// The long flags that each command shows, by "tool command". The man page has what --help has.
std::map<std::string, std::set<std::string>> shown_flags() {
  std::map<std::string, std::set<std::string>> out;
  for (const support::Tool& tool : all_tools()) {
    const std::string man = run_tool(tool.path, {"--man"}).out,
                      page = std::regex_replace(man, std::regex(R"(\\-)"), "-");
    const std::size_t common = page.find("\n.SH OPTIONS OF EVERY COMMAND");
    const std::regex flag(R"(\\fB--([a-z0-9-]+)\\fR)");
    const auto add = [&](std::set<std::string>& to, const std::string& text) {
      for (std::sregex_iterator i(text.begin(), text.end(), flag), end; i != end; ++i)
        to.insert((*i)[1]);
    };
    for (std::size_t at = page.find("\n.SS "); at < common;) {
      const std::size_t next = std::min(page.find("\n.SS ", at + 1), common);
      std::set<std::string>& flags = out[page.substr(at + 5, page.find('\n', at + 1) - at - 5)];
      add(flags, page.substr(at, next - at));
      add(flags, page.substr(common));
      at = next;
    }
  }
  return out;
}

/// What must not be shown, since the same thing has another name.
const std::map<std::string, std::string> kOneName = {
    {"track", "road"},
    {"base", "road"},
    {"vehicle", "car"},
    {"recording", "log"},
    {"recordings", "log"},
    {"logs", "log"},
    {"reference", "tir"},
    {"tyre", "tir"},
    {"tum", "trajectory"},
    {"poses", "trajectory"},
    {"path", "trajectory"},
    {"out", "output"},
    {"out-dir", "output"},
    {"plots", "output"},
    {"page", "output"},
    {"xodr", "output"},
    {"rdf", "output"},
    {"glb", "output"},
    {"kml", "output"},
    {"geojson", "output"},
    {"svg", "output"},
    {"mat", "output"},
    {"heightmap", "output"},
    {"stl", "format"},
    {"pcd", "format"},
    {"step-ms", "step-s"},
    {"steps-s", "step-s"},
    {"dt", "step-s"},
    {"seconds", "stop-s"},
    {"duration-s", "stop-s"},
    {"end-s", "stop-s"},
    {"record-every", "every"},
    {"from-m", "u-begin-m"},
    {"to-m", "u-end-m"},
    {"u-start-m", "u-begin-m"},
    {"start-near-m", "start-at"},
    {"start-object", "start-at"},
    {"begin-mps", "speed-mps"},
    {"least-mps", "speed-mps"},
    {"most-mps", "speed-mps"},
    {"speed", "speed-mps"},
    {"facet-m", "step-m"},
    {"node-m", "step-m"},
    {"octree-m", "voxel-m"},
    {"level-m", "window-m"},
    {"mirrored", "mirror"},
    {"accelerations", "frame"},
    {"guide-mapping", "mapping"},
    {"input", "command"},
    {"movement", "measure"},
    {"second", "opponent"},
    {"opponent-ahead-s", "opponent"},
    {"jobs", "threads"},
    {"random-seed", "seed"},
};

TEST(Flags, AreFewAndOneThingHasOneName) {
  std::set<std::string> all;
  const auto shown = shown_flags();
  EXPECT_GT(shown.size(), 60u);
  for (const auto& [command, flags] : shown) {
    EXPECT_LE(flags.size(), 40u) << command;
    EXPECT_TRUE(flags.contains("help") && flags.contains("output")) << command;
    all.insert(flags.begin(), flags.end());
    for (const std::string& flag : flags)
      EXPECT_FALSE(kOneName.contains(flag))
          << command << " has --" << flag << "; the name is --" << kOneName.find(flag)->second;
  }
  for (const auto& [other, name] : kOneName)
    EXPECT_TRUE(all.contains(name)) << "--" << name << ", in place of --" << other;
  EXPECT_LE(all.size(), 150u) << ::testing::PrintToString(all);
}

/// Each is read before a file that is not there is missed.
TEST(Flags, ThatAreNotShownWorkAndSayTheNewOne) {
  struct Old {
    std::string tool, words;
    std::vector<std::string> said;
  };
  const std::vector<Old> kOld = {
      {"crgbuild", "synth no.yaml -o @ --facet-m 1", {"--facet-m is called --step-m"}},
      {"crgbuild",
       "build no.obj -o @ --start-near-m 0,0 --start-object Start --guide-mapping no.yaml",
       {"--start-near-m is written --start-at", "--start-object is written --start-at",
        "--guide-mapping is written --mapping"}},
      {"crgbuild", "query no.crg --points - -o @ --no-modifiers", {"written --modifiers none"}},
      {"crgbuild",
       "query no.crg --points - -o @ --reference-defaults",
       {"written --modifiers reference"}},
      {"lidar2mesh",
       "synth no.crg -o @ --from-m 1 --to-m=2",
       {"--from-m is called --u-begin-m", "--to-m is called --u-end-m"}},
      {"lidar2mesh",
       "map no.las -o @ --node-m 0.2 --stl --pcd",
       {"called --step-m", "--stl is written --format stl", "--pcd is written --format ply,pcd"}},
      {"lidar2mesh", "register no.ply no.ply --robust", {"written --method robust"}},
      {"lidar2mesh",
       "changes no.las no.las -o @ --octree-m 1 --level-m 10",
       {"called --voxel-m", "called --window-m"}},
      {"crgdrive",
       "lap --car no.yaml --road no.crg --begin-mps 3 --opponent-ahead-s 2 --second no.yaml "
       "--second-ahead-m 3 --second-grip-usage 0.5 --second-output @",
       {"called --speed-mps", "written --opponent LOG@1s",
        "--second is written --opponent VEHICLE.yaml@15m",
        "--second-ahead-m is written --opponent VEHICLE.yaml@15m",
        "--second-grip-usage is written --grip-usage FIRST SECOND",
        "--second-output is written -o FIRST -o SECOND"}},
      {"crgdrive", "timing --car no.yaml --seconds 1", {"--seconds is called --stop-s"}},
      {"crgdrive", "manoeuvre sine --car no.yaml --seconds 2", {"called --stop-s"}},
      {"crgdrive", "poles --car no.yaml --steps-s 0.001", {"called --step-s"}},
      {"crgdrive",
       "tyre --tir no.tir --mirrored --plots @",
       {"called --mirror", "--plots is written -o NAME.html"}},
      {"crgsim", "run no.fmu -o @ --record-every 3", {"called --every"}},
      {"crgidentify",
       "tyre no.csv --reference no.tir -o @ --plots @",
       {"--reference is called --tir", "written -o NAME.html"}},
      {"crgidentify", "mass no.csv --car no.yaml --accelerations road", {"called --frame"}},
      {"crgidentify",
       "forces no.csv --car no.yaml --road no.crg -o @ --step-ms 1",
       {"--step-ms is written --step-s"}},
      {"crgidentify",
       "reduce --car no.yaml -o @ --least-mps 10 --most-mps 50 --most-lap-share 1 "
       "--most-limit-share 1",
       {"--least-mps is written --speed-mps", "--most-mps is written --speed-mps",
        "--most-lap-share is written --most-share", "--most-limit-share is written --most-share"}},
      {"crgidentify",
       "actuator no.csv --input a --movement b",
       {"called --command", "called --measure"}},
      {"crgidentify", "brakes no.csv --car no.yaml --pad-map @", {"written -o NAME.csv"}},
      // What is kept without a word: numbers whose default does it right.
      {"crgbuild", "build no.obj -o @ --kerb-min-height-m 0.02 --friction-grass 0.4", {"no.obj"}},
      {"crgbuild", "preview no.obj -o @ --most-triangles 1000", {"no.obj"}},
      {"crgdrive", "lap --car no.yaml --road no.crg --integrator explicit", {"no.yaml"}},
      {"crgsim", "run no.fmu -o @ --start-s 1", {"no.fmu"}},
      {"crgexplain", "run --car no.yaml --road no.crg --log no.csv -o @ --nulls 200", {"no."}},
      {"crgidentify", "tyre no.csv --tir no.tir -o @ --starts 2", {"no."}},
      {"crgidentify", "actuator no.csv --hold line", {"no.csv"}},
      {"crgidentify", "reduce --car no.yaml -o @ --speeds 3 --slips 9", {"no.yaml"}},
      {"crgidentify", "forces no.csv --car no.yaml --road no.crg -o @ --noise-rounds 1", {"no."}},
  };
  const Folder folder;
  std::map<std::string, std::string> path_of;
  for (const support::Tool& tool : all_tools()) path_of[tool.name] = tool.path;
  for (const Old& old : kOld) {
    SCOPED_TRACE(old.tool + " " + old.words);
    Words words;
    std::istringstream split(old.words);
    for (std::string word; split >> word;)
      words.push_back(word == "@" ? folder / "made" + std::to_string(words.size()) : word);
    const support::ToolRun ran = run_tool(path_of[old.tool], words);
    EXPECT_EQ(ran.code, 1) << ran.err;
    for (const std::string& said : old.said) EXPECT_THAT(ran.err, HasSubstr(said));
  }
}

/// What --second and --opponent-ahead-s said is said by --opponent, to the byte.
TEST(Flags, OpponentIsALogOrACarOfTheSameRun) {
  const Folder f;
  std::string left = "x_m,y_m\n", right = left;
  for (int x = 0; x <= 160; x += 20) {
    left += std::to_string(x) + ",5\n";
    right += std::to_string(x) + ",-5\n";
  }
  cli::write(f / "left.csv", left);
  cli::write(f / "right.csv", right);
  ASSERT_EQ(cli::crgbuild({"from-edges", f / "left.csv", f / "right.csv", "-o", f / "r"}).code, 0);
  const std::string cars = places::source() + "/vehicles/", other = cars + "av21/vehicle.yaml";
  const auto lap = [&](const Words& more) {
    Words words{"lap", "--car", cars + "open_wheel/vehicle.yaml", "--road", f / "r/road.crg", "-q"};
    words.insert(words.end(), more.begin(), more.end());
    return run_tool(places::crgdrive(), words);
  };
  ASSERT_EQ(lap({"--second", other, "--second-ahead-m", "30", "--second-grip-usage", "0.5", "-o",
                 f / "a1.csv", "--second-output", f / "a2.csv"})
                .code,
            0);
  ASSERT_EQ(lap({"--opponent", other + "@30m", "--grip-usage", "0.75", "0.5", "-o", f / "b1.csv",
                 "-o", f / "b2.csv"})
                .code,
            0);
  EXPECT_EQ(cli::read(f / "a1.csv"), cli::read(f / "b1.csv"));
  EXPECT_EQ(cli::read(f / "a2.csv"), cli::read(f / "b2.csv"));
  EXPECT_NE(cli::read(f / "a1.csv"), cli::read(f / "a2.csv"));
  ASSERT_EQ(lap({"--opponent", f / "a2.csv", "--opponent-ahead-s", "2", "-o", f / "c.csv"}).code,
            0);
  ASSERT_EQ(lap({"--opponent", f / "a2.csv@2s", "-o", f / "d.csv"}).code, 0);
  EXPECT_EQ(cli::read(f / "c.csv"), cli::read(f / "d.csv"));
  EXPECT_THAT(cli::read(f / "d.csv"), HasSubstr("# opponents 2 s ahead"));
  EXPECT_THAT(lap({"--opponent", f / "a2.csv@3m"}).err, HasSubstr("a log is ahead by seconds"));
  EXPECT_THAT(lap({"--opponent", other + "@3s"}).err, HasSubstr("begins 0 to 1000 m ahead"));
  EXPECT_THAT(lap({"-o", f / "x", "-o", f / "y"}).err, HasSubstr("are of a second car"));
}

TEST(Flags, ThatAreNotShownAreNamedInErrors) {
  for (const support::Tool& tool : all_tools()) {
    if (tool.name != "crgidentify") continue;
    const Words tyre{"tyre", "no.csv", "--tir", "no.tir", "-o", "-"};
    const auto error = [&](Words words) {
      words.insert(words.begin(), tyre.begin(), tyre.end());
      const support::ToolRun ran = run_tool(tool.path, words);
      EXPECT_EQ(ran.code, 2);
      return ran.err;
    };
    EXPECT_THAT(error({"--starts", "0"}), HasSubstr("--starts: Value 0 not in range 1 to 1000"));
    EXPECT_THAT(error({"--plots", ""}), HasSubstr("--plots: '' seen, a file wanted"));
    EXPECT_THAT(error({"--plots", "-"}), HasSubstr("--output and --plots: standard output takes"));
    EXPECT_THAT(error({"--strats", "1"}), HasSubstr("there is no flag '--strats'"));
  }
}

}  // namespace flags_test
