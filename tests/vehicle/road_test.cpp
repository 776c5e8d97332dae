#include "vehicle/road.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "test_car.h"
#include "test_roads.h"

namespace road_test {

using namespace vehicle;  // NOLINT: a test of this library

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

// Beside the road below, under the one above or beside it, too: a car that slides off under a
// bridge must not be lifted onto it.
TEST(Road, GoesOnBesideTheLevelThatIsNear) {
  const double half_m = std::numbers::pi * 30.0;
  const double x = 28.0 * std::sin(1.57), y = 30.0 - 28.0 * std::cos(1.57);
  const double low = 8.0 * 1.57 / (2 * std::numbers::pi);
  for (const bool under : {true, false}) {
    crg::Crg narrow = spiral(8.0);
    crg::Grid& grid = narrow.grid;
    for (std::size_t k = 0; k < grid.z_m.size(); ++k)
      if (grid.v_m[k % grid.columns()] > 1.5 && (!under || grid.u_of(k / grid.columns()) < half_m))
        grid.z_m[k] = std::numeric_limits<float>::quiet_NaN();
    const crg::Surface surface(narrow);
    const Road road(surface);
    RoadCursors cursors;
    const RoadPoint below = road.at(x, y, low + 0.3, 0, cursors),
                    above = road.at(x, y, low + 8.3, 0, cursors);
    EXPECT_FALSE(below.on_road);
    EXPECT_EQ(above.on_road, under);
    EXPECT_NEAR(below.z_m, low, 0.01) << under;
    EXPECT_NEAR(above.z_m, low + 8.0, 0.01) << under;
  }
}

// Round a ramp whose last half turn lies above its first: along the leg that a drive came by, with
// or without heights; a drive that begins on the upper leg needs a height, once.
TEST(Road, TracksADriveUnderAndOverABridge) {
  const crg::Surface surface(spiral(8.0));
  const double turn_m = 2.0 * std::numbers::pi * 30.0;
  for (const bool heights : {true, false}) {
    for (const double begin_m : {2.0, heights ? turn_m + 5.0 : 2.0}) {
      RoadTracker tracker(surface);
      for (double u = begin_m; u < 1.5 * turn_m - 1.0; u += 0.4) {
        const double v = 2.0 * std::sin(0.05 * u), r = 30.0 - v, a = u / 30.0;
        const double z = heights ? 8.0 * u / turn_m : std::numeric_limits<double>::quiet_NaN();
        RoadTracker fresh(surface);
        fresh.go_on_from(tracker.place());
        const crg::UV at = tracker.at(r * std::sin(a), 30.0 - r * std::cos(a), z);
        ASSERT_EQ(fresh.at(r * std::sin(a), 30.0 - r * std::cos(a), z).u_m, at.u_m);
        // The line is a polygon of 0.47 m: its foot lies up to a centimetre beside the circle's.
        ASSERT_NEAR(at.u_m, u, 0.02) << heights << " from " << begin_m;
        ASSERT_NEAR(at.v_m, v, 0.02);
      }
    }
  }
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

// On both levels of a bridge, beside the road, over a hole, at no level, on a plane.
TEST(Road, AnswersFourPointsAsOneByOne) {
  crg::Crg file = spiral(8.0);
  for (std::size_t i = 100; i < 110; ++i) file.grid.at(i, 5) = NAN;
  const crg::Surface surface(file);
  for (const Road& road : {Road(surface), Road(0.1, -0.2)}) {
    std::array<RoadCursors, 4> cars;
    RoadCursors alone, corners;
    int at_once = 0;
    for (int k = 0; k < 600; ++k) {
      const double along_rad = 0.012 * k, radius_m = 30.0 + 7.0 * std::sin(0.05 * k);
      std::array<crg::Point2, 4> points;
      for (std::size_t w = 0; w < 4; ++w)
        points[w] = {
            (radius_m + (w < 2 ? 0.1 : 0.0)) * std::sin(along_rad + (w % 2 == 0 ? 0.003 : 0.0)),
            30.0 - (radius_m + (w < 2 ? 0.1 : 0.0)) *
                       std::cos(along_rad + (w % 2 == 0 ? 0.003 : 0.0))};
      const double level =
          k % 7 == 6 ? NAN : 8.0 * along_rad / (2 * std::numbers::pi) + k / 100 % 3 * 4.0;
      const std::array<double, 4> z = road.heights_at(points, level, 2, corners);
      std::array<RoadPoint, 4> four;
      const bool known = road.at_four(points, {level, level, level, level}, 1,
                                      {&cars[0], &cars[1], &cars[2], &cars[3]},
                                      {&four[0], &four[1], &four[2], &four[3]});
      if (known) ++at_once;
      for (std::size_t w = 0; w < 4; ++w) {
        const RoadPoint one = road.at(points[w].x_m, points[w].y_m, level, w, alone);
        EXPECT_TRUE(z[w] == one.z_m || (std::isnan(z[w]) && std::isnan(one.z_m))) << k;
        if (!known) continue;
        EXPECT_EQ(four[w].z_m, one.z_m) << k;
        EXPECT_EQ(four[w].dzdx, one.dzdx) << k;
        EXPECT_EQ(four[w].dzdy, one.dzdy) << k;
        EXPECT_EQ(four[w].u_m, one.u_m) << k;
        EXPECT_EQ(four[w].v_m, one.v_m) << k;
        EXPECT_EQ(four[w].friction, one.friction) << k;
        EXPECT_EQ(four[w].on_road, one.on_road) << k;
      }
      if (testing::Test::HasFailure()) return;
      if (!known)  // as step_many() does
        for (std::size_t w = 0; w < 4; ++w)
          road.at(points[w].x_m, points[w].y_m, level, 1, cars[w]);
    }
    if (road.surface() != nullptr && crg::available(crg::StripKernel::Avx2)) {
      EXPECT_GT(at_once, 20);
    }
  }
}

TEST(Road, TakesGripFromTheFrictionMap) {
  crg::SurfaceOptions options;
  options.friction_map = straight(50.0, 0.5, [](double, double v) { return v > 0 ? 0.4 : 0.9; });
  const crg::Surface surface(straight(50.0, 0.5, [](double, double) { return 0.0; }), options);
  RoadCursors cursors;
  EXPECT_NEAR(Road(surface).at(20.0, 2.0, 0.0, 0, cursors).friction, 0.4, 1e-6);
  EXPECT_NEAR(Road(surface).at(20.0, -2.0, 0.0, 0, cursors).friction, 0.9, 1e-6);
}

// The first row and the last of a closed road may be a millimetre apart.
TEST(Road, GoesOnOverTheSeamOfAClosedRoad) {
  const crg::Surface surface(stadium());
  const crg::ReferenceLine& line = surface.reference_line();
  const double x0 = line.x_m.back(), y0 = line.y_m.back();
  const Road road(surface);
  RoadCursors cursors;
  for (int i = 0; i <= 100; ++i)
    for (const double v : {-5.0, 0.0, 4.0}) {
      const double x = x0 + 0.01 * i * (line.x_m.front() - x0) * 1.2;
      const double y = y0 + 0.01 * i * (line.y_m.front() - y0) * 1.2 + v;
      const RoadPoint point = road.at(x, y, 0.0, 0, cursors);
      EXPECT_TRUE(point.on_road) << i;
      EXPECT_EQ(point.z_m, 0.0) << i;
    }
}

TEST(Road, StopsAtAHoleOrGoesOnAsAsked) {
  crg::Crg file = straight(60, 0.5, [](double, double) { return 0.0; });
  const std::size_t columns = file.grid.columns();
  for (std::size_t i = 80; i < 84; ++i)  // u = 40 to 42 m, right half
    for (std::size_t j = 0; j < columns / 2; ++j) file.grid.z_m[i * columns + j] = std::nanf("");
  const crg::Surface surface(std::move(file));
  const CarFiles files = test_car_files();
  const Car<double> car = make_car(files, test_parameters(), default_amplitudes());
  for (const bool stop : {false, true}) {
    StartOptions begin;
    begin.x_m = 20;
    begin.speed_mps = 15;
    begin.gear = 0;
    Simulation<double> sim = start(car, Road(surface), begin);
    Detail<double> detail{};
    StepOptions options;
    options.stop_off_road = stop;
    StepResult result;
    Controls<double> neutral;
    neutral.gear_command = 0;
    while (result.ok() && sim.state[kX] < 50)
      result = step(car, sim, neutral, Road(surface), options, detail);
    EXPECT_EQ(result.ok(), !stop);
    if (!stop) continue;
    EXPECT_EQ(result.problem, StepResult::Problem::kNoRoad);
    EXPECT_EQ(result.index, 1u);  // front right
    EXPECT_NEAR(detail.wheel[1].road.u_m, 39.5, 0.6);
  }
}

}  // namespace road_test
