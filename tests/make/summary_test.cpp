#include "make/summary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/json_text.h"

namespace road {
namespace summary_test {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TEST(Summary, HasTheFixedKeys) {
  BuildSummary summary;
  summary.recipe = recipe_for_mesh("a/b.obj");
  summary.inputs = {{"mesh", "a/b.obj", std::string(64, 'a')}};
  summary.reference_line.length_m = 2057.6;
  summary.reference_line.closed = true;
  summary.validate.points = summary.validate.road_points = 10;
  summary.validate.z_error_m = {0.1, 0.2, 0.3, 0.4};
  const auto json = base::parse_json<nlohmann::json>(summary_json(summary));
  EXPECT_DOUBLE_EQ(json["reference_line"]["length_m"], 2057.6);
  EXPECT_EQ(json["reference_line"]["closed"], true);
  EXPECT_TRUE(json["grid"].contains("nodes"));
  EXPECT_TRUE(json["grid"].contains("holes"));
  EXPECT_TRUE(json["grid"].contains("u_step_m"));
  EXPECT_DOUBLE_EQ(json["validation"]["z_error_m"]["p50"], 0.1);
  EXPECT_DOUBLE_EQ(json["validation"]["z_error_m"]["max"], 0.4);
  const auto timing =
      base::parse_json<nlohmann::json>(timing_json({{"read", 0.25}, {"clean", 0.5}}, 0.75));
  EXPECT_DOUBLE_EQ(timing["seconds"]["total"], 0.75);
  EXPECT_DOUBLE_EQ(timing["seconds"]["clean"], 0.5);
  EXPECT_GT(timing["peak_memory_mb"].get<double>(), 1.0);
  EXPECT_FALSE(json.contains("seconds")) << "differs from run to run";
  EXPECT_EQ(json["inputs"][0]["sha256"], std::string(64, 'a'));
  EXPECT_EQ(json["recipe"]["u_step_m"], "automatic");
  EXPECT_EQ(json["recipe"]["name"], "b");
  EXPECT_TRUE(json["recipe"]["start_object"].is_null());
}

TEST(Summary, NaNAndWildNamesAreStillJson) {
  BuildSummary summary;
  summary.recipe = recipe_for_mesh("\xff\xfe.obj");
  summary.clean.remarks = {"object \xc3\x28\" </script>"};
  summary.placement = Placement{};
  const auto json = base::parse_json<nlohmann::json>(summary_json(summary));
  EXPECT_FALSE(json["validation"]["passed"]);
  EXPECT_TRUE(json["align"].is_object());
}

TEST(Summary, GridIsDescribed) {
  crg::Grid grid;
  grid.u_step_m = 0.5;
  grid.v_m = {-1.0, 0.0, 0.5, 1.0};
  grid.z_m = {kNaN, 1.0f, kNaN, 2.0f,   // one hole
              kNaN, kNaN, kNaN, kNaN,   // none
              3.0f, 1.0f, 0.5f, kNaN};  // none
  crg::ReferenceLine line;
  line.x_m = line.y_m = line.heading_rad = std::vector<double>(3, 0.0);
  const GridReport report = describe(grid, line);
  EXPECT_EQ(report.rows, 3u);
  EXPECT_EQ(report.columns, 4u);
  EXPECT_EQ(report.nodes, 12u);
  EXPECT_EQ(report.nodes_with_z, 5u);
  EXPECT_EQ(report.holes, 1u);
  EXPECT_DOUBLE_EQ(report.u_end_m, 1.0);
  EXPECT_DOUBLE_EQ(report.v_step_min_m, 0.5);
  EXPECT_DOUBLE_EQ(report.v_step_max_m, 1.0);
  EXPECT_DOUBLE_EQ(report.z_min_m, 0.5);
  EXPECT_DOUBLE_EQ(report.z_max_m, 3.0);
  EXPECT_DOUBLE_EQ(report.width_min_m, 1.0);
  EXPECT_DOUBLE_EQ(report.width_median_m, 1.5);
  EXPECT_DOUBLE_EQ(report.width_max_m, 1.5);
  EXPECT_TRUE(std::isnan(describe(crg::Grid{}, line).z_min_m));
  // Heights of the surface: line and banking count.
  line.z_m = {300.0, 310.0, 320.0};
  line.banking = {0.0, 0.0, 0.1};
  EXPECT_DOUBLE_EQ(describe(grid, line).z_min_m, 301.0);
  EXPECT_DOUBLE_EQ(describe(grid, line).z_max_m, 322.9);
}

TEST(Summary, ValidationFailsForAReason) {
  ValidateReport good;
  good.points = good.road_points = 1000;
  good.z_error_m = {0.0, 0.001, 0.002, 0.2};
  EXPECT_TRUE(validation_failures(good).empty());

  ValidateReport none;
  EXPECT_EQ(validation_failures(none).size(), 1u);
  ValidateReport high = good;
  high.road_error_p99_m = 0.06;
  EXPECT_EQ(validation_failures(high).size(), 1u);
  ValidateReport nan = good;
  nan.road_error_p99_m = std::nan("");
  EXPECT_EQ(validation_failures(nan).size(), 1u);
  ValidateReport off = good;
  off.road_points_without_mesh = 2;
  EXPECT_EQ(validation_failures(off).size(), 1u);
  ValidateReport seam = good;
  seam.seam_z_step_m = 0.011;
  EXPECT_EQ(validation_failures(seam).size(), 1u);
}

TEST(Summary, CentrelineWidthIsTheFullWidth) {
  Centreline centreline;
  centreline.points_m.resize(3);
  centreline.half_width_m = {5.0, 4.0, 7.0};
  const CentrelineReport report = describe(centreline);
  EXPECT_EQ(report.stations, 3u);
  EXPECT_DOUBLE_EQ(report.width_min_m, 8.0);
  EXPECT_DOUBLE_EQ(report.width_median_m, 10.0);
  EXPECT_DOUBLE_EQ(report.width_max_m, 14.0);
}

}  // namespace summary_test
}  // namespace road
