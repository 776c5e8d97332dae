// Columns that are broken for a part of the drive, against each other, or on a clock of their own.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "brake_axles.h"
#include "changes_in_time.h"
#include "explain/columns.h"
#include "explain/judge.h"
#include "good_log.h"
#include "scales_of_car.h"
#include "speed_of_path.h"
#include "vehicle/vehicle_file.h"

namespace explain {
namespace broken_columns_test {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using BrokenColumns = GoodLog;

/// The same, `s` seconds late; its first value before, its last one behind what comes early.
std::vector<double> late(const std::vector<double>& x, double s) {
  const std::ptrdiff_t rows = std::lround(s * 50), last = std::ssize(x) - 1;
  std::vector<double> out(x.size());
  for (std::ptrdiff_t i = 0; i <= last; ++i)
    out[static_cast<std::size_t>(i)] =
        x[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i - rows, 0, last))];
  return out;
}

TEST_F(BrokenColumns, WhatStandsStillForAWhileIsNotUsedThere) {
  recording::Table t = *log_;
  for (const std::size_t from : {2000, 3500, 5000})
    for (const char* place : {"x_m", "y_m"})
      std::fill_n(column(t, place).begin() + static_cast<std::ptrdiff_t>(from), 100,
                  column(*log_, place)[from]);
  EXPECT_THAT(said(t), AllOf(HasSubstr("'x_m', 'y_m' stand still 3 times"), HasSubstr("6.0 s"),
                             HasSubstr("first at 40.0 s"), Not(HasSubstr("does not follow"))));
  EXPECT_FALSE(signals(t).broken);
  EXPECT_TRUE(std::isnan(signals(t).x[kX][820]));  // 41 s
  t = *log_;
  const std::size_t half = t.rows() / 2;
  std::fill(column(t, "yaw_rad").begin() + static_cast<std::ptrdiff_t>(half),
            column(t, "yaw_rad").end(), column(t, "yaw_rad")[half]);
  EXPECT_THAT(said(t), HasSubstr("'yaw_rad' stands still 1 time"));
  EXPECT_TRUE(signals(t).broken);
  EXPECT_FALSE(signals(t).present[kYaw]);
  t = *log_;
  std::fill(column(t, "vx_mps").begin() + static_cast<std::ptrdiff_t>(half),
            column(t, "vx_mps").end(), column(t, "vx_mps")[half]);
  EXPECT_THAT(said(t), HasSubstr("give a log in which they go on"));
}

/// The value that the column has there, or another one, for 20 s.
std::vector<double> held(std::vector<double> x, double value = NAN) {
  const double at = std::isfinite(value) ? value : x[2200];
  std::fill_n(x.begin() + 2200, 1000, at);
  return x;
}

TEST_F(BrokenColumns, WhatIsHeldWhileTheCarTurnsOrBrakesIsNotUsedThere) {
  for (const auto& [name, channel] : {std::pair{"yaw_rate_radps", kYawRate},
                                      {"ay_mps2", kAy},
                                      {"steer_rad", kSteer},
                                      {"throttle", kThrottle}})
    for (const double value : {0.0, static_cast<double>(NAN)}) {
      recording::Table t = *log_;
      column(t, name) = held(column(t, name), value);
      const Signals s = signals(t);
      EXPECT_THAT(s.remarks,
                  Contains(AllOf(HasSubstr(fmt::format("'{}' stands still 1 time", name)),
                                 HasSubstr("first at 44.0 s: not used there"))));
      EXPECT_TRUE(std::isnan(s.x[channel][1000]));
    }
  recording::Table t = *log_;
  const auto full = static_cast<std::ptrdiff_t>(t.rows() / 2);
  std::fill(column(t, "throttle").begin() + full, column(t, "throttle").end(), 1.0);
  EXPECT_THAT(said(t), HasSubstr("'throttle' stands still 1 time"));
  EXPECT_TRUE(signals(t).broken) << "over a fifth of the drive";
  t = changed("throttle", [](double) { return 0.5; });
  EXPECT_THAT(said(t), HasSubstr("'throttle' is constant: not used; take it out"));
  EXPECT_TRUE(signals(t).broken);
}

TEST_F(BrokenColumns, WhatIsHeldForAFifthOfTheDriveIsNotJudged) {
  const std::size_t fifth = log_->rows() / 5;
  const auto stands = [&](recording::Table t, const std::string& name, std::size_t from,
                          double at) {
    std::fill_n(column(t, name).begin() + static_cast<std::ptrdiff_t>(from), fifth - 100, at);
    const Signals s = signals(t);
    EXPECT_THAT(s.remarks, Contains(HasSubstr(fmt::format("'{}' stands still 1 time", name))));
    EXPECT_TRUE(s.broken) << name << ' ' << at << ' ' << from;
  };
  for (const std::size_t from : {fifth, 3 * fifth}) {
    stands(*log_, "yaw_rad", from, 1.0);
    for (const double value : {0.0, 0.2, 0.6, 1.0}) stands(*log_, "throttle", from, value);
  }
  // Without a gyro beside it: its path turns.
  stands(changed("yaw_rate_radps", [](double) { return NAN; }), "yaw_rad", fifth, 1.0);
  // Devices that leave places and heading out together now and then are usual ones.
  recording::Table t = *log_;
  for (const std::size_t from : {1000, 2500, 4000, 5500})
    for (const char* name : {"x_m", "y_m", "yaw_rad"})
      std::fill_n(column(t, name).begin() + static_cast<std::ptrdiff_t>(from), 100,
                  column(*log_, name)[from]);
  EXPECT_FALSE(signals(t).broken) << said(t);
}

TEST_F(BrokenColumns, ExchangedBrakePressuresAreNamed) {
  // Brakes that want twice the pressure in front make the same of it.
  vehicle::Vehicle car = vehicle::read_vehicle(folder_->path("none/vehicle.yaml"));
  car.parameters[vehicle::Parameter::front_brake_friction] /= 1.4;
  car.parameters[vehicle::Parameter::rear_brake_friction] /= 0.7;
  recording::Table t = *log_;
  for (const char* side : {"l", "r"}) {
    for (double& pa : column(t, fmt::format("brake_f{}_pa", side))) pa *= 1.4;
    for (double& pa : column(t, fmt::format("brake_r{}_pa", side))) pa *= 0.7;
  }
  Signals right = signals(t);
  leave_out_exchanged_brakes(right, car);
  EXPECT_TRUE(right.remarks.empty());
  EXPECT_FALSE(right.broken);
  for (const char* side : {"l", "r"})
    std::swap(column(t, fmt::format("brake_f{}_pa", side)),
              column(t, fmt::format("brake_r{}_pa", side)));
  Signals wrong = signals(t);
  leave_out_exchanged_brakes(wrong, car);
  EXPECT_THAT(wrong.remarks, Contains(HasSubstr("front and rear are exchanged")));
  EXPECT_TRUE(wrong.broken);
  EXPECT_FALSE(wrong.present[kBrakeFront]);
}

TEST_F(BrokenColumns, AnAntennaBesideTheMiddleOfTheCarIsNamedWithItsPlace) {
  const auto aside = [](double left_m) {
    recording::Table t = *log_;
    const std::vector<double>& heading = column(*log_, "yaw_rad");
    for (std::size_t i = 0; i < t.rows(); ++i) {
      column(t, "x_m")[i] -= left_m * std::sin(heading[i]);
      column(t, "y_m")[i] += left_m * std::cos(heading[i]);
    }
    return t;
  };
  EXPECT_THAT(said(aside(3.0)), HasSubstr("'x_m', 'y_m' are slower than 'vx_mps' in left turns"));
  EXPECT_THAT(said(aside(3.0)), ::testing::ContainsRegex("a point (2.9|3.0|3.1) m to the left"));
  EXPECT_TRUE(signals(aside(3.0)).broken);
  EXPECT_THAT(said(aside(-1.5)), ::testing::ContainsRegex("a point 1.[456] m to the right"));
  EXPECT_EQ(said(aside(0.5)), "");
}

TEST_F(BrokenColumns, WhatStaysWhereItIsBecauseTheCarDoesIsUsed) {
  // Where the car goes straight, for a second and a half.
  const std::vector<double>& rate = column(*log_, "yaw_rate_radps");
  std::size_t straight = 0;
  double least = HUGE_VAL;
  for (std::size_t i = 500; i + 575 < rate.size(); i += 25) {
    double most = 0;
    for (std::size_t k = i; k < i + 75; ++k) most = std::max(most, std::abs(rate[k]));
    if (most < least) least = most, straight = i;
  }
  recording::Table t = *log_;
  for (const char* name : {"yaw_rate_radps", "ay_mps2", "steer_rad"})
    std::fill_n(column(t, name).begin() + static_cast<std::ptrdiff_t>(straight), 75, 0.0);
  EXPECT_EQ(said(t), "");
}

TEST_F(BrokenColumns, SpikesAreNoFaultOfOtherColumns) {
  for (const auto& [name, by] : {std::pair{"x_m", 30.0},
                                 {"yaw_rad", 1.0},
                                 {"vx_mps", 12.0},
                                 {"ax_mps2", 60.0},
                                 {"ay_mps2", 60.0}}) {
    recording::Table t = *log_;
    for (std::size_t k = 0; k < 20; ++k) column(t, name)[150 + 300 * k] += k % 2 == 0 ? by : -by;
    EXPECT_EQ(said(t), fmt::format("log.csv: '{}': 20 samples leap from their neighbours, first at "
                                   "3.00 s: not used\n",
                                   name));
  }
}

TEST_F(BrokenColumns, WhatLacksMostOfTheDriveIsNotJudged) {
  const auto half_a_lap = [](const char* name) {
    recording::Table t = *log_;
    for (std::size_t i = 0; i < t.rows(); ++i)
      if (i < 2200 || i > 4700) column(t, name)[i] = NAN;
    return t;
  };
  for (const char* name : {"throttle", "steer_rad", "yaw_rate_radps", "ay_mps2"}) {
    const Signals s = signals(half_a_lap(name));
    EXPECT_THAT(s.remarks, Contains(HasSubstr(fmt::format("'{}' has nothing for ", name))));
    EXPECT_TRUE(s.broken) << name;
  }
  EXPECT_THAT(said(half_a_lap("vx_mps")), HasSubstr("position and speed are the least"));
  recording::Table slow = *log_;
  for (std::size_t i = 0; i < slow.rows(); ++i)
    if (i % 10 != 0) column(slow, "ax_mps2")[i] = NAN;
  EXPECT_THAT(said(slow), HasSubstr("'ax_mps2' has 5.0 measurements a second"));
  EXPECT_TRUE(signals(slow).broken);
}

TEST_F(BrokenColumns, RowsWithOneTimeAreSaid) {
  recording::Table t = *log_;
  for (std::size_t i = 100; i < t.rows(); i += 100)
    column(t, "time_s")[i] = column(t, "time_s")[i - 1];
  EXPECT_THAT(said(t), HasSubstr("rows have the time of the row before, first row 101"));
}

TEST_F(BrokenColumns, LeapsAndSpikesAreTakenOut) {
  recording::Table t = *log_;
  for (std::size_t i = 4000; i < t.rows(); ++i)
    column(t, "x_m")[i] += 2.0, column(t, "y_m")[i] -= 1.5;
  EXPECT_THAT(said(t), AllOf(HasSubstr("'x_m', 'y_m' leap"), HasSubstr("first at 79.")));
  t = *log_;
  for (const std::size_t at : {1000, 3000, 6000}) column(t, "steer_rad")[at] += 0.4;
  EXPECT_THAT(said(t),
              HasSubstr("'steer_rad': 3 samples leap from their neighbours, first at 20.00"));
  // Without them it is the log as it was.
  const Signals with = signals(t), without = signals(*log_);
  for (std::size_t i = 0; i < with.n; ++i)
    if (std::isfinite(with.x[kSteer][i])) {
      ASSERT_NEAR(with.x[kSteer][i], without.x[kSteer][i], 2e-3);
    }
}

TEST_F(BrokenColumns, ColumnsThatAreRightForAPartAreNamed) {
  recording::Table t = *log_;
  for (std::size_t i = 4000; i < t.rows(); ++i) column(t, "ay_mps2")[i] *= 0.5;
  EXPECT_THAT(said(t), ::testing::ContainsRegex(
                           "'ay_mps2' is (0.9|1.0). times what the acceleration across of the path "
                           "asks for until about [789]0 s, and 0.(4|5). times after it"));
  t = *log_;
  for (std::size_t i = 0; i < t.rows(); ++i)
    column(t, "yaw_rate_radps")[i] += 1e-4 * column(t, "time_s")[i];
  EXPECT_THAT(said(t), HasSubstr("'yaw_rate_radps' has a zero that drifts"));
  t = *log_;
  t = *log_;
  for (std::size_t i = 4000; i < t.rows(); ++i) column(t, "vx_mps")[i] *= 0.5;
  EXPECT_THAT(said(t), ::testing::ContainsRegex("as fast as the path until about [789]0 s"));
  t = *log_;
  for (std::size_t i = 0; i < t.rows(); ++i)
    column(t, "ax_mps2")[i] = 3.0 * std::sin(0.37 * static_cast<double>(i * i % 1009));
  EXPECT_THAT(said(t), HasSubstr("'ax_mps2' does not follow"));
  t = *log_;
  std::fill(column(t, "yaw_rate_radps").begin() + 4000, column(t, "yaw_rate_radps").end(),
            std::nan(""));
  EXPECT_THAT(said(t), HasSubstr("'yaw_rate_radps' has nothing for"));
}

TEST_F(BrokenColumns, PedalsThatChangeTheirScaleAreNamed) {
  const std::vector<const char*> brakes{"brake_fl_pa", "brake_fr_pa", "brake_rl_pa", "brake_rr_pa"};
  for (const double factor : {0.5, 2.0, 1.0})
    for (const std::vector<const char*>& pedal : {std::vector<const char*>{"throttle"}, brakes}) {
      recording::Table t = *log_;
      for (const char* name : pedal)
        for (std::size_t i = t.rows() / 2; i < t.rows(); ++i)
          column(t, name)[i] = std::min(column(t, name)[i] * factor, name[0] == 't' ? 1.0 : 1e9);
      Signals s = signals(t);
      leave_out_what_changes(s);
      EXPECT_EQ(s.broken, factor != 1.0) << pedal[0] << factor;
    }
}

TEST_F(BrokenColumns, WhatChangesItsScaleALittleOrItsClockAloneIsNamed) {
  const auto halved = [&](const std::vector<const char*>& names, double factor) {
    recording::Table t = *log_;
    for (const char* name : names)
      for (std::size_t i = t.rows() / 2; i < t.rows(); ++i) column(t, name)[i] *= factor;
    return t;
  };
  EXPECT_THAT(said(halved({"vx_mps"}, 1.12)), HasSubstr("one unit throughout is wanted"));
  EXPECT_THAT(said(halved({"yaw_rate_radps"}, 0.7)), HasSubstr("times after it"));
  EXPECT_THAT(said(halved({"vy_mps"}, 0.4)), HasSubstr("'vy_mps' is"));
  Signals wheels = signals(halved({"wheel_fl_radps", "wheel_fr_radps"}, 1.1));
  leave_out_what_changes(wheels);
  EXPECT_THAT(wheels.remarks, Contains(HasSubstr("times the speed until about")));
  EXPECT_THAT(said(changed("vx_mps", [](double v) { return 1.13 * v; })), HasSubstr("scale 0.88"));
  EXPECT_EQ(said(changed("vx_mps", [](double v) { return 1.04 * v; })), "");
  recording::Table t = *log_;
  for (const char* name : {"brake_fl_pa", "brake_fr_pa", "brake_rl_pa", "brake_rr_pa"})
    std::fill(column(t, name).begin(), column(t, name).end(), 0.0);
  EXPECT_TRUE(signals(t).broken) << "the car brakes";
  for (const char* name : {"brake_rl_pa", "brake_rr_pa"}) column(t, name) = column(*log_, name);
  EXPECT_THAT(signals(t).remarks, Not(Contains(HasSubstr("take it out")))) << "by one axle";
  for (const auto& [name, by_s, words] :
       {std::tuple{"vy_mps", 0.35, "'vy_mps' runs on another clock: 0.3"},
        {"throttle", 0.5, "'throttle' is pressed 0."},
        {"vx_mps", 0.4, "'vx_mps' come 0."}}) {
    t = *log_;
    column(t, name) = late(column(*log_, name), by_s);
    EXPECT_THAT(said(t), HasSubstr(words));
  }
}

// A car that waits in its box while places jitter, then drives circles of 8 m: nothing is wrong.
TEST(SpeedOfPath, OfACarThatStandsOrTurnsTightlyIsNotRefused) {
  Signals s;
  s.n = 4000;
  for (const Channel c : {kX, kY, kVx, kWheelFront})
    s.present[c] = true, s.x[c].assign(s.n, 0.0), s.dx[c].assign(s.n, 0.0);
  constexpr double kRadius_m = 8.0, kSpeed_mps = 10.5;
  double way_m = 0.0;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double v = std::clamp((static_cast<double>(i) - 1300.0) / 100.0, 0.0, 1.0) * kSpeed_mps;
    const double jitter = 0.02 * (i % 2 == 0 ? 1.0 : -1.0), angle = way_m / kRadius_m;
    s.x[kX][i] = kRadius_m * std::cos(angle), s.x[kY][i] = kRadius_m * std::sin(angle);
    s.dx[kX][i] = -v * std::sin(angle) + jitter, s.dx[kY][i] = v * std::cos(angle) + jitter;
    s.x[kVx][i] = v;
    s.x[kWheelFront][i] = v / 0.3;
    way_m += v * Signals::kStep_s;
  }
  EXPECT_NO_THROW(refuse_another_unit(s));
  std::fill(s.x[kVx].begin(), s.x[kVx].begin() + 1300, 0.02);  // noise where it stands
  leave_out_what_changes(s);
  EXPECT_TRUE(s.remarks.empty());
  for (std::size_t i = 0; i < s.n; ++i) {
    s.x[kX][i] = Signals::kStep_s * kSpeed_mps * static_cast<double>(i), s.x[kY][i] = 0.0;
    s.dx[kX][i] = kSpeed_mps, s.dx[kY][i] = 0.0, s.x[kVx][i] = 1.1 * kSpeed_mps;
  }
  EXPECT_THROW(refuse_another_unit(s), vehicle::Error);
}

TEST(Drifts, AreSeenBesideAWindowInWhichTheHeadingLeaps) {
  std::vector<double> turning, gyro;
  for (std::size_t i = 0; i < 8000; ++i) {
    const double time_s = Signals::kStep_s * static_cast<double>(i);
    turning.push_back(0.2 * std::sin(time_s / 7.0));
    gyro.push_back(turning[i] + 0.004 * std::sin(time_s * time_s) + 1e-4 * time_s);
  }
  for (std::size_t i = 200; i < 400; ++i) turning[i] -= 0.16;
  const auto drift = drifts(gyro, turning);
  ASSERT_TRUE(drift.has_value());
  EXPECT_NEAR(drift->after - drift->before, 0.04, 0.004);
}

TEST_F(BrokenColumns, ExchangedAndStuckWheelsAreNamed) {
  recording::Table t = *log_;
  std::swap(column(t, "wheel_fl_radps"), column(t, "wheel_fr_radps"));
  EXPECT_THAT(said(t), AllOf(HasSubstr("'wheel_fl_radps' is faster in left turns"),
                             HasSubstr("left and right are exchanged")));
  EXPECT_TRUE(signals(t).broken);
  t = *log_;
  std::fill(column(t, "wheel_rr_radps").begin() + 3000, column(t, "wheel_rr_radps").end(), 30.0);
  EXPECT_THAT(said(t),
              HasSubstr("'wheel_rr_radps' differs from 'wheel_rl_radps' and from the speed"));
  EXPECT_FALSE(signals(t).present[kWheelRear]);
  EXPECT_FALSE(signals(t).present[kWheelRearDifference]);
  EXPECT_TRUE(signals(t).present[kWheelFront]);
  t = *log_;
  for (double& v : column(t, "throttle")) v = 1 - v;
  EXPECT_THAT(said(t), HasSubstr("'throttle' is largest where the car slows down"));
}

TEST_F(BrokenColumns, PlacesWhoseOriginIsNotTheRoadsAreNamedWithTheShift) {
  recording::Table t = *log_;
  for (double& x : column(t, "x_m")) x -= 2.1;
  for (double& y : column(t, "y_m")) y += 2.1;
  EXPECT_THAT(said(t), ::testing::ContainsRegex("once shifted by .(2.0|2.1), -(2.0|2.1). m"));
  EXPECT_TRUE(signals(t).broken);
  // Who keeps to one side of the road does so in every direction.
  t = *log_;
  const std::vector<double>& heading = column(*log_, "yaw_rad");
  for (std::size_t i = 0; i < t.rows(); ++i) {
    column(t, "x_m")[i] -= 3 * std::sin(heading[i]);
    column(t, "y_m")[i] += 3 * std::cos(heading[i]);
  }
  EXPECT_THAT(said(t), Not(HasSubstr("origin")));
}

TEST_F(BrokenColumns, AColumnThatStandsBesideItsPairIsNamed) {
  recording::Table t = *log_;
  std::fill(column(t, "brake_fl_pa").begin() + 5000, column(t, "brake_fl_pa").end(), 0.0);
  EXPECT_THAT(said(t), HasSubstr("'brake_fl_pa' stands still from 100."));
  EXPECT_TRUE(signals(t).broken);
  EXPECT_FALSE(signals(t).present[kBrakeRear]) << "one pedal presses on both";
  t = changed("wheel_fr_radps", [](double v) { return 1.1 * v; });
  EXPECT_THAT(said(t), HasSubstr("'wheel_fl_radps' is 0.91 times 'wheel_fr_radps'"));
  EXPECT_TRUE(signals(t).broken);
}

TEST_F(BrokenColumns, WheelsOfAnotherAxleAreNamed) {
  recording::Table t = *log_;
  std::swap(column(t, "wheel_rl_radps"), column(t, "wheel_rr_radps"));
  EXPECT_THAT(said(t), HasSubstr("'wheel_rl_radps' is faster in left turns"));
  EXPECT_TRUE(signals(t).broken);
  t = *log_;
  for (const char* side : {"l", "r"})
    std::swap(column(t, fmt::format("wheel_f{}_radps", side)),
              column(t, fmt::format("wheel_r{}_radps", side)));
  EXPECT_THAT(said(t), HasSubstr("front and rear are exchanged"));
  EXPECT_TRUE(signals(t).broken);
  EXPECT_FALSE(signals(t).present[kWheelRear]);
}

TEST_F(BrokenColumns, ASpeedOfDrivenWheelsIsRefused) {
  recording::Table t = *log_;
  const std::vector<double>&left = column(t, "wheel_rl_radps"),
        &right = column(t, "wheel_rr_radps");
  std::vector<double> speed;
  for (std::size_t i = 0; i < t.rows(); ++i) speed.push_back(0.318 * 0.5 * (left[i] + right[i]));
  column(t, "vx_mps") = speed;
  EXPECT_THAT(said(t), AllOf(HasSubstr("'vx_mps' is as fast as 'wheel_rl_radps,wheel_rr_radps'"),
                             HasSubstr("speed of the driven wheels")));
}

TEST_F(BrokenColumns, ExchangedLoadsAreNamed) {
  // Loads of a car that stands level: what turns and brakes moves them, by arms of its own.
  recording::Table t = *log_;
  for (const auto& [name, side, end] :
       {std::tuple{"fz_fl_n", -1, 1}, {"fz_fr_n", 1, 1}, {"fz_rl_n", -1, -1}, {"fz_rr_n", 1, -1}}) {
    std::vector<double> load;
    for (std::size_t i = 0; i < t.rows(); ++i)
      load.push_back(2000 + side * 80 * column(t, "ay_mps2")[i] -
                     end * 60 * column(t, "ax_mps2")[i] +
                     0.3 * column(t, "vx_mps")[i] * column(t, "vx_mps")[i]);
    t.names.erase(std::remove(t.names.begin(), t.names.end(), name), t.names.end());
    t.columns.resize(t.names.size());
    t.add(name, load);
  }
  EXPECT_THAT(said(t), Not(HasSubstr("exchanged")));
  recording::Table sides = t, ends = t, kilograms = t;
  for (const char* name : {"fz_fl_n", "fz_fr_n", "fz_rl_n", "fz_rr_n"})
    for (double& load : column(kilograms, name)) load /= 9.81;
  EXPECT_THAT(said(kilograms), HasSubstr("no weight of a car in newton"));
  std::swap(column(sides, "fz_rl_n"), column(sides, "fz_rr_n"));
  EXPECT_THAT(said(sides), HasSubstr("'fz_rl_n' is loaded in left turns"));
  for (const char* side : {"l", "r"})
    std::swap(column(ends, fmt::format("fz_f{}_n", side)),
              column(ends, fmt::format("fz_r{}_n", side)));
  EXPECT_THAT(said(ends), HasSubstr("front and rear are exchanged"));
}

TEST_F(BrokenColumns, DevicesWithAClockOfTheirOwnAreMoved) {
  const auto moved = [&](const std::vector<const char*>& names, double s) {
    recording::Table t = *log_;
    for (const char* name : names) column(t, name) = late(column(*log_, name), s);
    return signals(t).late;
  };
  const LateColumns places = moved({"x_m", "y_m"}, 0.2);
  EXPECT_THAT(places.columns, ::testing::ElementsAre("x_m", "y_m"));
  EXPECT_NEAR(places.delay_s, 0.2, 0.015);
  const LateColumns imu = moved({"yaw_rate_radps", "ax_mps2", "ay_mps2", "az_mps2"}, 0.12);
  EXPECT_THAT(imu.columns,
              ::testing::UnorderedElementsAre("yaw_rate_radps", "ax_mps2", "ay_mps2", "az_mps2"));
  EXPECT_NEAR(imu.delay_s, 0.12, 0.015);
  std::vector<const char*> bus;
  for (const std::string& name : log_->names)
    if (name != "time_s" && name != "x_m" && name != "y_m" && name != "vy_mps" &&
        !name.starts_with("yaw_") && !name.starts_with("a"))
      bus.push_back(name.c_str());
  const LateColumns of_the_bus = moved(bus, 0.2);
  EXPECT_EQ(of_the_bus.columns.size(), bus.size());
  EXPECT_NEAR(of_the_bus.delay_s, 0.2, 0.015);
  // Where the speed is the places': by the brakes. Early as well as late.
  EXPECT_NEAR(moved(bus, -0.2).delay_s, -0.2, 0.015);
  bus.erase(
      std::find_if(bus.begin(), bus.end(), [](auto x) { return x == std::string("vx_mps"); }));
  for (const double s : {0.2, -0.2}) {
    const LateColumns without_speed = moved(bus, s);
    EXPECT_EQ(without_speed.columns.size(), bus.size()) << s;
    EXPECT_NEAR(without_speed.delay_s, s, 0.03);
  }
  EXPECT_TRUE(moved(bus, -0.1).columns.empty()) << "a driver and wheels that slip are that early";
  EXPECT_TRUE(moved({"yaw_rate_radps"}, 0.12).columns.empty()) << "one alone may be filtered";
  // Written as one finding; what the analysis adds to one of them is that one's own.
  Signals log;
  log.late = imu;
  Findings all;
  Finding& own = all.findings.emplace_back();
  own.mechanism = "sensor.delay";
  own.channel = "ay_mps2";
  own.parameters.push_back({"delay", "s", 0.004, 0.002, 0.006});
  name_late_columns(log, all);
  ASSERT_EQ(all.findings.size(), 2u);
  EXPECT_EQ(all.findings[0].channel.find("ay_mps2"), std::string::npos);
  EXPECT_NEAR(all.findings[1].parameters[0].value, imu.delay_s + 0.004, 1e-12);
}

TEST_F(BrokenColumns, WheelsAndAGyroOffAlikeAreNoClock) {
  recording::Table t = changed("vx_mps", [](double v) { return 1.009 * v; });
  for (double& v : column(t, "yaw_rate_radps")) v *= 1.009;
  EXPECT_THAT(said(t), testing::HasSubstr("the clock runs"));
  for (const char* wheel : {"fl", "fr", "rl", "rr"}) {
    *std::find(t.names.begin(), t.names.end(), fmt::format("wheel_{}_radps", wheel)) =
        fmt::format("wheel_{}_mps", wheel);
    std::vector<double>& speed = column(t, fmt::format("wheel_{}_mps", wheel));
    speed = column(t, "vx_mps");
    for (std::size_t i = 0; i < t.rows(); ++i)  // right and left differ in a turn
      speed[i] += (wheel[1] == 'r' ? 0.7 : -0.7) * column(t, "yaw_rate_radps")[i];
  }
  EXPECT_EQ(said(t), "");
}

TEST_F(BrokenColumns, AClockThatRunsFastIsRefusedWithItsScale) {
  recording::Table t = changed("time_s", [](double v) { return 1.02 * v; });
  const std::string refusal = said(t);
  EXPECT_THAT(refusal, ::testing::ContainsRegex("clock runs fast by (1.9|2.0|2.1) %; give time_s"));
  Mapping mapping = identity_mapping(t);
  mapping.columns[0].scale = std::stod(refusal.substr(refusal.find("scale ") + 6));
  ASSERT_EQ(mapping.columns[0].channel, "time_s");
  EXPECT_TRUE(make_signals(t, mapping, *road_, "log.csv").remarks.empty());
  // Beside a heading that jitters the path says how it turns.
  for (std::size_t i = 0; i < t.rows(); ++i)
    column(t, "yaw_rad")[i] += 0.02 * std::sin(0.7 * static_cast<double>(i * i % 1009));
  EXPECT_THAT(said(t), ::testing::ContainsRegex("the path turns.*fast by (1.9|2.0|2.1) %"));
}

TEST_F(BrokenColumns, SteeringThatIsNotTheCarsIsNamed) {
  const vehicle::Vehicle car = vehicle::read_vehicle(folder_->path("none/vehicle.yaml"));
  for (const double scale : {0.5, 1.0, 2.0}) {
    Signals s = signals(changed("steer_rad", [&](double v) { return scale * v; }));
    leave_out_other_steering(s, car);
    EXPECT_EQ(s.broken, scale != 1) << scale;
    EXPECT_EQ(s.remarks.size(), scale != 1 ? 1u : 0u);
    if (scale != 1) {
      EXPECT_THAT(s.remarks[0], HasSubstr("as the wheelbase asks"));
    }
  }
}

TEST_F(BrokenColumns, LoadsThatAreNotTheCarsAreNamed) {
  const vehicle::Vehicle car = vehicle::read_vehicle(folder_->path("none/vehicle.yaml"));
  for (const double scale : {0.5, 1.0, 2.0}) {
    Signals s = signals(*log_);
    s.present[kLoadFront] = s.present[kLoadRear] = true;
    s.x[kLoadFront].clear(), s.x[kLoadRear].clear();
    for (const double v : s.x[kVx])
      for (const Channel c : {kLoadFront, kLoadRear})
        s.x[c].push_back(scale *
                         (4.9 * car.parameters[vehicle::Parameter::chassis_mass_kg] + 0.6 * v * v));
    leave_out_other_loads(s, car);
    EXPECT_EQ(s.broken, scale != 1) << scale;
    EXPECT_EQ(s.remarks.size(), scale != 1 ? 1u : 0u);
    EXPECT_EQ(s.present[kLoadRear], scale == 1);
  }
}

TEST_F(BrokenColumns, AnotherScaleIsNamed) {
  for (const double scale : {0.5, 2.0}) {
    const recording::Table t = changed("vy_mps", [&](double v) { return scale * v; });
    EXPECT_THAT(said(t), HasSubstr("times the path against the heading")) << scale;
    EXPECT_TRUE(signals(t).broken);
  }
  const recording::Table t = changed("throttle", [](double v) { return std::min(v, 0.5); });
  EXPECT_THAT(said(t), AllOf(HasSubstr("'throttle' goes to 0.5"), HasSubstr("give it scale")));
  EXPECT_TRUE(signals(t).broken);
  // One that is never pressed down, but moves all the time.
  int row = 0;
  const recording::Table gentle =
      changed("throttle", [&](double) { return 0.2 + 0.15 * std::sin(0.01 * row++); });
  EXPECT_THAT(said(gentle), Not(HasSubstr("give it scale")));
}

TEST_F(BrokenColumns, AreNotJudged) {
  Findings all;
  all.findings.emplace_back().kind = "vehicle";
  all.findings.emplace_back().kind = "sensor";
  all.broken_columns = true;
  hold_back_beside_broken_columns(all);
  EXPECT_EQ(judge(all), Verdict::kNotJudged);
  EXPECT_FALSE(all.findings[0].not_used.empty());
  EXPECT_TRUE(all.findings[1].not_used.empty());
  EXPECT_STREQ(name_of(Verdict::kNotJudged), "not judged");
}

}  // namespace broken_columns_test
}  // namespace explain
