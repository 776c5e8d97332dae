// What a gyro says on a road that leans, rises and dips.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "explain/model.h"
#include "simulated_drive.h"
#include "vehicle/test_roads.h"

namespace explain {
namespace relations_test {

using Eigen::Vector3d;
constexpr double kBank = 0.2, kHeight_m = 1.0, kDips = 6.0, kSpeed_mps = 22.0;

/// A circle that leans to its outside and dips six times a lap.
crg::Crg dipping_circle() {
  crg::Crg road = stadium(0.0, 60.0);
  crg::Grid& grid = road.grid;
  const std::size_t across = grid.v_m.size(), along = grid.z_m.size() / across;
  const double length_m = grid.u_step_m * static_cast<double>(along - 1);
  for (std::size_t i = 0; i < along; ++i)
    for (std::size_t j = 0; j < across; ++j)
      grid.z_m[i * across + j] =
          static_cast<float>(kHeight_m * std::sin(2 * std::numbers::pi * kDips * grid.u_step_m *
                                                  static_cast<double>(i) / length_m) +
                             kBank * grid.v_m[j]);
  return road;
}

/// A body that lies on the middle of it: its axes in the map, at `s_m` of its way.
struct Body {
  Vector3d place, forward, left;
};
Body body(double s_m, double radius_m) {
  const double round = s_m / radius_m;
  const auto at = [&](double angle) {
    return Vector3d(radius_m * std::sin(angle), radius_m * (1 - std::cos(angle)),
                    kHeight_m * std::sin(kDips * angle));
  };
  constexpr double kSmall = 1e-5;
  Body out;
  out.place = at(round);
  out.forward = (at(round + kSmall) - at(round - kSmall)).normalized();
  const Vector3d across(-std::sin(round), std::cos(round), kBank);
  out.left = out.forward.cross(across).normalized().cross(out.forward);
  return out;
}

/// Two laps, 50 Hz, without noise. The yaw rate is how fast the body's nose goes to its left.
recording::Table circling(double radius_m, bool heading) {
  recording::Table t;
  for (const char* name : {"time_s", "x_m", "y_m", "yaw_rad", "vx_mps", "yaw_rate_radps", "vy_mps"})
    t.add(name, {});
  const double seconds = 4 * std::numbers::pi * radius_m / kSpeed_mps;
  double s_m = 0;
  for (int i = 0; 0.02 * i < seconds; ++i) {
    const double small_m = 1e-3;
    const Body before = body(s_m - small_m, radius_m), now = body(s_m, radius_m),
               after = body(s_m + small_m, radius_m);
    const double way = (after.place - before.place).norm();
    const double yaw_rate = (after.forward - before.forward).dot(now.left) / way * kSpeed_mps;
    // Its nose swings about the path, in the plane of the road.
    const double time_s = 0.02 * i, beside_rad = 0.03 * std::sin(0.7 * time_s),
                 swinging = 0.021 * std::cos(0.7 * time_s);
    const Vector3d nose = std::cos(beside_rad) * now.forward + std::sin(beside_rad) * now.left;
    const double values[] = {
        time_s,
        now.place.x(),
        now.place.y(),
        s_m / radius_m +
            std::remainder(std::atan2(nose.y(), nose.x()) - s_m / radius_m, 2 * std::numbers::pi),
        kSpeed_mps * std::cos(beside_rad),
        yaw_rate + swinging,
        -kSpeed_mps * std::sin(beside_rad)};
    for (std::size_t k = 0; k < t.columns.size(); ++k) t.columns[k].push_back(values[k]);
    s_m += 0.02 * kSpeed_mps * 2 * small_m / way;
  }
  if (heading) return t;
  recording::Table without;
  for (std::size_t k = 0; k < t.columns.size(); ++k)
    if (t.names[k] != "yaw_rad") without.add(t.names[k], t.columns[k]);
  return without;
}

TEST(Relations, AGyroOnARoadThatLeansAndDipsIsRight) {
  const crg::Crg road = dipping_circle();
  const double radius_m = road.grid.u_step_m *
                          static_cast<double>(road.grid.z_m.size() / road.grid.v_m.size() - 1) /
                          (2 * std::numbers::pi);
  const vehicle::Vehicle car = explain_test::racer();
  Setting stated;
  stated.p = car.parameters;
  for (const bool heading : {true, false}) {
    const recording::Table log = circling(radius_m, heading);
    const Signals s = make_signals(log, identity_mapping(log), crg::Surface(road), "circle.csv");
    const Residuals off = residuals(s, car, stated, {.none = true});
    double square = 0, count = 0, most = 0, least = 1e9;
    for (std::size_t i = 20; i + 20 < s.n; ++i) {
      const double x = off.r[Relation::kGyro][i];
      if (!std::isfinite(x)) continue;
      square += x * x, count += 1;
      most = std::max(most, s.x[kYawRate][i]), least = std::min(least, s.x[kYawRate][i]);
    }
    ASSERT_GT(count, 300);
    const double rms = std::sqrt(square / count);
    fmt::print("{} heading: yaw rate {:.4f} to {:.4f} rad/s, error {:.5f} rms\n",
               heading ? "with" : "without", least, most, rms);
    EXPECT_LT(rms, 0.0006);  // measured 0.0003 and 0.0004
  }
}

// A receiver's antenna ahead of the centre of mass goes another way than the car.
TEST(Relations, AnAntennaAheadSwingsOutOfTheTurn) {
  constexpr double kAhead_m = 1.5;
  const crg::Crg road = dipping_circle();
  const double radius_m = road.grid.u_step_m *
                          static_cast<double>(road.grid.z_m.size() / road.grid.v_m.size() - 1) /
                          (2 * std::numbers::pi);
  const recording::Table at_centre = circling(radius_m, true);
  recording::Table ahead = at_centre;
  for (std::size_t i = 0; i < ahead.rows(); ++i) {
    ahead.columns[1][i] += kAhead_m * std::cos(ahead.columns[3][i]);
    ahead.columns[2][i] += kAhead_m * std::sin(ahead.columns[3][i]);
  }
  const vehicle::Vehicle car = explain_test::racer();
  const auto course_off = [&](const recording::Table& log, double place_ahead_m) {
    const Signals s = make_signals(log, identity_mapping(log), crg::Surface(road), "circle.csv");
    Setting set;
    set.p = car.parameters;
    set.place_ahead = place_ahead_m;
    const std::vector<double> off = residuals(s, car, set, {.none = true}).r[Relation::kCourse];
    double sum = 0, count = 0;
    for (std::size_t i = 20; i + 20 < off.size(); ++i)
      if (std::isfinite(off[i])) sum += off[i], count += 1;
    EXPECT_GT(count, 300);
    return sum / count;
  };
  const double none = course_off(at_centre, 0), swung = course_off(ahead, 0);
  EXPECT_NEAR(swung - none, kAhead_m / radius_m, 0.002);
  EXPECT_NEAR(course_off(ahead, kAhead_m), none, 0.001);
}

}  // namespace relations_test
}  // namespace explain
