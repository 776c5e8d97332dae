#include "explain/signals.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "signal_samples.h"
#include "turning_drive.h"
#include "vehicle/error.h"
#include "vehicle/test_roads.h"

namespace explain {
namespace signals_test {

using ::testing::HasSubstr;

/// Two laps of a road beside its reference line at a speed that swings.
recording::Table laps(const crg::Surface& road, double turn = 0, double dx = 0, double v_m = 1) {
  recording::Table t;
  for (const char* name : {"time_s", "x_m", "y_m", "vx_mps"}) t.add(name, {});
  const auto& line = road.reference_line();
  const double length = line.u_step_m * static_cast<double>(line.size() - 1);
  double s = 0;
  for (int i = 0; s < 2.2 * length; ++i) {
    const double v = 20 + 3 * std::sin(0.02 * i);
    const crg::Point2 p = road.xy_of_uv(std::fmod(s, length), v_m);
    t.columns[0].push_back(0.02 * i);
    t.columns[1].push_back(std::cos(turn) * p.x_m - std::sin(turn) * p.y_m + dx);
    t.columns[2].push_back(std::sin(turn) * p.x_m + std::cos(turn) * p.y_m);
    t.columns[3].push_back(v);
    s += 0.02 * v;
  }
  return t;
}

std::string refusal(const recording::Table& t, const crg::Surface& road) {
  try {
    make_signals(t, identity_mapping(t), road, "log.csv");
  } catch (const vehicle::Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Signals, PlacesLapsOnTheRoad) {
  const crg::Surface road(stadium());
  const recording::Table t = laps(road);
  const Signals s = make_signals(t, identity_mapping(t), road, "log.csv");
  EXPECT_EQ(s.lap.back(), 2);
  EXPECT_TRUE(s.whole[0]);
  EXPECT_TRUE(s.whole[1]);
  EXPECT_FALSE(s.whole[2]);
  for (std::size_t i = 20; i + 20 < s.n; ++i) {
    const double time = Signals::kStep_s * static_cast<double>(i);
    ASSERT_NEAR(s.v_m[i], 1.0, 0.05);
    // The derivative of what was smoothed: within the kernel's damping of a 1 rad/s swing.
    ASSERT_NEAR(s.dx[kVx][i], 3 * std::cos(time), 0.03);
  }
}

// Beside the middle of its leg a car is nearer to the middle of the other one, 6 m above or below.
TEST(Signals, StayOnTheirLegWhereTheRoadCrossesItself) {
  const crg::Surface road(figure_of_eight());
  const recording::Table t = laps(road, 0, 0, 3.0);
  const Signals s = make_signals(t, identity_mapping(t), road, "log.csv");
  const double steepest = 3.0 * 2 * M_PI / s.length_m;
  for (std::size_t i = 20; i + 20 < s.n; ++i) {
    ASSERT_NEAR(s.v_m[i], 3.0, 0.1) << s.u_m[i];
    ASSERT_LT(std::abs(s.grade[i]), 1.1 * steepest) << s.u_m[i];
    ASSERT_LT(std::abs(s.bank[i]), 0.01) << s.u_m[i];
  }
}

// 13 Hz at the laps' speed, a wave in 1.5 steps: read once a step it would be one of 7 Hz.
TEST(Signals, ReadTheRoadAsSmoothAsTheCarsMotion) {
  crg::Crg rough = stadium();
  const std::size_t columns = rough.grid.v_m.size();
  constexpr double kHeight_m = 0.004, kWave_rows = 3;
  for (std::size_t k = 0; k < rough.grid.z_m.size(); ++k)
    rough.grid.z_m[k] = static_cast<float>(
        kHeight_m * std::sin(2 * M_PI * static_cast<double>(k / columns) / kWave_rows));
  const crg::Surface road(rough);
  const recording::Table t = laps(road);
  const Signals s = make_signals(t, identity_mapping(t), road, "log.csv");
  for (std::size_t i = 20; i + 20 < s.n; ++i)
    ASSERT_LT(std::abs(s.curvature_v[i]), 0.3 * kHeight_m) << s.u_m[i];
}

TEST(Signals, TakesDelaysOutAndRepeatsForMissing) {
  const crg::Surface road(stadium());
  recording::Table t = laps(road);
  Mapping m = identity_mapping(t);
  const Signals plain = make_signals(t, m, road, "log.csv");
  std::vector<double> late(t.rows());
  for (std::size_t i = 0; i < t.rows(); ++i) late[i] = t.columns[3][(i < 10 ? 0 : i - 10) / 5 * 5];
  t.columns[3] = late;  // 0.2 s late and held for five samples
  m.columns[3].delay_s = 0.2;
  m.columns[3].held = true;
  const Signals mended = make_signals(t, m, road, "log.csv");
  for (std::size_t i = 40; i + 40 < plain.n; ++i)
    if (std::isfinite(mended.x[kVx][i])) {
      ASSERT_NEAR(mended.x[kVx][i], plain.x[kVx][i], 0.05);
    }
}

/// How late a swing comes out of the smoothing whose samples lie 0.3 of their distance beside the
/// steps.
double late_s(double samples_hz, double swing_hz) {
  const double turn = 2 * std::numbers::pi * swing_hz;
  Samples s;
  for (int i = 0; i < 20 * samples_hz; ++i) {
    s.t.push_back((i + 0.3) / samples_hz);
    s.x.push_back(std::sin(turn * s.t.back()));
  }
  std::vector<double> x, dx;
  smooth(s, 0.0, 400, 0.16, x, dx);
  double along = 0, beside = 0;
  for (std::size_t i = 20; i < 380; ++i) {  // whole swings
    const double t = Signals::kStep_s * static_cast<double>(i);
    along += x[i] * std::sin(turn * t);
    beside += x[i] * std::cos(turn * t);
  }
  return std::atan2(-beside, along) / turn;
}

// Samples as fast as the steps keep their distance to them all along: what they shift is no noise.
TEST(Signals, SmoothingShiftsNothingWhereverSamplesLie) {
  for (const double samples_hz : {20.0, 40.0})
    for (const double swing_hz : {0.5, 1.0, 2.0}) {
      const double late = late_s(samples_hz, swing_hz);
      fmt::print("{} Hz, swing of {} Hz: {:.4f} ms late\n", samples_hz, swing_hz, 1e3 * late);
      EXPECT_NEAR(late, 0.0, 0.15e-3);
    }
}

TEST(Signals, RefusesWhatItCannotUse) {
  const crg::Surface road(stadium());
  recording::Table t = laps(road);
  recording::Table back = t;
  back.columns[0][500] = 3.0;
  EXPECT_THAT(refusal(back, road), HasSubstr("row 501: the clock goes back"));
  recording::Table fast = t;
  for (double& v : fast.columns[3]) v *= 3.6;
  EXPECT_THAT(refusal(fast, road), HasSubstr("another unit"));
  recording::Table brief = t;
  for (auto& c : brief.columns) c.resize(300);
  EXPECT_THAT(refusal(brief, road), HasSubstr("at least 10 s"));
  recording::Table blind = t;
  blind.names[1] = "somewhere";
  EXPECT_THAT(refusal(blind, road), HasSubstr("no x_m"));
}

TEST(Signals, OffersTheTransformOfAnotherFrame) {
  const crg::Surface road(stadium());
  const std::string message = refusal(laps(road, 0.7, 5000), road);
  EXPECT_THAT(message, HasSubstr("beside this road"));
  EXPECT_THAT(message, HasSubstr("fits within"));
}

TEST(Signals, SaysThatTheCarDrivesBackwards) {
  const crg::Surface road(stadium());
  recording::Table t = laps(road);
  std::reverse(t.columns[1].begin(), t.columns[1].end());
  std::reverse(t.columns[2].begin(), t.columns[2].end());
  EXPECT_THAT(refusal(t, road), HasSubstr("against u"));
}

TEST(Signals, AHeadingToTheNorthEastIsNoCompass) {
  explain_test::TurningDrive d;
  d.radius_m = 800;
  d.speed_mps = 20;
  d.laps = 0.22;
  const crg::Surface road(explain_test::LeaningOval(d).flat_road());
  recording::Table t = explain_test::logged(d);
  const auto far = static_cast<std::ptrdiff_t>(t.rows() - 330);  // 13 s, about 45 degrees
  for (std::vector<double>& column : t.columns) column.erase(column.begin(), column.begin() + far);
  t.add("brake_command_pa", std::vector<double>(t.rows(), 0.0));
  const std::vector<std::string> said = make_signals(t, identity_mapping(t), road, "x").remarks;
  EXPECT_THAT(said, testing::ElementsAre("x: 'brake_command_pa' is constant: not used",
                                         HasSubstr("0.0 laps: what comes back every lap")));
}

}  // namespace signals_test
}  // namespace explain
