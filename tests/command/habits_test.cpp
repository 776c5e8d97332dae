// What every command of every tool does alike.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "support/places.h"
#include "support/run_crgbuild.h"
#include "support/run_tool.h"

namespace habits_test {

using cli::Folder;
using support::all_tools, support::run_on_terminal, support::run_tool;
using support::Tool, support::ToolRun;
using ::testing::HasSubstr;
using ::testing::Not;
using Words = std::vector<std::string>;

std::string joined(const Words& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : " ") + word;
  return out;
}

Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Asked once: the help of each of them is read to find them.
const std::vector<Words>& known_commands(const Tool& tool) {
  static std::map<std::string, std::vector<Words>> known;
  const auto [at, is_new] = known.try_emplace(tool.name);
  if (is_new) at->second = support::commands_of(tool);
  return at->second;
}

/// One line, the tool's name in front, no control characters.
void expect_one_line(const Tool& tool, const std::string& err) {
  EXPECT_TRUE(err.starts_with(tool.name + ": ")) << err;
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  EXPECT_TRUE(std::none_of(err.begin(), err.end() - (err.empty() ? 0 : 1), [](unsigned char c) {
    return c < 32 || c == 127;
  })) << err;
}

std::set<std::string> flags_in(const std::string& help) {
  std::set<std::string> out;
  const std::regex flag("\n  (-[a-z],)?(--[a-z0-9-]+)");
  for (std::sregex_iterator i(help.begin(), help.end(), flag), end; i != end; ++i)
    out.insert((*i)[2]);
  return out;
}

TEST(Habits, EveryCommandHasTheSameFlagsAndIsDescribedEverywhere) {
  std::size_t commands = 0;
  for (const Tool& tool : all_tools()) {
    const std::string man = run_tool(tool.path, {"--man"}).out,
                      version = run_tool(tool.path, {"--version"}).out;
    EXPECT_TRUE(std::regex_match(
        version,
        std::regex(tool.name +
                   " [0-9]+\\.[0-9]+\\.[0-9]+ "
                   "\\(([0-9a-f]{10}(-dirty)?|unknown)\\)\n(with(out)? (PCL|Cyclone DDS).*\n)?")))
        << version;
    for (const Words& words : known_commands(tool)) {
      SCOPED_TRACE(tool.name + " " + joined(words));
      ++commands;
      const ToolRun help = run_tool(tool.path, words + Words{"--help"});
      EXPECT_EQ(help.code, 0);
      EXPECT_EQ(help.err, "");
      for (const char* flag :
           {"  -o,--output ", "  -q,--quiet ", "  --json ", "  --version ", "  -h,--help ",
            "\nExit code: 0 done, 1 cannot be done, 2 wrong command line, 3 done but must not be "
            "used"})
        EXPECT_THAT(help.out, HasSubstr(flag));
      EXPECT_THAT(help.out, HasSubstr("Usage: " + tool.name + " " + joined(words) + " "));
      EXPECT_EQ(run_tool(tool.path, words + Words{"--version"}).out, version);
      const std::string section = ".SS " + tool.name + " " +
                                  std::regex_replace(joined(words), std::regex("-"), "\\-") + "\n";
      const std::size_t begin = man.find(section);
      ASSERT_NE(begin, std::string::npos);
      const std::string page = man.substr(begin, man.find("\n.SS ", begin) - begin) +
                               man.substr(man.find(".SH OPTIONS OF EVERY"));
      for (const std::string& flag : flags_in(help.out))
        EXPECT_THAT(page,
                    HasSubstr("\\fB" + std::regex_replace(flag, std::regex("-"), "\\-") + "\\fR"));
    }
  }
  EXPECT_GE(commands, 35u);
}

/// What the shell offers for the last of these words.
Words completed(const std::string& script, const Words& words) {
  std::string call;
  for (const std::string& word : words) call += " '" + word + "'";
  const std::string program = fmt::format(
      "source '{}'; compopt() {{ :; }}; COMP_WORDS=({}); COMP_CWORD={}; COMPREPLY=(); _{}; printf "
      "'%s\\n' \"${{COMPREPLY[@]}}\"",
      script, call, words.size() - 1, words.front());
  std::istringstream said(run_tool("/bin/bash", {"-c", program}).out);
  Words out;
  for (std::string line; std::getline(said, line);) out.push_back(line);
  return out;
}

TEST(Habits, TheShellCompletesCommandsFlagsWordsAndFiles) {
  const Folder folder;
  for (const Tool& tool : all_tools()) {
    const std::string script = folder / tool.name;
    cli::write(script, run_tool(tool.path, {"--completion"}).out);
    std::set<std::string> first;
    const std::vector<Words>& commands = known_commands(tool);
    for (const Words& words : commands) first.insert(words.front());
    EXPECT_THAT(completed(script, {tool.name, ""}), ::testing::UnorderedElementsAreArray(first));
    for (const Words& words : commands) {
      if (&words != &commands.front() && &words != &commands.back() && words.size() == 1)
        continue;  // they are made alike
      const std::set<std::string> flags =
          flags_in(run_tool(tool.path, words + Words{"--help"}).out);
      EXPECT_THAT(completed(script, Words{tool.name} + words + Words{"--"}),
                  ::testing::UnorderedElementsAreArray(flags))
          << joined(words);
    }
  }
  cli::write(folder / "road.crg", "");
  EXPECT_THAT(completed(folder / "crgbuild", {"crgbuild", "convert", "--format", "k"}),
              ::testing::ElementsAre("krbi", "kdbi"));
  EXPECT_THAT(completed(folder / "crgdrive", {"crgdrive", "lap", "--contact", "f"}),
              ::testing::ElementsAre("four-point"));
  EXPECT_THAT(completed(folder / "crgdrive", {"crgdrive", "manoeuvre", "ste"}),
              ::testing::ElementsAre("step-steer"));
  EXPECT_THAT(completed(folder / "crgbuild", {"crgbuild", "info", folder / "ro"}),
              ::testing::ElementsAre(folder / "road.crg"));
  EXPECT_THAT(completed(folder / "crgexplain", {"crgexplain", "ru"}),
              ::testing::ElementsAre("run"));
}

TEST(Habits, AWrongCommandLineIsOneLineThatHelps) {
  for (const Tool& tool : all_tools()) {
    for (const Words& words : known_commands(tool)) {
      SCOPED_TRACE(tool.name + " " + joined(words));
      const ToolRun flag = run_tool(tool.path, words + Words{"--ouptut", "x"});
      EXPECT_EQ(flag.code, 2);
      expect_one_line(tool, flag.err);
      EXPECT_THAT(flag.err, HasSubstr("there is no flag '--ouptut'; did you mean --output?"));
      EXPECT_THAT(flag.err, HasSubstr(tool.name + " " + joined(words) + " --help"));
      Words wrong = words;
      std::swap(wrong.back()[0], wrong.back()[1]);
      const ToolRun command = run_tool(tool.path, wrong);
      EXPECT_EQ(command.code, 2);
      EXPECT_THAT(command.err, HasSubstr("there is no command '" + wrong.back() +
                                         "'; did you mean '" + words.back() + "'?"));
      EXPECT_EQ(flag.out + command.out, "");
    }
    const ToolRun none = run_tool(tool.path, {});
    EXPECT_EQ(none.code, 2);
    EXPECT_THAT(none.err, HasSubstr("a command is wanted: "));
    expect_one_line(tool, run_tool(tool.path, {"no\nsuch\x1b[2J"}).err);
  }
  const auto err = [](const Words& words) { return run_tool(places::crgbuild(), words).err; };
  EXPECT_THAT(err({"build", "x.obj", "-o", "x", "--u-step", "1"}),
              HasSubstr("did you mean --u-step-m?"));
  EXPECT_THAT(err({"build", "x.obj", "-o", "x", "--u-steps=1"}),
              HasSubstr("'--u-steps'; did you mean --u-step-m?"));
  EXPECT_THAT(err({"build", "x.obj", "-o", "x", "--smooth-window", "1"}),
              HasSubstr("did you mean --smooth-window-m?"));
  EXPECT_THAT(err({"track.obj"}), HasSubstr("crgbuild build -o out track.obj"));
  EXPECT_THAT(err({"track.obj", "-o", "x"}), HasSubstr("crgbuild build -o out track.obj"));
  EXPECT_THAT(err({"--jsn", "info", "x.crg"}), HasSubstr("did you mean --json?"));
}

Words cells(const std::string& row) {
  Words out;
  std::istringstream in(row);
  for (std::string cell; std::getline(in, cell, ',');) out.push_back(cell);
  return out;
}

/// The header of a log and its first seconds; its first column is the time.
std::string first_seconds(const std::string& csv, double seconds) {
  std::istringstream rows(csv);
  std::string out, row;
  double begin_s = NAN;
  for (bool header = true; std::getline(rows, row); header = false) {
    const double time_s = header ? NAN : std::stod(row);
    if (std::isnan(begin_s)) begin_s = time_s;
    if (time_s > begin_s + seconds) break;
    out += row + "\n";
  }
  return out;
}

/// Files for one call of every command.
class Called : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder(
        "Stra\xdf"
        "e");  // names are any bytes: Latin-1, no UTF-8
    const Folder& f = *folder_;
    const std::string crg = f / "out/s.crg";
    cli::write(f / "s.obj", cli::Stadium{}.obj());
    ASSERT_EQ(cli::crgbuild({"build", f / "s.obj", "-o", f / "out", "--no-report"}).code, 0);
    cli::write(f / "points.csv", "x_m,y_m\n10,0\n20,1\n");
    cli::write(f / "left.csv", "x_m,y_m\n0,5\n30,5\n60,5\n100,6\n");
    cli::write(f / "right.csv", "x_m,y_m\n0,-5\n30,-5\n60,-5\n100,-6\n");
    const std::string trials = f / "trials", trial = trials + "/0000/";
    ASSERT_EQ(run_tool(places::blind_trials(),
                       {"make", trials, "--generator", places::make_trials(), "--count", "1"})
                  .code,
              0);
    const std::string track = trial + "track.crg", car = trial + "vehicle.yaml",
                      log = f / "log.csv";
    cli::write(log, first_seconds(cli::read(trial + "run.csv"), 20.0));
    cli::write(f / "two_laps.csv", first_seconds(cli::read(trial + "run.csv"), 85.0));
    // The first seconds of a lap of that car.
    ASSERT_EQ(run_tool(places::crgdrive(),
                       {"lap", "--car", car, "--road", track, "-o", f / "first_lap.csv"})
                  .code,
              0);
    std::istringstream lap(cli::read(f / "first_lap.csv"));
    std::string begin, line;
    for (int i = 0; i < 400 && std::getline(lap, line); ++i) begin += line + "\n";
    cli::write(f / "begin.csv", begin);
    const std::string ring = places::source() + "/tracks/kerbstone-ring/circuit.yaml",
                      small_ring = places::source() + "/tests/corpus/circuit/closed.yaml";
    cli::write(f / "fz.csv", "fz_n,kappa,alpha_rad,gamma_rad,vx_mps\n3000,0.05,0.02,0,30\n");
    std::string bench = "fz_n,kappa,alpha_rad,gamma_rad,vx_mps,fy_n\n";
    for (int i = -40; i <= 40; ++i)
      bench += fmt::format("3000,0,{0},0,30,{1}\n", 0.005 * i,
                           -4000.0 * std::sin(0.5 * std::atan(0.2 * i)));
    cli::write(f / "bench.csv", bench);
    // A steering that follows its command a little later.
    std::string steering = "time_s,steer_command_rad,steer_rad\n";
    const auto wave = [](int i) { return 0.1 * std::sin(0.03 * i) + 0.03 * std::sin(0.11 * i); };
    for (int i = 0; i < 2000; ++i)
      steering += fmt::format("{:.3f},{:.6f},{:.6f}\n", 0.01 * i, 16 * wave(i), wave(i - 4));
    cli::write(f / "steering.csv", steering);
    const Words scan{"synth",     ring,  "-o",     f / "scans", "--u-begin-m", "380",
                     "--u-end-m", "390", "--laps", "1",         "--azimuths",  "256",
                     "--beams",   "16",  "--cars", "0"};
    ASSERT_EQ(run_tool(places::lidar2mesh(), scan).code, 0);
    const std::string cloud = f / "scans/scan_000.ply", truth = f / "scans/truth.crg",
                      poses = f / "scans/truth_trajectory.csv", base = f / "base.crg";
    ASSERT_EQ(
        cli::crgbuild({"crop", truth, "-o", base, "--u-begin-m", "350", "--u-end-m", "420"}).code,
        0);
    make_tiles(f, poses, base);
    // Points on the road, in the map frame.
    std::string asked = "u_m,v_m\n", survey = "x_m,y_m,z_m\n";
    for (int i = 0; i < 400; ++i)
      for (int j = -8; j <= 8; ++j) asked += fmt::format("{},{}\n", 375 + 0.05 * i, 0.1 * j);
    cli::write(f / "places.csv", asked);
    std::istringstream heights(
        run_tool(places::crgbuild(), {"query", base, "--points", f / "places.csv", "-o", "-"}).out);
    std::string row;
    for (std::getline(heights, row); std::getline(heights, row);) {
      const std::vector<std::string> cell = cells(row);
      survey += cell[0] + "," + cell[1] + "," + cell[4] + "\n";
    }
    cli::write(f / "survey.csv", survey);
    const std::string racer = places::source() + "/vehicles/open_wheel/vehicle.yaml";
    ASSERT_EQ(run_tool(places::crgdrive(), {"fmu", racer, "-o", f / "unit.fmu"}).code, 0);
    cli::write(f / "race.yaml",
               "each: {unit: unit.fmu, command: [input.throttle], measure: [car.vx]}\n"
               "cars: {red: {set: {start.u: 10}}, blue: {}}\n");
    // A lap that shows an engine: the trial's road may be too short of straights for that.
    ASSERT_EQ(run_tool(places::crgdrive(),
                       {"lap", "--car", racer, "--road", truth, "-o", f / "ring_lap.csv"})
                  .code,
              0);
    std::filesystem::create_directory(f / "campaign");
    cli::write(f / "campaign/plan.json", R"({"name": "none", "jobs": []})");
    std::filesystem::create_directory(f / "long_campaign");
    std::string jobs;
    for (int i = 0; i < 400000; ++i)
      jobs += fmt::format(R"({}{{"kind": "road", "subject": "{}"}})", i == 0 ? "" : ",", i);
    cli::write(f / "long_campaign/plan.json", R"({"name": "long", "jobs": [)" + jobs + "]}");
    calls_ = {
        {"crgbuild",
         {{"build", f / "s.obj", "-o", f / "b"},
          {"stretch", f / "s.obj", "--u-begin-m", "1", "--u-end-m", "20", "-o", f / "stretch.crg"},
          {"from-edges", f / "left.csv", f / "right.csv", "-o", f / "e"},
          {"clean", f / "s.obj", "-o", f / "clean.obj"},
          {"preview", f / "s.obj", "-o", f / "preview.glb"},
          {"objects", f / "s.obj"},
          {"centreline", f / "s.obj", "-o", f / "line.csv"},
          {"sample", f / "s.obj", "--centreline", f / "out/centreline.csv", "-o", f / "sample.crg"},
          {"kerb", crg, "--mesh", f / "s.obj", "-o", f / "kerb.crg"},
          {"smooth", crg, "--ignore-kerbs", "--smooth-window-m", "1", "-o", f / "smooth.crg"},
          {"align", crg, "--yaw-deg", "1", "--translation-m", "0,0,0", "-o", f / "align.crg"},
          {"validate", crg, f / "s.obj"},
          {"report", crg, "-o", f / "r"},
          {"info", crg},
          {"query", crg, "--points", f / "points.csv", "-o", f / "z.csv"},
          {"check", crg},
          {"convert", crg, "-o", f / "convert.crg"},
          {"crop", crg, "-o", f / "crop.crg", "--u-begin-m", "1", "--u-end-m", "20"},
          {"resample", crg, "-o", f / "resample.crg", "--u-step-m", "0.5"},
          {"reverse", crg, "-o", f / "reverse.crg"},
          {"append", crg, crg, "--move", "-o", f / "append.crg"},
          {"transform", crg, "--set", "SCALE_Z_GRID=2", "-o", f / "transform.crg"},
          {"export", crg, "--format", "tum", "-o", f / "export.csv"},
          {"synth", small_ring, "-o", f / "synth", "--step-m", "10"}}},
        {"crgdrive",
         {{"tyre", "--tir", trial + "front.tir", "--points", f / "fz.csv", "-o", f / "forces.csv"},
          {"parameters"},
          {"lap", "--car", car, "--road", track, "-o", f / "lap.csv"},
          {"replay", "--car", car, "--road", track, "--log", log, "-o", f / "replay"},
          {"report", log, "--road", track, "-o", f / "page.html"},
          {"manoeuvre", "bump", "--car", car, "--stop-s", "2", "-o", f / "bump.csv"},
          {"timing", "--car", car, "--stop-s", "0.1"},
          {"poles", "--car", car},
          {"fmu", car, "--road", track, "-o", f / "car.fmu"},
          {"new", places::source() + "/vehicles/sheets/formula_student.yaml", "-o",
           f / "new_car"}}},
        {"crgexplain",
         {{"map", log, "-o", f / "mapping.yaml"},
          {"run", "--road", track, "--car", car, "--log", log, "--skip-simulation", "--nulls",
           "100", "-o", f / "found"},
          {"summary", f / "two_laps.csv", "--road", track, "--car", car, "-o", f / "drive.summary"},
          {"fleet", f / "drive.summary", "-o", f / "fleet"},
          {"road", f / "two_laps.csv", "-o", f / "flat.crg"}}},
        {"crgidentify",
         {{"tyre", f / "bench.csv", "--tir", trial + "front.tir", "--starts", "1", "-o",
           f / "fitted.tir"},
          {"actuator", f / "steering.csv", "-o", f / "sheet.txt"},
          {"mass", f / "first_lap.csv", "--car", car, "--road", track, "-o", f / "mass.txt"},
          {"aero", f / "first_lap.csv", "--car", car, "--road", track, "-o", f / "aero.txt"},
          {"brakes", f / "first_lap.csv", "--car", car, "--road", track, "-o", f / "brakes.txt"},
          {"suspension", f / "first_lap.csv", "--car", car, "--road", track, "-o",
           f / "suspension.txt"},
          {"engine", f / "ring_lap.csv", "--car", racer, "--road", truth, "-o", f / "engine.yaml"},
          {"forces", f / "begin.csv", "--car", car, "--road", track, "--noise-rounds", "0", "-o",
           f / "forces"},
          {"reduce", "--car", car, "--speeds", "2", "--slips", "6", "--pressing", "1",
           "--speed-mps", "15", "40", "--most-share", "1", "1", "-o", f / "control.yaml"}}},
        {"crgsim",
         {{"info", f / "unit.fmu"},
          {"run", f / "unit.fmu", "--stop-s", "0.1", "-o", f / "run.csv"},
          {"serve", f / "unit.fmu", "--socket", f / "car.sock", "--command", "input.throttle",
           "--measure", "car.vx", "--stop-s", "0.1", "-o", f / "served.csv"},
          {"race", f / "race.yaml", "--socket", f / "race.sock", "--stop-s", "0.1", "-o",
           f / "raced"}}},
        {"lidar2mesh",
         {{"info", cloud},
          {"ground", cloud, "-o", f / "ground.ply"},
          {"register", cloud, cloud},
          {"synth", small_ring, "-o", f / "scans2", "--u-begin-m", "380", "--u-end-m", "385",
           "--laps", "1", "--azimuths", "64", "--beams", "8"},
          {"map", f / "scans", "--trajectory", poses, "--road", base, "--no-report", "-o",
           f / "map"},
          {"changes", f / "survey.csv", f / "survey.csv", "--cell-m", "0.25", "-o", f / "changes"},
          {"tiles", cloud, "-o", f / "tiles"},
          {"split", f / "scans", "--trajectory", poses, "--road", base, "--tiles", "2", "-o",
           f / "split_again"},
          {"map-tile", f / "split", "--step", "2", "--tile", "1"},
          {"merge", f / "split", "--step", "4", "--no-report", "-o", f / "merged"},
          {"grid", f / "survey.csv", "--road", base, "--no-report", "-o", f / "grid"}}},
        {"kerbstone",
         {{"collect", f / "campaign"},
          {"open", log, "-o", f / "opened.csv"},
          {"view", f / "campaign", "--no-open", "--stop-s", "0.01"}}},
    };
  }
  /// A map in two tiles, all but its last command.
  static void make_tiles(const Folder& f, const std::string& poses, const std::string& base) {
    const auto run = [](const Words& words) {
      const ToolRun ran = run_tool(places::lidar2mesh(), words);
      ASSERT_EQ(ran.code, 0) << ran.err;
    };
    run({"split", f / "scans", "--trajectory", poses, "--road", base, "--tiles", "2", "-o",
         f / "split"});
    for (const char* step : {"1", "2", "3", "4"}) {
      for (const char* tile : {"1", "2"})
        run({"map-tile", f / "split", "--step", step, "--tile", tile});
      if (step[0] != '4') run({"merge", f / "split", "--step", step});
    }
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
    calls_.clear();
  }
  /// So that a call does its work again.
  static void forget() { std::filesystem::remove_all(*folder_ / "more"); }

  static Folder* folder_;
  static std::map<std::string, std::vector<Words>> calls_;
};
Folder* Called::folder_ = nullptr;
std::map<std::string, std::vector<Words>> Called::calls_;

using SlowCalled = Called;

TEST_F(Called, EveryCommandIs) {
  for (const Tool& tool : all_tools())
    for (const Words& words : known_commands(tool))
      EXPECT_TRUE(words == Words{"try"} ||  // a minute: SlowTry
                  std::any_of(calls_[tool.name].begin(), calls_[tool.name].end(),
                              [&](const Words& call) {
                                return std::equal(words.begin(), words.end(), call.begin());
                              }))
          << tool.name << " " << joined(words) << " is not tried";
}

/// NaN compares with no bound, so it passes between all of them.
TEST_F(Called, WhatIsNoNumberIsRefused) {
  std::size_t numbers = 0;
  const bool all = std::getenv("KERBSTONE_HEAVY") != nullptr;  // else one of five
  const std::regex number(
      "\n  (?:-[a-z],)?(--[a-z0-9-]+) "
      "(?:[^ ]+ or )?(?:[-0-9.e+]+ to [-0-9.e+]+|above 0|0 or more|a number)(?=[ =\n])");
  for (const Tool& tool : all_tools())
    for (const Words& call : calls_[tool.name]) {
      const std::string help = run_tool(tool.path, call + Words{"--help"}).out;
      EXPECT_THAT(help, Not(HasSubstr("FLOAT")));
      for (std::sregex_iterator i(help.begin(), help.end(), number), end; i != end; ++i)
        for (const char* value : {"nan", "-inf"}) {
          const std::string flag = (*i)[1];
          SCOPED_TRACE(fmt::format("{} {} {}={}", tool.name, call.front(), flag, value));
          const std::size_t k = numbers++;
          if (k % 5 != 0 && !all) continue;
          Words wrong = call;
          const auto given = std::find(wrong.begin(), wrong.end(), flag);
          if (given != wrong.end())
            wrong.erase(given, std::find_if(given + 1, wrong.end(), [](const std::string& word) {
                          return word.starts_with("-");
                        }));
          const ToolRun ran = run_tool(tool.path, wrong + Words{flag + "=" + value});
          EXPECT_EQ(ran.code, 2) << ran.err;
          expect_one_line(tool, ran.err);
          EXPECT_THAT(ran.err, HasSubstr(flag + ": "));
        }
    }
  EXPECT_GE(numbers, 200u);
}

TEST_F(SlowCalled, PrintsJsonNothingWhenQuietAndFailsOnAFullDisk) {
  for (const Tool& tool : all_tools())
    for (const Words& call : calls_[tool.name]) {
      SCOPED_TRACE(tool.name + " " + joined(call));
      forget();
      const ToolRun json = run_tool(tool.path, call + Words{"--json"});
      EXPECT_EQ(json.code, 0) << json.err;
      EXPECT_TRUE(nlohmann::json::accept(json.out)) << json.out.substr(0, 200);
      EXPECT_EQ(json.err.find_first_of("\r\033"), std::string::npos) << json.err;
      forget();
      const ToolRun quiet = run_tool(tool.path, Words{"--quiet"} + call);
      EXPECT_EQ(quiet.code, 0) << quiet.err;
      EXPECT_EQ(quiet.out + quiet.err, "");
      forget();
      const ToolRun full = run_tool(tool.path, call, {.out = "/dev/full"});
      EXPECT_EQ(full.code, 1);
      EXPECT_THAT(
          full.err,
          HasSubstr(tool.name + ": standard output cannot be written: No space left on device"));
    }
  for (const Tool& tool : all_tools())
    for (const char* flag : {"--help", "--version", "--man", "--completion"}) {
      const ToolRun full = run_tool(tool.path, {flag}, {.out = "/dev/full"});
      EXPECT_EQ(full.code, 1) << flag;
      expect_one_line(tool, full.err);
    }
}

TEST_F(Called, AMissingFileIsNamedInOneLine) {
  for (const Tool& tool : all_tools())
    for (const Words& call : calls_[tool.name])
      for (std::size_t i = 1; i < call.size(); ++i) {
        if (call[i - 1] == "-o" || !std::filesystem::exists(call[i])) continue;
        Words words = call;
        words[i] = *folder_ / ("missing\n" + std::filesystem::path(call[i]).extension().string());
        SCOPED_TRACE(tool.name + " " + joined(words));
        forget();
        const ToolRun ran = run_tool(tool.path, words);
        EXPECT_EQ(ran.code, 1);
        EXPECT_EQ(ran.out, "");
        expect_one_line(tool, ran.err);
        EXPECT_THAT(ran.err, HasSubstr("missing"));
      }
}

TEST_F(Called, OutputIsLookedAtBeforeTheWork) {
  for (const Tool& tool : all_tools())
    for (const Words& call : calls_[tool.name]) {
      const auto flag = std::find(call.begin(), call.end(), "-o");
      if (flag == call.end()) continue;
      Words words = call;
      words[static_cast<std::size_t>(flag - call.begin()) + 1] = "/proc/self/nowhere/x";
      SCOPED_TRACE(tool.name + " " + joined(words));
      const ToolRun ran = run_tool(tool.path, words);
      EXPECT_EQ(ran.code, 1);
      EXPECT_EQ(ran.out, "");
      expect_one_line(tool, ran.err);
      EXPECT_THAT(ran.err, HasSubstr("/proc/self/nowhere"));
    }
}

TEST_F(Called, AnEmptyOutputIsAWrongCommandLine) {
  for (const Tool& tool : all_tools())
    for (const Words& call : calls_[tool.name]) {
      const auto flag = std::find(call.begin(), call.end(), "-o");
      Words words = flag == call.end() ? call + Words{"-o", ""} : call;
      if (flag != call.end()) words[static_cast<std::size_t>(flag - call.begin()) + 1] = "";
      SCOPED_TRACE(tool.name + " " + joined(words));
      const ToolRun ran = run_tool(tool.path, words);
      EXPECT_EQ(ran.code, 2);
      expect_one_line(tool, ran.err);
      EXPECT_THAT(ran.err,
                  ::testing::ContainsRegex("--output: '' seen, a (file|folder) wanted; see "));
    }
}

TEST_F(SlowCalled, OneFileGoesToStandardOutputWithADash) {
  for (const Tool& tool : all_tools())
    for (const Words& call : calls_[tool.name]) {
      const auto flag = std::find(call.begin(), call.end(), "-o");
      if (flag == call.end()) continue;
      const std::string path = *(flag + 1);
      Words words = call;
      words[static_cast<std::size_t>(flag - call.begin()) + 1] = "-";
      SCOPED_TRACE(tool.name + " " + joined(words));
      if (!std::filesystem::exists(path)) run_tool(tool.path, call);
      const ToolRun ran = run_tool(tool.path, words);
      if (!std::filesystem::is_regular_file(path)) {
        EXPECT_EQ(ran.code, 2);
        EXPECT_THAT(ran.err, HasSubstr("'-' seen, a folder wanted"));
        continue;
      }
      ASSERT_EQ(ran.code, 0) << ran.err;
      EXPECT_TRUE(ran.out == cli::read(path))
          << ran.out.size() << " bytes, in the file " << cli::read(path).size();
      EXPECT_EQ(run_tool(tool.path, words, {.out = "/dev/full"}).code, 1);
    }
}

TEST_F(Called, OtherFilesThanTheFirstAreLookedAtBeforeTheWorkToo) {
  const Folder& f = *folder_;
  const std::string car = places::source() + "/vehicles/open_wheel/vehicle.yaml";
  const Words brakes{"brakes", f / "first_lap.csv", "--car", car};
  for (const Words& more : {Words{"-o", f / "b.txt", "-o", "/proc/self/nowhere/x.csv"},
                            Words{"-o", f / "b.txt", "-o", "/proc/self/nowhere/x.html"}}) {
    const ToolRun nowhere = run_tool(places::crgidentify(), brakes + more);
    EXPECT_EQ(nowhere.code, 1);
    EXPECT_THAT(nowhere.err, HasSubstr("/proc/self/nowhere"));
    EXPECT_EQ(nowhere.out, "");
  }
  for (const char* flag : {"--pad-map", "--plots"}) {
    const ToolRun both = run_tool(places::crgidentify(), brakes + Words{"-o", "-", flag, "-"});
    EXPECT_EQ(both.code, 2);
    EXPECT_THAT(both.err, HasSubstr("standard output takes one of them; name a file"));
  }
  const ToolRun two =
      run_tool(places::crgidentify(), brakes + Words{"-o", "a.html", "-o", "b.html"});
  EXPECT_EQ(two.code, 2);
  EXPECT_THAT(two.err, HasSubstr("a.html and b.html are files of one kind; give one"));
}

TEST_F(Called, WhatIsPrintedGoesToAFileWhereThereIsNoOther) {
  const Words call{"info", *folder_ / "out/s.crg"};
  const ToolRun printed = run_tool(places::crgbuild(), call),
                kept = run_tool(places::crgbuild(), call + Words{"-o", *folder_ / "info.txt"});
  EXPECT_EQ(kept.code, 0);
  EXPECT_EQ(kept.out, "");
  EXPECT_EQ(cli::read(*folder_ / "info.txt"), printed.out);
  EXPECT_EQ(run_tool(places::crgdrive(), {"parameters", "-o", "-"}).out,
            run_tool(places::crgdrive(), {"parameters"}).out);
}

TEST_F(Called, FormatsAndEndingsInAnyCase) {
  const Folder& f = *folder_;
  const auto bytes = [&](const Words& words, const std::string& path) {
    const ToolRun ran = run_tool(places::crgbuild(), words);
    EXPECT_EQ(ran.code, 0) << ran.err;
    return cli::read(path);
  };
  const std::string crg = f / "out/s.crg";
  EXPECT_EQ(bytes({"convert", crg, "--format", "LRFI", "-o", f / "upper.crg"}, f / "upper.crg"),
            bytes({"convert", crg, "--format", "lrfi", "-o", f / "lower.crg"}, f / "lower.crg"));
  EXPECT_THAT(bytes({"convert", crg, "--format", "LDFI", "-o", f / "ldfi.crg"}, f / "ldfi.crg"),
              HasSubstr("#:LDFI"));
  std::filesystem::copy_file(f / "s.obj", f / "UPPER.OBJ");
  EXPECT_EQ(run_tool(places::crgbuild(), {"clean", f / "UPPER.OBJ", "-o", f / "UPPER.STL"}).code,
            0);
  cli::write(f / "TRACK.YAML", "mesh: UPPER.OBJ\nformat: ldfi\n");
  const ToolRun recipe =
      run_tool(places::crgbuild(), {"build", f / "TRACK.YAML", "-o", f / "yaml", "--no-report"});
  EXPECT_EQ(recipe.code, 0) << recipe.err;
  std::filesystem::copy_file(crg, f / "ROAD.CRG");
  EXPECT_EQ(
      run_tool(places::lidar2mesh(), {"synth", f / "ROAD.CRG", "-o", f / "upper_scans", "--u-end-m",
                                      "10", "--azimuths", "64", "--beams", "8", "--laps", "1"})
          .code,
      0);
}

TEST_F(Called, StandardInputIsReadOrRefused) {
  const Folder& f = *folder_;
  const std::string crg = f / "out/s.crg";
  ASSERT_EQ(cli::crgbuild({"query", crg, "--points", f / "points.csv", "-o", f / "z.csv"}).code, 0);
  const ToolRun read = run_tool(places::crgbuild(), {"query", crg, "--points", "-", "-o", "-"},
                                {.in = f / "points.csv"});
  EXPECT_EQ(read.code, 0) << read.err;
  EXPECT_EQ(read.out, cli::read(f / "z.csv"));
  // A pipe cannot be searched.
  const ToolRun piped =
      run_tool("/bin/bash", {"-c", fmt::format("cat '{}' | '{}' query '{}' --points - -o -",
                                               f / "points.csv", places::crgbuild(), crg)});
  EXPECT_EQ(piped.out, cli::read(f / "z.csv")) << piped.err;
  const ToolRun unread =
      run_tool(places::crgbuild(), {"query", crg, "--points", "-", "-o", f / "unread.csv"},
               {.in = f.path()});
  EXPECT_EQ(unread.code, 1);
  EXPECT_THAT(unread.err, HasSubstr("standard input: cannot be read to its end"));
  EXPECT_FALSE(cli::exists(f / "unread.csv"));
  const ToolRun refused = run_tool(places::crgbuild(), {"info", "-"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("'-' seen, a file wanted"));
}

TEST_F(Called, ARoadIsNotBuiltAgain) {
  const ToolRun ran =
      run_tool(places::crgbuild(), {"build", *folder_ / "out/s.crg", "-o", *folder_ / "again"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err,
              ::testing::AllOf(HasSubstr("crgbuild info "), HasSubstr("crgbuild report ")));
}

TEST_F(Called, OutIsTakenForOutput) {
  const std::string crg = *folder_ / "out/s.crg";
  EXPECT_EQ(run_tool(places::crgbuild(), {"convert", crg, "--out", *folder_ / "old.crg"}).code, 0);
  EXPECT_EQ(
      run_tool(places::crgdrive(), {"parameters", "--out=" + (*folder_ / "parameters.md")}).code,
      0);
  EXPECT_TRUE(cli::exists(*folder_ / "old.crg") && cli::exists(*folder_ / "parameters.md"));
}

/// Commands that last, one of each tool.
std::map<std::string, Words> long_calls(const Folder& f, const std::string& trial) {
  return {
      {"crgbuild",
       {"build", f / "s.obj", "-o", f / "long", "--u-step-m", "0.01", "--v-step-m", "0.02",
        "--force", "--validate-points", "20000000"}},
      {"crgdrive",
       {"manoeuvre", "sine", "--car", trial + "vehicle.yaml", "--stop-s", "600", "--rate-hz",
        "1000", "-o", f / "long.csv"}},
      {"crgexplain",
       {"run", "--road", trial + "track.crg", "--car", trial + "vehicle.yaml", "--log",
        trial + "run.csv", "--nulls", "100000", "-o", f / "long_found"}},
      {"crgidentify",
       {"tyre", f / "bench.csv", "--tir", trial + "front.tir", "--starts", "1000", "-o",
        f / "long.tir"}},
      {"crgsim",
       {"run", f / "unit.fmu", "--stop-s", "600", "--record", "car.u", "-o", f / "long_run.csv"}},
      {"lidar2mesh",
       {"synth", places::source() + "/tracks/kerbstone-ring/circuit.yaml", "-o", f / "long_scans",
        "--beams", "200", "--azimuths", "4000"}},
      {"kerbstone", {"collect", f / "long_campaign"}}};
}

TEST_F(Called, ATerminalSeesProgressThatIsWipedOnCtrlC) {
  const auto calls = long_calls(*folder_, *folder_ / "trials/0000/");
  for (const Tool& tool : all_tools()) {
    SCOPED_TRACE(tool.name);
    const ToolRun ran =
        run_on_terminal(tool.path, calls.at(tool.name), "\r\033\\[K[^\r]*[a-z][^\r]*, [0-9]+ s");
    EXPECT_EQ(ran.code, 130) << ran.err;
    EXPECT_LT(ran.seconds_after_signal, 2.0);
    EXPECT_THAT(ran.err,
                HasSubstr("\r\033[K" + tool.name + ": interrupted; no file is half-written\r\n"));
    EXPECT_TRUE(ran.err.ends_with("half-written\r\n")) << ran.err;
    const ToolRun quiet = run_on_terminal(tool.path, {"--help"}, "");
    EXPECT_THAT(quiet.err, Not(HasSubstr("\033[")));
  }
}

TEST_F(SlowCalled, ATerminalIsToldTheTimeThatIsLeft) {
  const std::string said =
      run_on_terminal(places::lidar2mesh(),
                      {"synth", places::source() + "/tracks/kerbstone-ring/circuit.yaml", "-o",
                       *folder_ / "long_scans", "--threads", "1"},
                      "\r\033\\[K *[0-9]+ % scans, [0-9]+ s, [0-9]+ (s|min) left")
          .err;
  EXPECT_THAT(said, HasSubstr(" left")) << said;
}

TEST_F(Called, ErrorsAreColouredOnATerminalAlone) {
  for (const Tool& tool : all_tools()) {
    EXPECT_THAT(run_on_terminal(tool.path, {"nothing"}, "").err,
                HasSubstr("\033[31m" + tool.name + ":\033[0m "));
    EXPECT_THAT(run_on_terminal(tool.path, {"nothing"}, "", {"NO_COLOR=1"}).err,
                Not(HasSubstr("\033")));
    EXPECT_THAT(run_on_terminal(tool.path, {"nothing"}, "", {"TERM=dumb"}).err,
                Not(HasSubstr("\033")));
    EXPECT_THAT(run_tool(tool.path, {"nothing"}).err, Not(HasSubstr("\033")));
  }
}

/// One file or folder: its bytes are read again only where time or size say that they may differ.
struct Lying {
  std::filesystem::file_time_type written;
  std::uintmax_t size = 0;
  std::shared_ptr<const std::string> bytes;
};

bool same(const Lying& a, const Lying& b) { return a.bytes == b.bytes || *a.bytes == *b.bytes; }

/// All that lies in the folder, by name; `last`: what lay there when it was looked at before.
std::map<std::string, Lying> tree(const std::string& folder,
                                  const std::map<std::string, Lying>& last) {
  std::map<std::string, Lying> out;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string path = entry.path().string();
    const bool file = entry.is_regular_file();
    std::error_code none;  // a link into nothing has no time
    Lying lies{entry.last_write_time(none), file ? entry.file_size() : 0, nullptr};
    const auto known = last.find(path.substr(folder.size()));
    if (!file)
      lies.bytes = std::make_shared<const std::string>("folder");
    else if (known != last.end() && known->second.written == lies.written &&
             known->second.size == lies.size)
      lies.bytes = known->second.bytes;
    else
      lies.bytes = std::make_shared<const std::string>(cli::read(path));
    out[path.substr(folder.size())] = std::move(lies);
  }
  return out;
}

/// What the long calls may leave (docs/command_line.md): finished scans, and finished stages.
bool may_stay(const std::string& path) {
  static const std::regex scans("/long_scans(/scan_[0-9]+\\.ply|/(truth_)?trajectory\\.csv)?"),
      stages("/long_found(/\\.unfinished(/[a-z][^/]*)?)?"),
      collected("/long_campaign/(index\\.html|campaign\\.(csv|sqlite))");
  return std::regex_match(path, scans) || std::regex_match(path, stages) ||
         std::regex_match(path, collected);
}

// KERBSTONE_HEAVY=1: 100 moments instead of 8, docs/command_line.md.
TEST_F(SlowCalled, SignalsEndEveryToolAtAnyMoment) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const int moments = heavy ? 100 : 8;
  const auto calls = long_calls(*folder_, *folder_ / "trials/0000/");
  unsigned random = 12345;
  int interrupted = 0;
  double longest_s = 0.0;
  std::map<std::string, Lying> lies;
  for (int k = 0; k < moments; ++k)
    for (const Tool& tool : all_tools()) {
      random = random * 1664525u + 1013904223u;
      const double after_s = 0.02 + (heavy ? 6.0 : 1.5) * (random >> 8) / 16777216.0;
      const int signal = k % 2 == 0 ? SIGINT : SIGTERM;
      const auto before = tree(folder_->path(), lies);
      const ToolRun ran =
          run_tool(tool.path, calls.at(tool.name), {.signal_after_s = after_s, .signal = signal});
      SCOPED_TRACE(fmt::format("{} after {:.3f} s: {}", tool.name, after_s, ran.err));
      longest_s = std::max(longest_s, ran.seconds_after_signal);
      EXPECT_LT(ran.seconds_after_signal, 2.0);
      if (ran.code == 0 || ran.code == 3) continue;  // it had ended before
      lies = tree(folder_->path(), before);
      for (const auto& [path, was] : before)
        EXPECT_TRUE(lies.contains(path) && same(lies.at(path), was))
            << path << " is gone or changed";
      for (const auto& [path, is] : lies)
        EXPECT_TRUE(before.contains(path) || may_stay(path)) << path << " is left";
      ++interrupted;
      if (ran.code == 128 + signal && ran.err.empty()) continue;  // before main()
      EXPECT_EQ(ran.code, 128 + signal);
      EXPECT_THAT(ran.err, HasSubstr(tool.name + ": interrupted; no file is half-written\n"));
    }
  std::printf("%d of %d runs interrupted, the longest ended %.3f s after its signal\n", interrupted,
              5 * moments, longest_s);
  EXPECT_GT(interrupted, 2 * moments);
}

}  // namespace habits_test
