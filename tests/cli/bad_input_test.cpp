// Input that cannot be used: one clear line, an exit code, nothing half-written.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "support/run_crgbuild.h"

namespace cli {
namespace bad_input_test {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// Refused with exit code 1, in one line that has all of `wanted`; no road under its final name.
void expect_refused(const Ran& ran, const std::string& out_dir,
                    const std::vector<std::string>& wanted) {
  EXPECT_EQ(ran.code, 1) << ran.err;
  EXPECT_THAT(ran.err, StartsWith("crgbuild: "));
  EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  for (const std::string& text : wanted) EXPECT_THAT(ran.err, HasSubstr(text));
  EXPECT_EQ(ran.out, "");
  if (!exists(out_dir)) return;
  for (const auto& entry : std::filesystem::directory_iterator(out_dir)) {
    EXPECT_NE(entry.path().extension(), ".crg");
    EXPECT_NE(entry.path().filename(), "summary.json");
  }
}

Ran build(const Folder& folder, const std::string& mesh, std::vector<std::string> flags = {}) {
  std::vector<std::string> arguments = {"build",      mesh,  "-o",         folder / "out",
                                        "--u-step-m", "0.5", "--v-step-m", "0.5"};
  arguments.insert(arguments.end(), flags.begin(), flags.end());
  return crgbuild(arguments);
}

/// Writes `bytes` as `name`, builds, expects a refusal.
void expect_mesh_refused(const std::string& name, const std::string& bytes,
                         const std::vector<std::string>& wanted,
                         std::vector<std::string> flags = {}) {
  SCOPED_TRACE(name);
  const Folder folder;
  write(folder / name, bytes);
  expect_refused(build(folder, folder / name, std::move(flags)), folder / "out", wanted);
}

TEST(BadInput, MissingEmptyTruncatedNoMesh) {
  const Folder folder;
  expect_refused(build(folder, "/no/such/mesh.obj"), folder / "out", {"/no/such/mesh.obj"});
  expect_refused(build(folder, folder.path()), folder / "out", {folder.path()});
  expect_refused(build(folder, "/no/such/track.yaml"), folder / "out", {"/no/such/track.yaml"});
  for (const char* name : {"a.obj", "a.stl", "a.ply", "a.glb", "a.fbx", "a.ac", "a.3ds", "a.dae"}) {
    expect_mesh_refused(name, "", {name, "empty"});
    expect_mesh_refused(name, "this is no mesh at all\n", {name});
    expect_mesh_refused(name, std::string("\0\1\2\3\xff\xfe garbage", 14), {name});
  }
  expect_mesh_refused("a.xyz", "1 2 3\n", {"a.xyz"});
  const std::string mesh = Stadium{}.obj();
  write(folder / "s.obj", mesh);
  ASSERT_EQ(crgbuild({"clean", folder / "s.obj", "-o", folder / "s.stl"}).code, 0);
  const std::string stl = read(folder / "s.stl");
  expect_mesh_refused("half.stl", stl.substr(0, stl.size() / 2), {"half.stl"});
  expect_mesh_refused("half_a_number.obj", mesh.substr(0, mesh.find("f ") - 5),
                      {"half_a_number.obj"});
}

TEST(BadInput, OpenRoadWorksAndSaysSo) {
  const Folder folder;
  Stadium stadium;
  stadium.closed = false;
  write(folder / "open.obj", stadium.obj());
  const Ran ran = build(folder, folder / "open.obj");
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("open road"));
  const auto s = base::parse_json<nlohmann::json>(read(folder / "out/summary.json"));
  EXPECT_EQ(s["reference_line"]["closed"], false);
}

TEST(BadInput, WrongUnitSaysWhichFlagToGive) {
  for (const auto& [unit, scale] : {std::pair{"mm", 1000.0}, std::pair{"ft", 1 / 0.3048},
                                    std::pair{"cm", 100.0}, std::pair{"inch", 1 / 0.0254}}) {
    const bool usual = std::string(unit) == "mm" || std::string(unit) == "ft";
    if (!usual && std::getenv("KERBSTONE_HEAVY") == nullptr) continue;
    Stadium stadium;
    stadium.scale = scale;
    const Folder folder;
    write(folder / "s.obj", stadium.obj());
    if (std::string(unit) == "ft") {  // 1,600 by 33 ft could be metres, but hardly are
      const Ran wide = build(folder, folder / "s.obj");
      EXPECT_EQ(wide.code, 3) << wide.out;
      EXPECT_THAT(wide.out + wide.err, HasSubstr("with --unit ft there is a closed road of"));
      EXPECT_THAT(wide.out, HasSubstr("triangles  object  material  (why)\nroad ")) << "a doubt";
      EXPECT_EQ(build(folder, folder / "s.obj", {"--line-is-right"}).code, 0);
    } else {  // in mm larger than any track
      const Ran asked = build(folder, folder / "s.obj");
      EXPECT_EQ(asked.code, 3) << asked.err;
      EXPECT_THAT(asked.out + asked.err, HasSubstr(fmt::format("--unit {}", unit)));
    }
    const Ran ran = build(folder, folder / "s.obj", {"--unit", unit});
    EXPECT_EQ(ran.code, 0) << unit << ran.err;
    const auto s = base::parse_json<nlohmann::json>(read(folder / "out/summary.json"));
    EXPECT_NEAR(s["reference_line"]["length_m"], Stadium::length_m(), 0.3) << unit;
  }
}

TEST(BadInput, AScaleStandsForAUnitWithoutAName) {
  Stadium stadium;
  stadium.scale = 1 / 0.254;
  const Folder folder;
  write(folder / "s.obj", stadium.obj());
  const Ran ran = build(folder, folder / "s.obj", {"--scale", "0.254"});
  EXPECT_EQ(ran.code, 0) << ran.err;
  const auto s = base::parse_json<nlohmann::json>(read(folder / "out/summary.json"));
  EXPECT_NEAR(s["reference_line"]["length_m"], Stadium::length_m(), 0.3);
  EXPECT_EQ(s["read"]["scale"], 0.254);
}

TEST(BadInput, OfAToyTheScaleIsAskedThatMakesARoadOfIt) {
  // An eight of about 16 units, 1 wide, that crosses itself.
  constexpr int kStations = 200;
  std::string obj;
  for (int i = 0; i < kStations; ++i) {
    const double t = 2.0 * M_PI * i / kStations;
    const double along_x = 2.7 * std::cos(t), along_y = 2.7 * std::cos(2.0 * t);
    const double half = 0.5 / std::hypot(along_x, along_y);
    const double x = 2.7 * std::sin(t), y = 1.35 * std::sin(2.0 * t);
    obj += fmt::format("v {} {} 0\nv {} {} 0\n", x + half * along_y, y - half * along_x,
                       x - half * along_y, y + half * along_x);
  }
  for (int i = 0; i < kStations; ++i) {
    const int a = 2 * i + 1, b = 2 * ((i + 1) % kStations) + 1;
    obj += fmt::format("f {} {} {} {}\n", a, b, b + 1, a + 1);
  }
  const Folder folder;
  write(folder / "s.obj", obj);
  const Ran asked = build(folder, folder / "s.obj");
  EXPECT_EQ(asked.code, 3) << asked.err;
  EXPECT_THAT(asked.out + asked.err, HasSubstr("--scale 10 "));
  const Ran ran = crgbuild({"build", folder / "s.obj", "--scale", "10", "-o", folder / "out"});
  EXPECT_EQ(ran.code, 0) << ran.err;
}

TEST(BadInput, WrongUpAxisSaysWhichFlagToGive) {
  Stadium stadium;
  stadium.y_up = true;
  expect_mesh_refused("s.obj", stadium.obj(), {"--up"}, {"--up", "z"});
  const Folder folder;
  write(folder / "s.obj", stadium.obj());
  EXPECT_EQ(build(folder, folder / "s.obj", {"--up", "y"}).code, 0);
  EXPECT_EQ(build(folder, folder / "s.obj").code, 0);  // found by itself
}

TEST(BadInput, VerticesThatAreNoPlace) {
  for (const char* vertex : {"nan 0 0", "0 1e30 0", "0 0 -inf", "0 2e7 0"}) {
    Stadium stadium;
    stadium.first_vertex = vertex;
    expect_mesh_refused("s.obj", stadium.obj(), {"s.obj"});
  }
}

TEST(BadInput, UtmCoordinatesAreKept) {
  Stadium stadium;
  stadium.x_m = 500000.25;
  stadium.y_m = 5400000.5;
  const Folder folder;
  write(folder / "s.obj", stadium.obj());
  const Ran ran = build(folder, folder / "s.obj", {"--start-at", "500000.25,5400000.5"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto s = base::parse_json<nlohmann::json>(read(folder / "out/summary.json"));
  EXPECT_LT(s["validation"]["z_error_m"]["max"].get<double>(), 0.005);
  const auto info =
      base::parse_json<nlohmann::json>(crgbuild({"info", folder / "out/s.crg", "--json"}).out);
  EXPECT_NEAR(info["reference_line"]["x_max_m"].get<double>(), 500160.25, 0.1);
  EXPECT_NEAR(info["reference_line"]["y_min_m"].get<double>(), 5400000.5, 0.1);
}

TEST(BadInput, OnlyTrees) {
  Stadium stadium;
  stadium.road = false;
  expect_mesh_refused("s.obj", stadium.obj(), {"s.obj"});
  stadium.names = false;
  expect_mesh_refused("s.obj", stadium.obj(), {"s.obj"});
}

TEST(BadInput, TwoCircuits) {
  Stadium stadium;
  stadium.x2_m = 400;
  const Folder folder;
  write(folder / "s.obj", stadium.obj());
  const Ran asked = build(folder, folder / "s.obj");
  EXPECT_EQ(asked.code, 3);
  EXPECT_THAT(asked.err, HasSubstr("2 separate roads"));
  EXPECT_THAT(asked.err, HasSubstr("which road is meant?"));
  EXPECT_THAT(asked.out, HasSubstr("2  closed road"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/s.question.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out/s.crg"));
  const Ran ran = build(folder, folder / "s.obj", {"--near-m", "460,0"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const auto info =
      base::parse_json<nlohmann::json>(crgbuild({"info", folder / "out/s.crg", "--json"}).out);
  EXPECT_GT(info["reference_line"]["x_min_m"].get<double>(), 300);
}

TEST(BadInput, RecipesSayFileAndLine) {
  const Folder folder;
  write(folder / "s.obj", Stadium{}.obj());
  const std::vector<std::pair<std::string, std::string>> bad = {
      {"mesh: s.obj\nu_stp_m: 1\n",
       "track.yaml:2: unknown key 'u_stp_m'; the nearest known one is 'u_step_m'"},
      {"mesh: s.obj\n\nu_step_m: 100\n",
       "track.yaml:3: u_step_m: '100' seen, automatic or a number from 0.001 to 10 wanted"},
      {"mesh: s.obj\nup: w\n", "track.yaml:2: up: 'w' seen"},
      {"mesh: missing.obj\n", "missing.obj"},
      {"mesh: s.obj\ncontrol_points: missing.csv\n", "missing.csv"},
      {"mesh: [\n", "track.yaml:"},
      {"", "track.yaml: empty"}};
  for (const auto& [text, wanted] : bad) {
    write(folder / "track.yaml", text);
    expect_refused(build(folder, folder / "track.yaml"), folder / "out", {wanted});
  }
}

TEST(BadInput, FilesThatAreNoRoad) {
  const Folder folder;
  write(folder / "s.obj", Stadium{}.obj());
  write(folder / "x.crg", "no road\n");
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"info", folder / "x.crg"},
           {"info", folder / "missing.crg"},
           {"info", folder.path()},
           {"validate", folder / "x.crg", folder / "s.obj"},
           {"query", folder / "x.crg", "--points", folder / "x.crg", "-o", folder / "o.csv"},
           {"sample", folder / "s.obj", "--centreline", folder / "x.crg", "-o", folder / "o.crg"},
           {"smooth", folder / "x.crg", "--ignore-kerbs", "--smooth-window-m", "1", "-o",
            folder / "o.crg"},
           {"synth", folder / "x.crg", "-o", folder / "synth"},
           {"clean", folder / "s.obj", "-o", folder / "o.txt"}}) {
    const Ran ran = crgbuild(arguments);
    EXPECT_EQ(ran.code, 1) << arguments[0] << ran.err;
    EXPECT_THAT(ran.err, StartsWith("crgbuild: ")) << arguments[0];
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
    EXPECT_FALSE(exists(folder / "o.crg"));
  }
}

TEST(BadInput, OutputFolderThatCannotBeWritten) {
  const Folder folder;
  write(folder / "s.obj", Stadium{}.obj());
  write(folder / "out", "a file is in the way");
  const Ran file = build(folder, folder / "s.obj");
  EXPECT_EQ(file.code, 1);
  EXPECT_THAT(file.err, HasSubstr(folder / "out"));
  EXPECT_EQ(crgbuild({"build", folder / "s.obj", "-o", "/proc/nowhere"}).code, 1);
  // Root may write anywhere but not here: a folder that takes no files.
  const Ran proc = crgbuild({"build", folder / "s.obj", "-o", "/proc/self"});
  EXPECT_EQ(proc.code, 1);
  EXPECT_EQ(std::count(proc.err.begin(), proc.err.end(), '\n'), 1) << proc.err;
  const Ran stage = crgbuild({"clean", folder / "s.obj", "-o", folder / "no/such/folder/s.stl"});
  EXPECT_EQ(stage.code, 1);
  EXPECT_THAT(stage.err, HasSubstr("no/such/folder/s.stl"));
}

}  // namespace bad_input_test
}  // namespace cli
