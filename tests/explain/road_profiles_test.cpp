// A road that is stated flat and leans and climbs in truth: the whole lap is found at once, beside
// a yaw rate that is logged late, and nothing on a road that is stated right.
#include "road_profiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "explain/explain.h"
#include "lap_waves.h"
#include "simulated_drive.h"
#include "support/figure.h"
#include "support/oval_road.h"
#include "vehicle/lap.h"

namespace explain {
namespace road_profiles_test {

constexpr double kTurn = 2 * std::numbers::pi;

struct Truth {
  double bank = 0.0;   ///< into the turn in the middle of the half circles, m/m
  double grade = 0.0;  ///< most along the lap, m/m
};

double bank_at(const Truth& truth, double share) {
  // Two half circles to the left, which it leans into.
  const double wave = std::sin(kTurn * (2 * share - 0.25)) - 0.2;
  return -truth.bank * std::max(0.0, wave) / 0.8;
}

crg::Crg oval(const Truth& truth) {
  test_support::OvalOptions options;
  options.straight_m = 300;
  options.radius_m = 110;
  options.iso_class = 0;
  options.kerb_height_m = 0;
  options.v_step_m = 0.5;
  test_support::Oval made = test_support::oval_road(options);
  crg::Grid& grid = made.grid;
  const double length_m = grid.u_step_m * static_cast<double>(grid.rows() - 1);
  for (std::size_t i = 0; i < grid.rows(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(grid.rows() - 1);
    for (std::size_t j = 0; j < grid.columns(); ++j)
      grid.at(i, j) = static_cast<float>(bank_at(truth, share) * grid.v_m[j] -
                                         truth.grade * length_m / kTurn * std::cos(kTurn * share));
  }
  return crg::make_crg(made.line, grid);
}

/// How a column is logged.
struct Logger {
  double yaw_filter_s = 0.0;
  double ax_from_speed_s =
      0.0;  ///< ax is the derivative of the speed behind this filter; 0: measured
};

void filter(std::vector<double>& x, double time_s) {
  double state = x.front();
  for (double& value : x) state = value = value + (state - value) * std::exp(-0.02 / time_s);
}

/// Two laps of the simulated car as a logger of 50 Hz has them; four with KERBSTONE_HEAVY=1.
recording::Table recorded(const Truth& truth, const Logger& logger, std::uint64_t draw = 1) {
  const vehicle::Vehicle v = explain_test::racer();
  const auto car = vehicle::make_car(v.files, v.parameters, v.terms, v.contact);
  const crg::Surface surface(oval(truth));
  vehicle::LapOptions options;
  options.laps = std::getenv("KERBSTONE_HEAVY") != nullptr ? 4 : 2;
  options.record_every = 20;
  const recording::Table t = drive_laps(car, vehicle::Road(surface), options).telemetry;
  const std::vector<std::pair<const char*, double>> noise{
      {"time_s", 0.0},     {"x_m", 0.02},        {"y_m", 0.02},    {"yaw_rad", 1e-3},
      {"vx_mps", 0.03},    {"vy_mps", 0.03},     {"ax_mps2", 0.1}, {"ay_mps2", 0.1},
      {"steer_rad", 5e-4}, {"throttle", 3e-3},   {"gear", 0.0},    {"yaw_rate_radps", 2e-3},
      {"fuel_kg", 0.0},    {"engine_radps", 0.5}};
  recording::Table out;
  base::Random random(draw);
  for (const auto& [name, sd] : noise) {
    std::vector<double> x = *t.find(name);
    if (name == std::string("yaw_rate_radps") && logger.yaw_filter_s > 0)
      filter(x, logger.yaw_filter_s);
    if (name == std::string("ax_mps2") && logger.ax_from_speed_s > 0) {
      const std::vector<double>& vx = *t.find("vx_mps");
      for (std::size_t i = 0; i < x.size(); ++i)
        x[i] = (vx[std::min(i + 1, x.size() - 1)] - vx[i > 0 ? i - 1 : 0]) / 0.04;
      filter(x, logger.ax_from_speed_s);
    }
    for (double& value : x) value += sd * random.normal();
    out.add(name, std::move(x));
  }
  return out;
}

Findings explained(const recording::Table& log, const Truth& stated,
                   const std::set<int>& hold_out = {}) {
  const crg::Surface road(oval(stated));
  ExplainOptions options;
  options.hold_out = hold_out;
  options.nulls = 300;
  return explain_relations({make_signals(log, identity_mapping(log), road, "log.csv")},
                           explain_test::racer(), options);
}

const Finding* found(const Findings& all, const char* mechanism) {
  for (const Finding& f : all.findings)
    if (f.mechanism == mechanism) return &f;
  return nullptr;
}

/// Share of the lap where the profile is the truth to 10 %, its interval or 0.005.
double right(const Finding& f, const std::function<double(double share)>& truth) {
  double count = 0;
  for (const ProfilePoint& p : f.profile) {
    const double share = p.u_m / (f.profile.back().u_m + f.profile[1].u_m), is = truth(share);
    count += std::abs(p.value - is) < std::max({0.1 * std::abs(is), p.ci90, 0.005}) ? 1 : 0;
  }
  return count / static_cast<double>(f.profile.size());
}

TEST(RoadProfiles, ARoadThatIsStatedFlatIsFoundAlongTheWholeLap) {
  const Truth truth{.bank = 0.2, .grade = 0.03};
  const Findings all = explained(recorded(truth, {.yaw_filter_s = 0.3}), {});
  const Finding* bank = found(all, "road.banking");
  const Finding* grade = found(all, "road.grade");
  ASSERT_TRUE(bank != nullptr && grade != nullptr) << findings_json(all);
  const double bank_right = right(*bank, [&](double share) { return bank_at(truth, share); }),
               grade_right = right(
                   *grade, [&](double share) { return truth.grade * std::sin(kTurn * share); });
  support::figure("bank_percent", 100 * bank_right),
      support::figure("grade_percent", 100 * grade_right);
  EXPECT_GT(bank_right, 0.8);
  EXPECT_GT(grade_right, 0.8);
  EXPECT_EQ(bank->not_used + grade->not_used, "");
  const Finding* late = found(all, "sensor.low_pass");
  ASSERT_NE(late, nullptr) << findings_json(all);
  EXPECT_EQ(late->channel, "yaw_rate_radps");
  EXPECT_NEAR(late->parameters.front().value, 0.3, 0.03);
  EXPECT_EQ(found(all, "sensor.gain"), nullptr);
  // The logger filters what it has sampled: half a sample that no lever arm is to explain.
  EXPECT_EQ(found(all, "sensor.lever_arm"), nullptr) << findings_json(all);
}

TEST(RoadProfiles, WhatOneSensorShowsInLapsOfOneSpeedMayBeTheCar) {
  const recording::Table all_columns = recorded({.bank = 0.08, .grade = 0.0}, {});
  recording::Table log;
  for (std::size_t k = 0; k < all_columns.names.size(); ++k)
    if (const std::string& name = all_columns.names[k]; name != "steer_rad" && name != "throttle")
      log.add(name, all_columns.columns[k]);
  const Findings all = explained(log, {});
  const Finding* bank = found(all, "road.banking");
  ASSERT_NE(bank, nullptr) << findings_json(all);
  ASSERT_EQ(bank->rivals.size(), 1u);
  EXPECT_EQ(bank->rivals.front().channel, "ay_mps2");
  EXPECT_FALSE(bank->rivals.front().separable);
  EXPECT_NE(bank->not_used, "");
}

// Of two laps, by nine draws of the logger's noise.
TEST(SlowRoadProfiles, ABankedRoadIsFoundWhateverTheNoise) {
  const Truth truth{.bank = 0.2, .grade = 0.03};
  int found_right = 0, gains = 0;
  for (std::uint64_t draw = 1; draw <= 9; ++draw) {
    const Findings all = explained(recorded(truth, {.yaw_filter_s = 0.3}, draw), {});
    const Finding* bank = found(all, "road.banking");
    ASSERT_NE(bank, nullptr) << draw;
    found_right += right(*bank, [&](double share) { return bank_at(truth, share); }) > 0.8;
    gains += found(all, "sensor.gain") != nullptr;
  }
  support::figure("right", found_right), support::figure("gains", gains);
  EXPECT_GE(found_right, 8);
  EXPECT_LE(gains, 1);
}

TEST(SlowRoadProfiles, ARoadIsFoundWhereALapIsHeldOut) {
  const Truth truth{.bank = 0.2, .grade = 0.03};
  const Findings all = explained(recorded(truth, {}), {}, {2});
  for (const auto& [name, is] : std::vector<std::pair<const char*, std::function<double(double)>>>{
           {"road.banking", [&](double share) { return bank_at(truth, share); }},
           {"road.grade", [&](double share) { return truth.grade * std::sin(kTurn * share); }}}) {
    const Finding* f = found(all, name);
    ASSERT_NE(f, nullptr) << name << findings_json(all);
    EXPECT_GT(right(*f, is), 0.8) << name;
  }
}

TEST(SlowRoadProfiles, AGradeIsFoundByForceWhereAxIsTheDerivativeOfTheSpeed) {
  const Truth truth{.bank = 0.15, .grade = 0.04};
  const Findings all = explained(recorded(truth, {.ax_from_speed_s = 0.5}), {});
  const Finding* grade = found(all, "road.grade");
  ASSERT_NE(grade, nullptr) << findings_json(all);
  EXPECT_GT(right(*grade, [&](double share) { return truth.grade * std::sin(kTurn * share); }),
            0.8);
  EXPECT_NE(found(all, "sensor.derived"), nullptr) << findings_json(all);
}

TEST(SlowRoadProfiles, WithoutALateralAccelerationNoBankingIsInvented) {
  // A cosine alone does not say to which side.
  const Truth truth{.bank = 0.2, .grade = 0.0};
  const recording::Table all_columns = recorded(truth, {});
  recording::Table log;
  for (std::size_t k = 0; k < all_columns.names.size(); ++k)
    if (all_columns.names[k] != "ay_mps2") log.add(all_columns.names[k], all_columns.columns[k]);
  const Findings all = explained(log, {});
  const Finding* bank = found(all, "road.banking");
  if (bank != nullptr && bank->profile.size() > 60) {
    EXPECT_GT(right(*bank, [&](double share) { return bank_at(truth, share); }), 0.8);
  }
}

TEST(RoadProfiles, ALeaningRoadThatIsStatedRightIsNotDoubted) {
  const Truth truth{.bank = 0.2, .grade = 0.03};
  const Findings all = explained(recorded(truth, {}), truth);
  for (const Finding& f : all.findings) EXPECT_NE(f.kind, "road") << f.mechanism;
}

TEST(RoadProfiles, WavesCloseWhereTheRoadDoes) {
  const Eigen::MatrixXd closed = waves(100, 5, true), open = waves(101, 5, false);
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(closed.col(k).sum(), k == 0 ? 100 : 0, 1e-9) << k;
  // Half a wave on the open road, from 1 to -1.
  EXPECT_NEAR(open(0, 1), 1, 1e-12);
  EXPECT_NEAR(open(100, 1), -1, 1e-12);
  EXPECT_NEAR(wave_turns(3, true), 2, 1e-12);
  EXPECT_NEAR(wave_turns(3, false), 1.5, 1e-12);
}

}  // namespace road_profiles_test
}  // namespace explain
