// Every subcommand, run as the program it is.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "base/json_text.h"
#include "support/places.h"
#include "support/run_crgbuild.h"

namespace cli {
namespace commands_test {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using Json = nlohmann::json;

const std::vector<std::string> kSubcommands = {
    "build",      "validate", "info",    "query",  "synth",     "from-edges", "clean",
    "centreline", "sample",   "kerb",    "smooth", "align",     "check",      "convert",
    "crop",       "resample", "reverse", "append", "transform", "report",     "export"};

std::vector<std::vector<std::string>> csv(const std::string& path) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(read(path));
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::string cell;
    for (const char c : line + ",")
      if (c == ',')
        rows.back().push_back(std::exchange(cell, {}));
      else
        cell += c;
  }
  return rows;
}

/// A built stadium, made once for all tests that only read it.
class Built : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = new Folder;
    write(*folder / "stadium.obj", Stadium{}.obj());
    ran = crgbuild({"build", *folder / "stadium.obj", "-o", *folder / "out", "--start-at", "0,0"});
  }
  static void TearDownTestSuite() {
    delete folder;
    folder = nullptr;
  }
  static std::string out(const std::string& name) { return *folder / ("out/" + name); }
  static Json summary() { return base::parse_json<Json>(read(out("summary.json"))); }

  static inline Folder* folder = nullptr;
  static inline Ran ran;
};

TEST(Help, EverySubcommandHasOneWithAnExample) {
  const Ran top = crgbuild({"--help"});
  EXPECT_EQ(top.code, 0);
  EXPECT_THAT(top.out, HasSubstr("crgbuild build track.obj -o out"));
  for (const std::string& name : kSubcommands) {
    const Ran help = crgbuild({name, "--help"});
    EXPECT_EQ(help.code, 0) << name;
    EXPECT_THAT(top.out, HasSubstr(name));
    EXPECT_THAT(help.out, HasSubstr("crgbuild " + name + " ")) << name;
    EXPECT_THAT(help.out, ::testing::ContainsRegex("Examples?:")) << name;
    EXPECT_EQ(help.err, "") << name;
  }
  EXPECT_THAT(crgbuild({"--version"}).out, HasSubstr("crgbuild "));
}

/// Messages of the libraries tell the user which flag to give: each must exist.
TEST(Help, FlagsNamedInErrorsExist) {
  std::string help = crgbuild({"--help"}).out;
  for (const std::string& name : kSubcommands) help += crgbuild({name, "--help"}).out;
  const std::regex flag("--[a-z][a-z-]*[a-z]");
  const std::regex literal("\"(?:[^\"\\\\\n]|\\\\.)*\"");
  std::set<std::string> known;
  for (std::sregex_iterator i(help.begin(), help.end(), flag), end; i != end; ++i)
    known.insert(i->str());
  for (const char* library : {"mesh", "circuit", "road", "inspect", "make"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(
             places::source() + "/lib/" + library + "/src")) {
      if (!entry.is_regular_file()) continue;
      const std::string text = read(entry.path());
      for (std::sregex_iterator l(text.begin(), text.end(), literal), end; l != end; ++l) {
        const std::string words = l->str();
        for (std::sregex_iterator i(words.begin(), words.end(), flag); i != end; ++i)
          EXPECT_TRUE(known.count(i->str())) << entry.path() << " names " << i->str();
      }
    }
}

TEST(Usage, WrongCommandLinesAreOneLineAndExitCode2) {
  const Folder folder;
  write(folder / "s.obj", Stadium{}.obj());
  const std::string mesh = folder / "s.obj", out = folder / "out";
  const std::vector<std::vector<std::string>> wrong = {
      {},
      {"biuld", mesh},
      {mesh},
      {"build", mesh},
      {"build", "-o", out},
      {"build", mesh, "-o", out, "--no-such-flag"},
      {"build", mesh, "-o", out, "--u-step-m", "50"},
      {"build", mesh, "-o", out, "--u-step-m", "nan"},
      {"build", mesh, "-o", out, "--v-step-m", "1e999"},
      {"build", mesh, "-o", out, "--up", "w"},
      {"build", mesh, "-o", out, "--unit", "furlong"},
      {"build", mesh, "-o", out, "--scale", "0"},
      {"build", mesh, "-o", out, "--scale", "-1"},
      {"build", mesh, "-o", out, "--format", "XXXX"},
      {"build", mesh, "-o", out, "--threads", "-1"},
      {"build", mesh, "-o", out, "--name", "../x"},
      {"build", mesh, "-o", out, "--yaw-deg", "1", "--control-points", "p.csv"},
      {"smooth", "x.crg", "-o", "y.crg", "--smooth-window-m", "1"},
      {"align", "x.crg", "-o", "y.crg"},
      {"query", "x.crg"},
  };
  for (const auto& arguments : wrong) {
    const Ran ran = crgbuild(arguments);
    const std::string shown = fmt::format("{}: {}", fmt::join(arguments, " "), ran.err);
    EXPECT_EQ(ran.code, 2) << shown;
    EXPECT_THAT(ran.err, StartsWith("crgbuild: ")) << shown;
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << shown;
    EXPECT_THAT(ran.err, HasSubstr("--help")) << shown;
    EXPECT_EQ(ran.out, "") << shown;
    EXPECT_FALSE(exists(out)) << shown;
  }
}

TEST_F(Built, WritesItsFilesAndSaysWhere) {
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_EQ(ran.err, "");  // silent in a pipe
  for (const char* name :
       {"stadium.crg", "stadium.png", "stadium.classes.png", "stadium.classes.pgw", "stadium.stl",
        "centreline.csv", "summary.json", "timing.json", "manifest.json", "report.json"}) {
    EXPECT_TRUE(exists(out(name))) << name;
  }
  EXPECT_THAT(ran.out, HasSubstr(out("stadium.crg")));
  EXPECT_THAT(ran.out, HasSubstr(out("stadium.png")));
  EXPECT_THAT(ran.out, HasSubstr("  u runs counter-clockwise (--reverse turns it round)\n"));
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(*folder / "out"))
    ++files;
  // The page is missing only where its npm packages are.
  EXPECT_EQ(files, exists(out("report.html")) ? 11u : 10u) << "something was left behind";
}

TEST_F(Built, SummaryHasTheFixedKeysAndTheRightNumbers) {
  const Json s = summary();
  // 246 chords per lap; the line is a smooth curve through their ends, 1e-4 of the length.
  EXPECT_NEAR(s["reference_line"]["length_m"], Stadium::length_m(), 5e-4 * Stadium::length_m());
  EXPECT_EQ(s["reference_line"]["closed"], true);
  EXPECT_GT(s["grid"]["nodes"].get<double>(), 0);
  EXPECT_EQ(s["grid"]["holes"], 0);
  EXPECT_NEAR(s["grid"]["u_step_m"], 0.1, 1e-4);
  for (const char* key : {"p50", "p95", "p99", "max"})
    EXPECT_LT(s["validation"]["z_error_m"][key].get<double>(), 0.005) << key;
  EXPECT_TRUE(s["validation"]["passed"]);
  const Json timing = base::parse_json<Json>(read(out("timing.json")));
  EXPECT_GT(timing["seconds"]["total"].get<double>(), 0.0);
  EXPECT_GT(timing["peak_memory_mb"].get<double>(), 1.0);
  EXPECT_EQ(s["inputs"][0]["role"], "mesh");
  EXPECT_EQ(s["inputs"][0]["sha256"].get<std::string>().size(), 64u);
  EXPECT_NEAR(s["centreline"]["width_median_m"], 10.0, 0.05);
  EXPECT_GT(s["clean"]["triangles_dropped_by_reason"]["scenery"].get<int>(), 0);
}

TEST_F(Built, JsonPrintsTheSummaryAndQuietNothing) {
  const auto build = [](const std::string& flag) {
    return crgbuild({"build", *folder / "stadium.obj", "-o", *folder / "json", "--u-step-m", "0.5",
                     "--v-step-m", "0.5", "--force", flag});
  };
  const Ran json = build("--json");
  EXPECT_EQ(json.out, read(*folder / "json/summary.json"));
  const Ran quiet = build("--quiet");
  EXPECT_EQ(quiet.out + quiet.err, "");
}

TEST_F(Built, AnyNumberOfThreadsWritesTheSameBytes) {
  const std::string dir = *folder / "threads";
  std::map<std::string, std::string> first;
  for (const char* threads : {"1", "3"}) {
    ASSERT_EQ(crgbuild({"build", *folder / "stadium.obj", "-o", dir, "--start-at", "0,0", "--force",
                        "--threads", threads})
                  .code,
              0);
    for (const char* name : {"/stadium.crg", "/stadium.png", "/stadium.stl", "/centreline.csv",
                             "/summary.json", "/report.json", "/report.html", "/manifest.json"}) {
      const auto [kept, is_first] = first.emplace(name, read(dir + name));
      EXPECT_FALSE(kept->second.empty()) << name;
      EXPECT_TRUE(is_first || read(dir + name) == kept->second) << threads << name;
    }
  }
}

TEST_F(Built, InfoTellsWhatTheFileHolds) {
  const Ran human = crgbuild({"info", out("stadium.crg")});
  EXPECT_EQ(human.code, 0) << human.err;
  EXPECT_THAT(human.out, HasSubstr("closed"));
  const Json j = base::parse_json<Json>(crgbuild({"info", out("stadium.crg"), "--json"}).out);
  EXPECT_EQ(j["format"], "KRBI");
  EXPECT_EQ(j["grid"]["nodes"], summary()["grid"]["nodes"]);
  EXPECT_EQ(j["grid"]["holes"], 0);
  EXPECT_TRUE(j["reference_line"]["closed"]);
}

TEST_F(Built, QueryAnswersMapAndRoadCoordinates) {
  write(*folder / "xy.csv", "id,y_m,x_m\n1,0,60\n2,2.5,60\r\n3,1000,60\n4,nan,0\n5,,3\n");
  const Ran r = crgbuild(
      {"query", out("stadium.crg"), "--points", *folder / "xy.csv", "-o", *folder / "xy_out.csv"});
  ASSERT_EQ(r.code, 0) << r.err;
  const auto rows = csv(*folder / "xy_out.csv");
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_EQ(fmt::format("{}", fmt::join(rows[0], ",")),
            "x_m,y_m,u_m,v_m,z_m,heading_rad,curvature_1pm,dzdx,dzdy");
  for (const auto& row : rows) EXPECT_EQ(row.size(), 9u);
  EXPECT_EQ(rows[1][0], "60");
  EXPECT_NEAR(std::stod(rows[1][2]), 60.0, 0.05);
  EXPECT_NEAR(std::stod(rows[1][3]), 0.0, 0.02);
  EXPECT_NEAR(std::stod(rows[1][4]), Stadium::z_m(60), 0.005);  // chords of the mesh: 2 mm
  EXPECT_NEAR(std::stod(rows[1][8]), 0.02, 0.001);
  EXPECT_NEAR(std::stod(rows[2][4]) - std::stod(rows[1][4]), 0.05, 0.002);
  // Beside the road: no height, but a place and a heading; the far straight, driven towards -x at y
  // = 80, is the nearest.
  EXPECT_NEAR(std::stod(rows[3][2]), Stadium::length_m() / 2 + 60.0, 0.05);
  EXPECT_NEAR(std::stod(rows[3][3]), -920.0, 0.02);
  EXPECT_NEAR(std::abs(std::stod(rows[3][5])), M_PI, 1e-4);
  for (const std::size_t height : {4u, 7u, 8u}) EXPECT_EQ(rows[3][height], "");
  EXPECT_EQ(rows[4], (std::vector<std::string>{"0", "", "", "", "", "", "", "", ""}));
  EXPECT_EQ(rows[5], (std::vector<std::string>{"3", "", "", "", "", "", "", "", ""}));

  write(*folder / "uv.csv", "u_m,v_m\n60,2.5\n60,500\n");
  ASSERT_EQ(crgbuild({"query", out("stadium.crg"), "--points", *folder / "uv.csv", "-o",
                      *folder / "uv_out.csv"})
                .code,
            0);
  const auto uv = csv(*folder / "uv_out.csv");
  ASSERT_EQ(uv.size(), 3u);
  EXPECT_NEAR(std::stod(uv[1][0]), 60.0, 0.05);
  EXPECT_NEAR(std::stod(uv[1][1]), 2.5, 0.02);
  EXPECT_EQ(uv[1][2], "60");
  EXPECT_NEAR(std::stod(uv[2][0]), 60.0, 0.05);
  EXPECT_NEAR(std::stod(uv[2][1]), 500.0, 0.02);
  for (const std::size_t height : {4u, 7u, 8u}) EXPECT_EQ(uv[2][height], "");
}

TEST_F(Built, QueryAnswersEveryRowWhateverItIsCalled) {
  write(*folder / "named.csv", "id,u_m,v_m\n# by hand\n#1,60,0\n#2,61,0,\n,,\n\n3,62,0\n");
  ASSERT_EQ(crgbuild({"query", out("stadium.crg"), "--points", *folder / "named.csv", "-o",
                      *folder / "named_out.csv"})
                .code,
            0);
  const auto rows = csv(*folder / "named_out.csv");
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_EQ(rows[1][2], "60");
  EXPECT_EQ(rows[3][2], "");
  EXPECT_EQ(rows[4][2], "62");
}

TEST_F(Built, QueryOfManyPointsKeepsOrderForAnyThreads) {
  std::string points = "x_m,y_m\n";
  for (int i = 0; i < 50000; ++i)
    points += fmt::format("{},{}\n", (i * 7919) % 12000 / 100.0, (i % 100) / 20.0);
  write(*folder / "many.csv", points);
  for (const char* threads : {"1", "4"})
    ASSERT_EQ(crgbuild({"query", out("stadium.crg"), "--points", *folder / "many.csv", "-o",
                        *folder / (std::string("many") + threads), "--threads", threads})
                  .code,
              0);
  EXPECT_TRUE(read(*folder / "many1") == read(*folder / "many4"));
  const auto rows = csv(*folder / "many1");
  ASSERT_EQ(rows.size(), 50001u);
  for (std::size_t i = 0; i < 50000; i += 977)
    EXPECT_DOUBLE_EQ(std::stod(rows[i + 1][0]), static_cast<double>((i * 7919) % 12000) / 100.0);
}

TEST_F(Built, QueryRefusesBadPoints) {
  const std::vector<std::pair<std::string, std::string>> bad = {
      {"", "x_m and y_m"},
      {"a,b\n1,2\n", "bad.csv:1: the columns 'a,b' seen"},
      {"x_m,y_m\n1,2\n1,abc\n", "bad.csv:3: column 'y_m' holds 'abc'"},
      {"x_m,y_m\n1\n", "bad.csv:2: '1' has 1 cells"},
      {"# by hand\n\nx_m,y_m\n1,2\n10,5,1\n", "bad.csv:5: '10,5,1' has 3 cells"}};
  for (const auto& [text, wanted] : bad) {
    write(*folder / "bad.csv", text);
    const Ran r = crgbuild({"query", out("stadium.crg"), "--points", *folder / "bad.csv", "-o",
                            *folder / "bad_out.csv"});
    EXPECT_EQ(r.code, 1);
    EXPECT_THAT(r.err, HasSubstr(wanted));
    EXPECT_FALSE(exists(*folder / "bad_out.csv"));
  }
  EXPECT_EQ(
      crgbuild({"query", out("stadium.crg"), "--points", "/no/such.csv", "-o", *folder / "o.csv"})
          .code,
      1);
}

/// The stages one by one, through files, give the road that build gives.
TEST_F(Built, StagesOneByOneEqualBuild) {
  for (const char* ending : {"obj", "stl"}) {
    const std::string surface = *folder / (std::string("surface.") + ending);
    const auto stage = [&](std::vector<std::string> arguments) {
      const Ran r = crgbuild(arguments);
      ASSERT_EQ(r.code, 0) << arguments[0] << ": " << r.err;
    };
    stage({"clean", *folder / "stadium.obj", "-o", surface});
    stage({"centreline", surface, "-o", *folder / "c.csv", "--start-at", "0,0"});
    stage({"sample", surface, "--centreline", *folder / "c.csv", "-o", *folder / "sampled.crg"});
    stage({"kerb", *folder / "sampled.crg", "--mesh", surface, "-o", *folder / "kerb.crg"});
    stage({"validate", *folder / "kerb.crg", *folder / "stadium.obj"});
    write(*folder / "p.csv", "u_m,v_m\n1,0\n50.05,3.33\n123.4,-4.9\n300.01,-7\n480,6.5\n");
    stage({"query", *folder / "kerb.crg", "--points", *folder / "p.csv", "-o",
           *folder / "stages.csv"});
    stage(
        {"query", out("stadium.crg"), "--points", *folder / "p.csv", "-o", *folder / "built.csv"});
    const auto a = csv(*folder / "stages.csv"), b = csv(*folder / "built.csv");
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 1; i < a.size(); ++i)
      for (std::size_t j = 0; j < 5; ++j)  // coordinates pass through text with 0.1 mm
        EXPECT_NEAR(std::stod(a[i][j]), std::stod(b[i][j]), 2e-4)
            << ending << " row " << i << " column " << j;
  }
}

TEST_F(Built, SmoothStaysWithinItsBound) {
  const Ran r = crgbuild({"smooth", out("stadium.crg"), "--mesh", *folder / "stadium.obj",
                          "--smooth-window-m", "2", "-o", *folder / "smooth.crg", "--json"});
  ASSERT_EQ(r.code, 0) << r.err;
  const Json j = base::parse_json<Json>(r.out);
  EXPECT_GT(j["largest_change_road_m"].get<double>(), 0.0);
  EXPECT_LE(j["largest_change_road_m"].get<double>(), 0.002 + 1e-9);
  EXPECT_EQ(crgbuild({"smooth", out("stadium.crg"), "--ignore-kerbs", "--smooth-window-m", "2",
                      "-o", *folder / "smooth2.crg"})
                .code,
            0);
}

TEST_F(Built, AlignMovesTheRoadAndValidateKnowsIt) {
  const std::vector<std::string> move = {"--yaw-deg", "90", "--translation-m", "1000,2000,30"};
  std::vector<std::string> align = {
      "align", out("stadium.crg"), "-o", *folder / "global.crg", "--format", "KDBI"};
  align.insert(align.end(), move.begin(), move.end());
  ASSERT_EQ(crgbuild(align).code, 0);
  write(*folder / "g.csv", "x_m,y_m\n1000,2060\n");  // (60, 0) of the mesh
  ASSERT_EQ(crgbuild({"query", *folder / "global.crg", "--points", *folder / "g.csv", "-o",
                      *folder / "g_out.csv"})
                .code,
            0);
  const auto rows = csv(*folder / "g_out.csv");
  ASSERT_NE(rows[1][4], "");
  EXPECT_NEAR(std::stod(rows[1][4]), 30.0 + Stadium::z_m(60), 0.005);

  std::vector<std::string> validate = {"validate", *folder / "global.crg", *folder / "stadium.obj"};
  EXPECT_EQ(crgbuild(validate).code, 3);
  validate.insert(validate.end(), move.begin(), move.end());
  EXPECT_EQ(crgbuild(validate).code, 0);
}

TEST_F(Built, FailedValidationIsExitCode3InOneLine) {
  const Ran r = crgbuild({"build", *folder / "stadium.obj", "-o", *folder / "strict",
                          "--max-z-error-p99-m", "0", "--smooth-window-m", "5"});
  EXPECT_EQ(r.code, 3);
  EXPECT_THAT(r.err, StartsWith("crgbuild: "));
  EXPECT_THAT(r.err,
              HasSubstr("not usable, 1 error: 1 % of the points of the road are more than "));
  EXPECT_THAT(r.err, HasSubstr(" at u = "));
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1);
  EXPECT_FALSE(
      base::parse_json<Json>(read(*folder / "strict/summary.json"))["validation"]["passed"]);
  // The report of the same run says the same.
  EXPECT_THAT(r.out, HasSubstr("(not usable: 1 error, "));
  const Json report = base::parse_json<Json>(read(*folder / "strict/report.json"));
  EXPECT_EQ(report["verdict"], "not_usable");
  EXPECT_EQ(report["findings"][0]["kind"], "validation");
}

TEST_F(Built, SaysHowWellItWasAlignedAndThatSmoothingWasHeldBack) {
  std::string points = "name,mesh_x_m,mesh_y_m,mesh_z_m,x_m,y_m,z_m\n";
  const std::pair<double, double> places[] = {{0, 0}, {100, 0}, {100, 80}, {0, 80}, {50, 40}};
  int k = 0;
  for (const auto& [x, y] : places) {
    points +=
        fmt::format("P{},{},{},0,{},{},3\n", k, x, y, 1000 + x, 2000 + y + (k == 4 ? 2.5 : 0));
    ++k;
  }
  write(*folder / "points.csv", points);
  const Ran r = crgbuild({"build", *folder / "stadium.obj", "-o", *folder / "aligned",
                          "--control-points", *folder / "points.csv", "--smooth-window-m", "5",
                          "--smooth-max-change-road-m", "0.0000001", "--no-report"});
  EXPECT_EQ(r.code, 0) << r.err;
  EXPECT_THAT(r.out,
              HasSubstr("aligned  by 4 control points: rms 0.0 mm, the largest 0.0 mm at P"));
  EXPECT_THAT(r.out, HasSubstr("left out, as they contradict the others: P4 (2.500 m)"));
  EXPECT_THAT(r.out, HasSubstr("smoothing was held at its bound at "));
}

TEST_F(Built, FlagsOverrideTheRecipe) {
  write(*folder / "track.yaml",
        "mesh: stadium.obj\nname: from recipe\nu_step_m: 0.5\nv_step_m: 0.5\nformat: LRFI\n");
  ASSERT_EQ(
      crgbuild({"build", *folder / "track.yaml", "-o", *folder / "r", "--u-step-m", "0.25"}).code,
      0);
  const Json j =
      base::parse_json<Json>(crgbuild({"info", *folder / "r/from recipe.crg", "--json"}).out);
  EXPECT_NEAR(j["grid"]["u_step_m"], 0.25, 0.001);
  EXPECT_EQ(j["format"], "LRFI");
  const Json s = base::parse_json<Json>(read(*folder / "r/summary.json"));
  EXPECT_EQ(s["inputs"][0]["role"], "recipe");
  EXPECT_DOUBLE_EQ(s["recipe"]["v_step_m"], 0.5);
}

TEST(Synth, DemoCircuitGivesAMeshThatBuilds) {
  const Folder folder;
  write(folder / "oval.yaml",
        "name: oval\nplan:\n  - straight: {length_m: 100}\n  - corner: {radius_m: 40, angle_deg: "
        "180, clothoid_m: 20}\n"
        "  - straight: {length_m: 100}\n  - corner: {radius_m: 40, angle_deg: 180, clothoid_m: "
        "20}\n");
  const Ran synth = crgbuild({"synth", folder / "oval.yaml", "-o", folder / "out", "--format",
                              "ply", "--up", "z", "--json"});
  ASSERT_EQ(synth.code, 0) << synth.err;
  const Json j = base::parse_json<Json>(synth.out);
  ASSERT_TRUE(exists(j["mesh"]));
  EXPECT_EQ(crgbuild({"info", j["truth"]}).code, 0);

  const Ran coarse = crgbuild({"synth", folder / "oval.yaml", "-o", folder / "coarse", "--unit",
                               "cm", "--step-m", "8", "--json"});
  ASSERT_EQ(coarse.code, 0) << coarse.err;
  const Json k = base::parse_json<Json>(coarse.out);
  EXPECT_LT(k["triangles"].get<int>(), j["triangles"].get<int>() / 3);
  const Ran built = crgbuild({"build", k["mesh"], "-o", folder / "coarse", "--unit", "cm"});
  ASSERT_EQ(built.code, 0) << built.err;
  const Json summary = base::parse_json<Json>(read(folder / "coarse/summary.json"));
  EXPECT_NEAR(summary["reference_line"]["length_m"], k["length_m"].get<double>(), 1.0);
}

TEST(Build, NothingChangedIsReusedUnlessForced) {
  const Folder folder;
  write(folder / "s.obj", Stadium{}.obj());
  std::vector<std::string> command = {"build", folder / "s.obj", "-o", folder / "out", "--u-step-m",
                                      "0.5",   "--v-step-m",     "0.5"};
  const auto reused = [&](const std::vector<std::string>& line) {
    const Ran ran = crgbuild(line);
    EXPECT_EQ(ran.code, 0) << ran.err;
    return ran.out.find("reused: nothing has changed") != std::string::npos;
  };
  EXPECT_FALSE(reused(command));
  const std::string summary = read(folder / "out/summary.json"), road = read(folder / "out/s.crg");
  EXPECT_TRUE(reused(command));
  EXPECT_EQ(read(folder / "out/summary.json"), summary);
  std::vector<std::string> forced = command, finer = command;
  forced.push_back("--force");
  EXPECT_FALSE(reused(forced));
  EXPECT_TRUE(read(folder / "out/s.crg") == road);
  finer[5] = "0.4";
  EXPECT_FALSE(reused(finer));
  EXPECT_FALSE(reused(command));
  // A summary that somebody cut.
  Json cut = base::parse_json<Json>(read(folder / "out/summary.json"));
  cut["kerb"].erase("kerbs");
  write(folder / "out/summary.json", base::dump_json(cut));
  EXPECT_FALSE(reused(command));
  EXPECT_TRUE(reused(command));
  // A file that is gone, changed, or a summary that is none.
  std::filesystem::remove(folder / "out/centreline.csv");
  EXPECT_FALSE(reused(command));
  write(folder / "out/s.crg", road.substr(0, road.size() / 2));
  EXPECT_FALSE(reused(command));
  EXPECT_TRUE(read(folder / "out/s.crg") == road);
  write(folder / "out/summary.json", "{\"schema\": 1, \"outputs\": 7}");
  EXPECT_FALSE(reused(command));
  // Another mesh under the same name.
  Stadium bare;
  bare.trees = false;
  write(folder / "s.obj", bare.obj());
  EXPECT_FALSE(reused(command));
}

TEST(FromEdges, WritesOneRoadNamedAfterItsFiles) {
  const Folder folder;
  const auto edge = [](double y, const char* rest) {
    std::string text = "x_m,y_m,z_m\n";
    for (int i = 0; i <= 40; ++i) text += fmt::format("{},{},{}\n", 5 * i, y, 1.0 + 0.02 * y);
    return text + rest;
  };
  write(folder / "hill_left.csv", edge(4.0, ""));
  write(folder / "hill_right.csv", edge(-4.0, ""));
  const Ran ran = crgbuild({"from-edges", folder / "hill_left.csv", folder / "hill_right.csv", "-o",
                            folder / "out", "--u-step-m", "0.5", "--v-step-m", "0.5", "--json"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const Json s = base::parse_json<Json>(ran.out);
  EXPECT_EQ(s, base::parse_json<Json>(read(folder / "out/summary.json")));
  EXPECT_FALSE(s["reference_line"]["closed"].get<bool>());
  EXPECT_NEAR(s["edges"]["width_median_m"].get<double>(), 8.0, 1e-6);
  EXPECT_EQ(s["inputs"].size(), 2u);
  EXPECT_TRUE(exists(folder / "out/hill.png"));
  EXPECT_TRUE(exists(folder / "out/centreline.csv"));
  write(folder / "points.csv", "x_m,y_m\n100,3\n100,4.1\n");
  ASSERT_EQ(crgbuild({"query", folder / "out/hill.crg", "--points", folder / "points.csv", "-o",
                      folder / "z.csv"})
                .code,
            0);
  EXPECT_THAT(read(folder / "z.csv"), HasSubstr("\n100,3,100"));
  EXPECT_THAT(read(folder / "z.csv"), HasSubstr("\n100,4.1,100,4.1,,0,0,,\n"));

  const Ran swapped = crgbuild({"from-edges", folder / "hill_right.csv", folder / "hill_left.csv",
                                "-o", folder / "swapped"});
  EXPECT_EQ(swapped.code, 1);
  EXPECT_THAT(swapped.err, HasSubstr("exchange the two files"));
  EXPECT_FALSE(exists(folder / "swapped"));
  write(folder / "bad.csv", edge(-4.0, "x,0,0\n"));
  const Ran bad =
      crgbuild({"from-edges", folder / "hill_left.csv", folder / "bad.csv", "-o", folder / "bad"});
  EXPECT_EQ(bad.code, 1);
  EXPECT_THAT(bad.err, HasSubstr("bad.csv:43"));
}

}  // namespace commands_test
}  // namespace cli
