#include "vehicle/road.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "test_roads.h"

namespace {

using vehicle::Road;
using vehicle::RoadCursors;
using vehicle::RoadPoint;

TEST(Road, IsThePlaneItWasTold) {
  RoadCursors cursors;
  const RoadPoint p = Road(0.1, -0.2).at(3.0, 4.0, 0.0, 0, cursors);
  EXPECT_DOUBLE_EQ(p.z_m, 0.1 * 3 - 0.2 * 4);
  EXPECT_EQ(p.dzdx, 0.1);
  EXPECT_EQ(p.dzdy, -0.2);
  EXPECT_TRUE(p.on_road);
}

TEST(Road, AnswersWithTheLevelThatIsNear) {
  const crg::Surface surface(spiral(8.0));
  const Road road(surface);
  RoadCursors cursors;
  // A quarter turn in, 2 m inwards of the line: 2 m up on the first turn, 10 m up on the second.
  const double x = 28.0 * std::sin(1.57), y = 30.0 - 28.0 * std::cos(1.57);
  const double low = 8.0 * 1.57 / (2 * std::numbers::pi);
  const RoadPoint below = road.at(x, y, low + 0.3, 0, cursors);
  const RoadPoint above = road.at(x, y, low + 8.2, 1, cursors);
  EXPECT_NEAR(below.z_m, low, 1e-3);
  EXPECT_NEAR(above.z_m, low + 8.0, 1e-3);
  EXPECT_NEAR(above.u_m - below.u_m, 2 * std::numbers::pi * 30.0, 0.05);
  EXPECT_NEAR(below.v_m, 2.0, 0.01);
  EXPECT_NEAR(above.v_m, 2.0, 0.01);
  // The same from fresh cursors: they never change an answer.
  RoadCursors fresh;
  EXPECT_EQ(road.at(x, y, low + 8.2, 1, fresh).z_m, above.z_m);
}

TEST(Road, GoesOnOverHolesAtTheNearestHeightAndSaysSo) {
  const crg::Surface surface(straight(50.0, 0.5, [](double u, double v) {
    if (std::abs(u - 20.0) < 2.0 && v > 1.0) return std::numeric_limits<double>::quiet_NaN();
    return 0.1 * v;
  }));
  const Road road(surface);
  RoadCursors cursors;
  const RoadPoint hole = road.at(20.0, 3.0, 0.3, 0, cursors);
  EXPECT_FALSE(hole.on_road);
  EXPECT_NEAR(hole.z_m, 0.1, 0.06);
  EXPECT_NEAR(hole.u_m, 20.0, 1e-6);
  EXPECT_NEAR(hole.v_m, 3.0, 1e-6);
  EXPECT_TRUE(road.at(30.0, 3.0, 0.3, 0, cursors).on_road);
}

TEST(Road, TakesGripFromTheFrictionMap) {
  crg::SurfaceOptions options;
  options.friction_map = straight(50.0, 0.5, [](double, double v) { return v > 0 ? 0.4 : 0.9; });
  const crg::Surface surface(straight(50.0, 0.5, [](double, double) { return 0.0; }), options);
  RoadCursors cursors;
  EXPECT_NEAR(Road(surface).at(20.0, 2.0, 0.0, 0, cursors).friction, 0.4, 1e-6);
  EXPECT_NEAR(Road(surface).at(20.0, -2.0, 0.0, 0, cursors).friction, 0.9, 1e-6);
}

}  // namespace
