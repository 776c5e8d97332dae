// The subcommands on .crg files, as a user meets them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "base/csv.h"
#include "base/sha256.h"
#include "crg/file.h"
#include "crg/surface.h"
#include "support/run_crgbuild.h"

namespace cli {
namespace file_commands_test {

using ::testing::HasSubstr;

/// A straight road of 20 m with a rise of 1 %, written as `path`.
void write_road(const std::string& path) {
  crg::ReferenceLine line;
  for (int i = 0; i <= 40; ++i) {
    line.x_m.push_back(100.0 + 0.5 * i);
    line.y_m.push_back(50.0);
    line.heading_rad.push_back(0.0);
  }
  line.u_step_m = 0.5;
  crg::Grid grid;
  grid.u_step_m = 0.5;
  grid.v_m = {-2.0, -1.0, 0.0, 1.0, 2.0};
  for (int i = 0; i <= 40; ++i) {
    for (int j = 0; j < 5; ++j) grid.z_m.push_back(static_cast<float>(0.005 * i));
  }
  crg::write(crg::make_crg(line, grid), path, crg::Format::KRBI);
}

TEST(FileCommands, CheckSaysWhatIsWrongAndSetsTheExitCode) {
  const Folder folder;
  write_road(folder / "road.crg");
  const Ran good = crgbuild({"check", folder / "road.crg"});
  EXPECT_EQ(good.code, 0) << good.err;
  EXPECT_THAT(good.out, HasSubstr("0 errors, 0 warnings"));
  EXPECT_THAT(good.out, HasSubstr("crgbuild report " + (folder / "road.crg") + " -o report\n"));
  crg::Crg bad = crg::read(folder / "road.crg");
  set_value(bad.options, "REFLINE_CONTINUATION", 1.0);
  crg::write(bad, folder / "bad.crg", crg::Format::KRBI);
  const Ran refused = crgbuild({"check", folder / "bad.crg", "--json"});
  EXPECT_EQ(refused.code, 3);
  EXPECT_THAT(refused.out, HasSubstr("\"rule\": \"closure\""));
}

TEST(FileCommands, ExportWritesLineAndWidthsAndSaysWhatIsLost) {
  const Folder folder;
  write_road(folder / "road.crg");
  const Ran ran = crgbuild({"export", folder / "road.crg", "-o", folder / "line.csv"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("41 points"));
  EXPECT_THAT(ran.out, HasSubstr("lost     heights"));
  EXPECT_THAT(read(folder / "line.csv"), HasSubstr("\n100.5000,50.0000,2.0000,2.0000\n"));
  const Ran none = crgbuild({"export", folder / "road.crg", "-o", folder / "none"});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, HasSubstr("says no format; give --format"));
  // The flags that formats had before.
  const Ran old = crgbuild({"export", folder / "road.crg", "--tum", "-o", folder / "old.txt"});
  EXPECT_EQ(old.code, 0);
  EXPECT_EQ(old.err, "crgbuild: --tum is written -o NAME.csv now\n");
  EXPECT_EQ(read(folder / "old.txt"), read(folder / "line.csv"));
  const Ran piped = crgbuild({"export", folder / "road.crg", "--format", "tum", "-o", "-"});
  EXPECT_EQ(piped.out, read(folder / "line.csv"));
}

// A road of 4 m, whose build found the edges 0.9 m to the right and 1.2 m to the left of the line.
TEST(FileCommands, LanesAreAsWideAsTheSummaryBesideTheRoadSays) {
  const Folder folder;
  write_road(folder / "road.crg");
  const std::string of_this =
      fmt::format(R"("outputs": [{{"sha256": "{}"}}])", base::sha256_of_file(folder / "road.crg"));
  const std::string edges =
      R"("grid": {"rows": 41}, "road_edges": {"every_rows": 2, "right_m": [-0.9], "left_m": [1.2]})";
  const auto lane_begins = [&](const std::string& summary) {
    std::ofstream(folder / "summary.json") << summary;
    const Ran ran = crgbuild({"export", folder / "road.crg", "-o", folder / "road.xodr"});
    EXPECT_EQ(ran.code, 0) << summary << ran.err;
    const std::string text = read(folder / "road.xodr"), mark = "<width sOffset=\"0\" a=\"";
    return std::stod(text.substr(text.find(mark) + mark.size()));
  };
  EXPECT_NEAR(lane_begins("{" + of_this + "," + edges + "}"), 1.2, 0.02) << "between columns";
  for (const std::string& other :
       {std::string("["), std::string("3"), "{" + edges + "}", "{" + of_this + "}",
        R"({"outputs": 3, )" + edges + "}", R"({"outputs": [4, {"sha256": 5}], )" + edges + "}",
        "{" + of_this + R"(, "road_edges": {"every_rows": 0, "right_m": [-1], "left_m": [1]}})",
        "{" + of_this + R"(, "road_edges": {"every_rows": 2, "right_m": [], "left_m": [1]}})",
        "{" + of_this + R"(, "road_edges": {"every_rows": -2, "right_m": {}, "left_m": "1"}})"})
    EXPECT_NEAR(lane_begins(other), 2.0, 0.02) << other;
  // The last row, of a circuit the first again, lies between two records.
  const std::vector<double> right(14, -0.9), left(14, 1.2);
  std::ofstream(folder / "summary.json") << fmt::format(
      R"({{{}, "grid": {{"rows": 41}}, "road_edges": {{"every_rows": 3, "right_m": [{}],
          "left_m": [{}], "changes": {{"row": [0, 40], "right_m": [-0.9, -0.9],
          "left_m": [1.2, 1.5]}}}}}})",
      of_this, fmt::join(right, ","), fmt::join(left, ","));
  const Ran ran = crgbuild({"export", folder / "road.crg", "-o", folder / "line.csv"});
  EXPECT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(read(folder / "line.csv"), ::testing::EndsWith(",0.9000,1.5000\n"));
}

// A hole beyond the road's edge, which the build that made the road knows.
TEST(FileCommands, AReportKnowsWhatTheBuildOfTheRoadSays) {
  const Folder folder;
  write_road(folder / "road.crg");
  crg::Crg road = crg::read(folder / "road.crg");
  for (std::size_t row = 18; row < 23; ++row) road.grid.z_m[row * 5 + 3] = NAN;
  crg::write(road, folder / "road.crg", crg::Format::KRBI);
  const auto verdict = [&] {
    const Ran ran = crgbuild({"report", folder / "road.crg", "-o", folder / "out"});
    EXPECT_EQ(ran.code, ran.out.find("not usable") == std::string::npos ? 0 : 3);
    return ran.out.substr(0, ran.out.find('\n')) + ran.err;
  };
  EXPECT_THAT(verdict(), HasSubstr("not usable: 1 error"));
  const auto say = [&](const std::string& failures) {
    std::ofstream(folder / "summary.json") << fmt::format(
        R"({{"outputs": [{{"sha256": "{}"}}], "grid": {{"rows": 41}},
            "validation": {{"failures": [{}]}}, "recipe": {{"reference_length_m": 900}},
            "road_edges": {{"every_rows": 40, "right_m": [-2, -2], "left_m": [2, 2],
                "changes": {{"row": [0, 10], "right_m": [-2, -2], "left_m": [2, 0.5]}}}}}})",
        base::sha256_of_file(folder / "road.crg"), failures);
  };
  say("");
  EXPECT_THAT(verdict(), HasSubstr("usable with 3 remarks")) << "its length is one";
  say(R"("the line may be another road")");
  EXPECT_THAT(verdict(), HasSubstr("not usable, 1 error: the line may be another road"));
  const Ran checked = crgbuild({"check", folder / "road.crg"});
  EXPECT_EQ(checked.code, 3);
  EXPECT_THAT(checked.out, HasSubstr("must not be used: the line may be another road"));
}

TEST(FileCommands, ALineWithWidthsBecomesTheRoadAgain) {
  const Folder folder;
  std::string ring = "# x_m,y_m,w_tr_right_m,w_tr_left_m\n";
  for (int k = 0; k < 400; ++k) {
    const double a = k * 2.0 * std::numbers::pi / 400;
    ring +=
        fmt::format("{},{},{},{}\n", 80 * std::cos(a), 80 * std::sin(a), 5.0, 4.0 + std::sin(a));
  }
  std::ofstream(folder / "ring.csv") << ring;
  const Ran ran = crgbuild({"from-edges", folder / "ring.csv", "-o", folder / "out", "-q"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const Ran back = crgbuild({"export", folder / "out/ring.crg", "-o", folder / "back.csv"});
  ASSERT_EQ(back.code, 0) << back.err;
  const base::CsvTable line =
      base::read_csv(folder / "back.csv", {"x_m", "y_m", "w_tr_right_m", "w_tr_left_m"});
  ASSERT_GT(line.rows(), 4000u);
  for (std::size_t i = 0; i < line.rows(); i += 50) {
    const double a = std::atan2(line.value(i, 1), line.value(i, 0));
    const double middle_m = 80.0 + 0.5 * (5.0 - 4.0 - std::sin(a));
    EXPECT_NEAR(std::hypot(line.value(i, 0), line.value(i, 1)), middle_m, 0.02)
        << "left is inwards";
    EXPECT_NEAR(line.value(i, 2) + line.value(i, 3), 9.0 + std::sin(a), 0.08)
        << "a column at either side";
  }
}

TEST(FileCommands, ExportWritesOneFormatAtATimeBesideTheCrg) {
  const Folder folder;
  write_road(folder / "road.crg");
  const Ran ran = crgbuild({"export", folder / "road.crg", "-o", folder / "road.xodr"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("stand in the CRG alone"));
  EXPECT_THAT(read(folder / "road.xodr"), HasSubstr("<CRG file=\"road.crg\""));
  const Ran mesh = crgbuild({"export", folder / "road.crg", "-o", folder / "road.ply"});
  EXPECT_EQ(mesh.code, 0) << mesh.err;
  EXPECT_THAT(mesh.out, HasSubstr("triangles, z up"));
  const Ran map = crgbuild({"export", folder / "road.crg", "-o", folder / "road.png"});
  EXPECT_EQ(map.code, 0) << map.err;
  EXPECT_THAT(map.out, HasSubstr("mm at most between them"));
  EXPECT_THAT(read(folder / "road.png.json"), HasSubstr("\"file\": \"road.png\""));
  const Ran tiff =
      crgbuild({"export", folder / "road.crg", "--format", "heightmap", "-o", folder / "road.tif"});
  EXPECT_EQ(tiff.code, 1);
  EXPECT_THAT(tiff.err, HasSubstr("wanted .png or .raw"));
  const Ran two = crgbuild({"export", folder / "road.crg", "--xodr", "--svg", "-o", folder / "x"});
  EXPECT_EQ(two.code, 2);
  EXPECT_THAT(two.err, HasSubstr("one format is wanted"));
  const Ran ending =
      crgbuild({"export", folder / "road.crg", "--format", "mesh", "-o", folder / "road.xyz"});
  EXPECT_EQ(ending.code, 1);
  EXPECT_THAT(ending.err, HasSubstr("wanted .glb, .obj, .ply or .stl"));
  const Ran place = crgbuild({"export", folder / "road.crg", "-o", folder / "road.kml"});
  EXPECT_EQ(place.code, 1);
  EXPECT_THAT(place.err, HasSubstr("where on the Earth"));
  EXPECT_EQ(crgbuild({"export", folder / "road.crg", "--grip", folder / "road.crg", "-o",
                      folder / "x.svg"})
                .code,
            2);
}

TEST(FileCommands, ConvertThereAndBackKeepsTheHeights) {
  const Folder folder;
  write_road(folder / "road.crg");
  ASSERT_EQ(
      crgbuild({"convert", folder / "road.crg", "-o", folder / "text.crg", "--format", "ldfi"})
          .code,
      0);
  ASSERT_EQ(
      crgbuild({"convert", folder / "text.crg", "-o", folder / "back.crg", "--format", "krbi"})
          .code,
      0);
  EXPECT_EQ(crg::read(folder / "text.crg").format, crg::Format::LDFI);
  EXPECT_EQ(crg::read(folder / "back.crg").grid.z_m, crg::read(folder / "road.crg").grid.z_m);
}

TEST(FileCommands, EditsWriteTheEditedRoad) {
  const Folder folder;
  const std::string road = folder / "road.crg";
  write_road(road);
  ASSERT_EQ(crgbuild({"crop", road, "-o", folder / "a.crg", "--u-end-m", "10"}).code, 0);
  ASSERT_EQ(crgbuild({"crop", road, "-o", folder / "b.crg", "--u-begin-m", "10"}).code, 0);
  ASSERT_EQ(crgbuild({"append", folder / "a.crg", folder / "b.crg", "-o", folder / "ab.crg"}).code,
            0);
  EXPECT_EQ(crg::read(folder / "ab.crg").grid.z_m, crg::read(road).grid.z_m);
  ASSERT_EQ(crgbuild({"reverse", road, "-o", folder / "back.crg"}).code, 0);
  EXPECT_NEAR(crg::Surface(crg::read(folder / "back.crg")).z_at_uv(0.0, 0.0), 0.2, 1e-6);
  ASSERT_EQ(crgbuild({"resample", road, "-o", folder / "fine.crg", "--u-step-m", "0.1",
                      "--v-step-m", "0.5"})
                .code,
            0);
  EXPECT_EQ(crg::read(folder / "fine.crg").grid.columns(), 9U);
  ASSERT_EQ(crgbuild({"transform", road, "-o", folder / "moved.crg", "--set",
                      "REFLINE_OFFSET_X=-100", "--set", "scale_z_grid=3"})
                .code,
            0);
  const crg::Surface moved(crg::read(folder / "moved.crg"));
  EXPECT_NEAR(moved.xy_of_uv(0.0, 0.0).x_m, 0.0, 1e-9);
  EXPECT_NEAR(moved.z_at_uv(20.0, 0.0), 0.6, 1e-6);
  EXPECT_EQ(crgbuild({"crop", road, "-o", folder / "none.crg", "--u-begin-m", "90"}).code, 1);
  EXPECT_EQ(crgbuild({"resample", road, "-o", folder / "none.crg"}).code, 2);
  EXPECT_EQ(
      crgbuild({"transform", road, "-o", folder / "none.crg", "--set", "BORDER_MODE_U=0"}).code, 2);
  EXPECT_FALSE(exists(folder / "none.crg"));
}

TEST(FileCommands, QueryAppliesWhatItIsTold) {
  const Folder folder;
  write_road(folder / "road.crg");
  crg::Crg road = crg::read(folder / "road.crg");
  set_value(road.modifiers, "SCALE_Z_GRID", 10.0);
  crg::write(road, folder / "scaled.crg", crg::Format::KRBI);
  road.modifiers.clear();
  road.has_modifier_section = false;
  crg::write(road, folder / "plain.crg", crg::Format::KRBI);
  write(folder / "points.csv", "u_m,v_m\n10,0\n30,0\n");
  const auto z = [&](const std::string& file, std::vector<std::string> flags) {
    std::vector<std::string> arguments = {
        "query", folder / file, "--points", folder / "points.csv", "-o", folder / "z.csv"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const Ran ran = crgbuild(arguments);
    EXPECT_EQ(ran.code, 0) << ran.err;
    return read(folder / "z.csv");
  };
  EXPECT_THAT(z("scaled.crg", {}), HasSubstr("110,50,10,0,1,"));
  EXPECT_THAT(z("scaled.crg", {"--modifiers", "none"}), HasSubstr("110,50,10,0,0.10"));
  EXPECT_THAT(z("scaled.crg", {"--modifiers", "none", "--set", "SCALE_Z_GRID=5"}),
              HasSubstr("110,50,10,0,0.5"));
  EXPECT_THAT(z("plain.crg", {"--modifiers", "reference"}), HasSubstr("10,2,10,0,0.10"));
  EXPECT_THAT(z("plain.crg", {"--modifiers", "reference", "--set", "REFLINE_OFFSET_X=7"}),
              HasSubstr("10,2,10,0,0.10"));
  EXPECT_THAT(z("plain.crg", {"--set", "BORDER_MODE_U=0"}), HasSubstr("\n130,50,30,0,,0,0,,\n"));
  const Ran both = crgbuild({"query", folder / "plain.crg", "--points", folder / "points.csv", "-o",
                             folder / "z.csv", "--no-modifiers", "--reference-defaults"});
  EXPECT_EQ(both.code, 2);
}

}  // namespace file_commands_test
}  // namespace cli
