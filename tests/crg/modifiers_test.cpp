#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "crg/error.h"
#include "crg/surface.h"
#include "roads.h"

namespace crg {
namespace modifiers_test {

Crg road(std::initializer_list<std::pair<const char*, double>> modifiers) {
  ReferenceLine line = test::line_along(
      41, 0.5, [](double) { return 0.02; }, 100.0, 50.0, 0.7);
  for (std::size_t i = 0; i < line.size(); ++i) {
    line.z_m.push_back(5.0 + 0.05 * static_cast<double>(i));
    line.banking.push_back(0.001 * static_cast<double>(i));
  }
  Crg crg = make_crg(line, test::grid_of(line, -2.0, 2.0, 5,
                                         [](double u, double v) { return 0.1 * u + 0.2 * v; }));
  for (const auto& [key, value] : modifiers) set_value(crg.modifiers, key, value);
  return crg;
}

TEST(Modifiers, ScaleHeightsSlopeAndBankingEachOnItsOwn) {
  const double u = 10.0, v = 1.0, grid = 0.1 * u + 0.2 * v, line = 5.0 + 0.1 * u,
               banking = 0.002 * u;
  EXPECT_NEAR(Surface(road({})).z_at_uv(u, v), line + banking * v + grid, 1e-6);
  EXPECT_NEAR(Surface(road({{"SCALE_Z_GRID", 3.0}})).z_at_uv(u, v), line + banking * v + 3.0 * grid,
              1e-6);
  EXPECT_NEAR(Surface(road({{"SCALE_SLOPE", 3.0}})).z_at_uv(u, v),
              5.0 + 0.3 * u + banking * v + grid, 1e-6);
  EXPECT_NEAR(Surface(road({{"SCALE_BANKING", 3.0}})).z_at_uv(u, v),
              line + 3.0 * banking * v + grid, 1e-6);
}

TEST(Modifiers, ScaleLengthAndWidthStretchTheGrid) {
  const Surface surface(road({{"SCALE_LENGTH", 2.0}, {"SCALE_WIDTH", 0.5}}));
  EXPECT_EQ(surface.grid().u_step_m, 1.0);
  EXPECT_EQ(surface.grid().v_m.front(), -1.0);
  // Same node, now twice as far along and half as far aside; the slope is kept, so the line climbs
  // twice as far; banking works on the new v.
  EXPECT_NEAR(surface.z_at_uv(20.0, 0.5), 5.0 + 0.1 * 20.0 + 0.02 * 0.5 + 0.1 * 10.0 + 0.2, 1e-6);
}

TEST(Modifiers, ScaleLengthStretchesFromUOfZero) {
  Crg late = road({{"SCALE_LENGTH", 2.0}});
  late.grid.u_begin_m = 30.0;
  const Grid grid = apply_modifiers(late).grid;
  EXPECT_EQ(grid.u_begin_m, 60.0);
  EXPECT_EQ(grid.u_step_m, 1.0);
}

TEST(Modifiers, ScaleCurvatureTurnsAnArcIntoALineAndCountsTurnsBeyondHalfACircle) {
  const Surface straight(road({{"SCALE_CURVATURE", 0.0}}));
  const ReferenceLine& line = straight.reference_line();
  EXPECT_NEAR(line.x_m.back(), 100.0 + 20.0 * std::cos(0.7), 1e-6);
  EXPECT_NEAR(line.y_m.back(), 50.0 + 20.0 * std::sin(0.7), 1e-6);
  // Headings stored within (-pi, pi]: the jump at pi is no curvature.
  ReferenceLine turning = test::line_along(200, 0.5, [](double) { return 0.1; });
  Crg crg =
      make_crg(turning, test::grid_of(turning, -1.0, 1.0, 2, [](double, double) { return 0.0; }));
  for (double& heading : crg.heading_rad) heading = std::remainder(heading, 2.0 * std::numbers::pi);
  set_value(crg.modifiers, "SCALE_CURVATURE", 0.5);
  const Surface half(crg);
  EXPECT_NEAR(half.reference_line().heading_rad.back() - half.reference_line().heading_rad.front(),
              0.5 * 0.1 * 0.5 * 198.0, 1e-5);
}

TEST(Modifiers, NanModesFillBothEdgesOfEveryRow) {
  const auto filled = [](std::initializer_list<std::pair<const char*, double>> modifiers) {
    Crg crg = road(modifiers);
    for (std::size_t i = 0; i < crg.grid.rows(); ++i) crg.grid.at(i, 0) = crg.grid.at(i, 4) = NAN;
    crg.grid.at(7, 2) = NAN;
    return apply_modifiers(crg).grid;
  };
  EXPECT_TRUE(std::isnan(filled({{"SCALE_Z_GRID", 1.0}}).at(3, 0)));
  const Grid zero = filled({{"GRID_NAN_MODE", 1.0}, {"GRID_NAN_OFFSET", 0.5}});
  const Grid kept = filled({{"GRID_NAN_MODE", 2.0}, {"GRID_NAN_OFFSET", 0.5}});
  for (const std::size_t row : {std::size_t{0}, std::size_t{20}, std::size_t{40}}) {
    EXPECT_EQ(zero.at(row, 0), 0.5F);
    EXPECT_EQ(zero.at(row, 4), 0.5F);
    EXPECT_EQ(kept.at(row, 0), kept.at(row, 1) + 0.5F);
    EXPECT_EQ(kept.at(row, 4), kept.at(row, 3) + 0.5F);
  }
  EXPECT_TRUE(std::isnan(kept.at(7, 2))) << "holes inside the road stay";
}

TEST(Modifiers, ReferencePointMovesThatPointThere) {
  const Surface surface(road({{"REFPOINT_U_FRACTION", 0.5},
                              {"REFPOINT_U_OFFSET", 1.0},
                              {"REFPOINT_V", 0.5},
                              {"REFPOINT_V_OFFSET", 0.25},
                              {"REFPOINT_X", -7.0},
                              {"REFPOINT_Y", 3.0},
                              {"REFPOINT_Z", 2.0},
                              {"REFPOINT_PHI", 1.5},
                              {"REFLINE_OFFSET_X", 99.0}}));
  const Sample sample = surface.at_uv(11.0, 0.75);
  EXPECT_NEAR(sample.x_m, -7.0, 1e-9);
  EXPECT_NEAR(sample.y_m, 3.0, 1e-9);
  EXPECT_NEAR(sample.z_m, 2.0, 1e-6);
  EXPECT_NEAR(sample.heading_rad, 1.5, 1e-9);
}

TEST(Modifiers, OffsetsRotateAboutTheirCentreThenTranslate) {
  const Surface before(road({}));
  const Surface after(road({{"REFLINE_ROTCENTER_X", 90.0},
                            {"REFLINE_ROTCENTER_Y", 40.0},
                            {"REFLINE_OFFSET_PHI", std::numbers::pi / 2.0},
                            {"REFLINE_OFFSET_X", 1.0},
                            {"REFLINE_OFFSET_Z", 4.0}}));
  const Point2 p = before.xy_of_uv(8.0, 1.0), q = after.xy_of_uv(8.0, 1.0);
  EXPECT_NEAR(q.x_m, 90.0 - (p.y_m - 40.0) + 1.0, 1e-9);
  EXPECT_NEAR(q.y_m, 40.0 + (p.x_m - 90.0), 1e-9);
  EXPECT_NEAR(after.z_at_uv(8.0, 1.0), before.z_at_uv(8.0, 1.0) + 4.0, 1e-6);
}

TEST(Modifiers, RefusesValuesThatMeanNothing) {
  EXPECT_THROW(Surface(road({{"SCALE_LENGTH", 0.0}})), Error);
  EXPECT_THROW(Surface(road({{"SCALE_WIDTH", -1.0}})), Error);
  EXPECT_THROW(Surface(road({{"GRID_NAN_MODE", 3.0}})), Error);
}

}  // namespace modifiers_test
}  // namespace crg
