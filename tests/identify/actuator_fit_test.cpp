// Actuators whose equations are integrated here are found again from noisy records of 50 Hz.
#include "identify/actuator_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdlib>
#include <functional>

#include "base/error.h"
#include "base/random.h"

namespace actuator_fit_test {

using identify::ActuatorFit, identify::ActuatorOrder;

struct Truth {
  int poles = 2;
  double dead_s = 0.03, lag_s = 0.05, damping = 0.7, gain = 1.0, play = 0.0, lead_s = 0.0;
};

struct Rows {
  std::vector<double> time_s, command, movement;
};

constexpr int kMilliseconds = 60000;

/// Every millisecond: levels that change at most every 60 ms, or smooth movements as of a driver.
std::vector<double> input(bool racing, base::Random& random) {
  std::vector<double> out;
  double level = 0.0, once = 0.0, twice = 0.0;
  for (int k = 0; k < kMilliseconds; ++k) {
    if (racing) {
      if (k % 5 == 0) level = random.normal();
      once += (level - once) * 0.001 / 0.08;
      twice += (once - twice) * 0.001 / 0.05;
      out.push_back(twice);
    } else {
      if (k % 60 == 0) level = random.uniform() < 0.5 ? -1.0 : 1.0;
      out.push_back(level);
    }
  }
  return out;
}

/// Integrated in steps of 0.1 ms; recorded every 20 ms with noise of a tenth of the movement's
/// standard deviation (20 dB).
Rows recorded(const Truth& truth, const std::vector<double>& u, base::Random& random,
              double noise = 0.1) {
  std::vector<double> y;
  const int whole = static_cast<int>(truth.dead_s * 1e3);
  const double part = truth.dead_s * 1e3 - whole, h = 1e-4;
  double place = u[0], rate = 0.0, held = u[0];
  for (int k = 0; k < static_cast<int>(u.size()); ++k) {
    const auto at = [&](int i) { return u[static_cast<std::size_t>(std::max(0, i))]; };
    const double in = at(k - whole) * (1 - part) + at(k - whole - 1) * part;
    for (int s = 0; s < 10; ++s) {
      if (truth.poles == 1) {
        rate = (in - place) / truth.lag_s;
      } else {
        rate +=
            h * (in - place - 2 * truth.damping * truth.lag_s * rate) / (truth.lag_s * truth.lag_s);
      }
      place += h * rate;
    }
    const double moved = place + truth.lead_s * rate;
    held = std::clamp(held, moved - truth.play / 2, moved + truth.play / 2);
    y.push_back(truth.gain * held);
  }
  double mean = 0.0, square = 0.0;
  for (const double value : y) mean += value / static_cast<double>(y.size());
  for (const double value : y)
    square += (value - mean) * (value - mean) / static_cast<double>(y.size());
  Rows out;
  for (std::size_t k = 0; k < u.size(); k += 20) {
    out.time_s.push_back(1e-3 * static_cast<double>(k));
    out.command.push_back(u[k]);
    out.movement.push_back(y[k] + noise * std::sqrt(square) * random.normal());
  }
  return out;
}

ActuatorFit fit(const Rows& rows, const identify::ActuatorFitOptions& options = {}) {
  return identify::fit_actuator(rows.time_s, rows.command, rows.movement, options);
}

/// The distance of the nearest found pole to the truth's slower one, over its size.
double pole_error(const Truth& truth, const ActuatorFit& found) {
  std::complex<double> pole(-1.0 / truth.lag_s, 0.0);
  if (truth.poles == 2)
    pole = (-truth.damping + std::sqrt(std::complex<double>(truth.damping * truth.damping - 1.0))) /
           truth.lag_s;
  double out = INFINITY;
  for (const auto& one : found.poles_radps)
    out = std::min(out, std::abs(one - pole) / std::abs(pole));
  return out;
}

// KERBSTONE_HEAVY=1: all 200.
TEST(ActuatorFit, OrderDeadTimeAndPolesAreFoundThroughNoise) {
  const int count = std::getenv("KERBSTONE_HEAVY") ? 200 : 10;
  int order = 0, dead = 0, poles = 0, narrow = 0, inside = 0;
  for (int i = 0; i < count; ++i) {
    base::Random random(1000 + static_cast<unsigned>(i));
    Truth truth;
    truth.poles = 1 + static_cast<int>(random.below(2));
    truth.dead_s = random.uniform(0.01, 0.08);
    truth.lag_s = random.uniform(0.03, 0.09);
    truth.damping = random.uniform(0.4, 0.9);
    truth.gain = random.uniform(0.5, 2.0);
    const ActuatorFit found = fit(recorded(truth, input(i % 2 == 1, random), random));
    order += found.order == ActuatorOrder{truth.poles, false, false};
    const double off_s = std::abs(found.dead_time_s.value - truth.dead_s),
                 half_s = 1.645 * found.dead_time_s.sd;
    dead += off_s < 0.003;
    narrow += 2.0 * half_s < 0.010;
    inside += off_s < half_s;
    poles += pole_error(truth, found) < 0.05;
  }
  RecordProperty("order", order);
  RecordProperty("dead_time", dead);
  RecordProperty("narrow", narrow);
  RecordProperty("inside", inside);
  RecordProperty("poles", poles);
  EXPECT_GE(order, 0.9 * count);
  EXPECT_GE(dead, 0.98 * count);
  EXPECT_EQ(narrow, count);
  EXPECT_GE(inside, 0.85 * count);
  EXPECT_GE(poles, 0.9 * count);
}

TEST(ActuatorFit, PlayIsFoundWhereItIs) {
  base::Random random(5);
  Truth truth;
  truth.play = 0.15;
  truth.gain = 1.4;
  const auto u = input(true, random);
  const ActuatorFit found = fit(recorded(truth, u, random, 0.03));
  EXPECT_EQ(found.order, (ActuatorOrder{2, false, true}));
  EXPECT_NEAR(found.play.value, 1.4 * 0.15, 4.0 * found.play.sd + 0.01);
  EXPECT_NEAR(found.dead_time_s.value, truth.dead_s, 0.003);
  truth.play = 0.0;
  EXPECT_FALSE(fit(recorded(truth, u, random, 0.03)).order.play);
}

TEST(ActuatorFit, AZeroIsFoundWhereItIs) {
  base::Random random(6);
  Truth truth;
  truth.lead_s = 0.06;
  const ActuatorFit found = fit(recorded(truth, input(false, random), random, 0.03));
  EXPECT_EQ(found.order, (ActuatorOrder{2, true, false}));
  EXPECT_NEAR(found.lead_s.value, 0.06, 0.004);
  EXPECT_LT(pole_error(truth, found), 0.03);
}

TEST(ActuatorFit, WhatItSimulatesIsTheArxModelOfItsCoefficients) {
  base::Random random(7);
  for (const identify::Hold hold : {identify::Hold::kLine, identify::Hold::kStep})
    for (const ActuatorOrder order : {ActuatorOrder{1, false}, {1, true}, {2, true}, {3, false}}) {
      // Of the order that is fitted: a zero that the record lacks may be anywhere.
      Truth truth;
      truth.poles = std::min(2, order.poles);
      truth.lead_s = order.zero ? 0.12 : 0.0;
      const Rows rows = recorded(truth, input(true, random), random);
      identify::ActuatorFitOptions options;
      options.order = order;
      options.hold = hold;
      const ActuatorFit found = fit(rows, options);
      const auto y = identify::simulate_actuator(found, rows.command);
      const identify::Arx arx = identify::arx_of(found);
      EXPECT_EQ(arx.a.size(), static_cast<std::size_t>(order.poles));
      double worst = 0.0;
      for (std::size_t k = 40; k < 2000; ++k) {
        double next = 0.0;
        for (std::size_t i = 0; i < arx.a.size(); ++i)
          next -= arx.a[i] * (y[k - 1 - i] - found.offset.value);
        for (std::size_t i = 0; i < arx.b.size(); ++i)
          next += arx.b[i] * rows.command[k - static_cast<std::size_t>(arx.dead_steps) - i];
        worst = std::max(worst, std::abs(next + found.offset.value - y[k]));
      }
      EXPECT_LT(worst, 1e-6) << order.poles << order.zero;
    }
}

TEST(ActuatorFit, RowsThatAreNotEvenAreMadeSo) {
  base::Random random(8);
  Truth truth;
  const auto u = input(true, random);
  const Rows even = recorded(truth, u, random, 0.03);
  Rows uneven;  // every seventh row is missing, but not from the clock
  for (std::size_t i = 0; i < even.time_s.size(); ++i) {
    if (i % 7 == 3) continue;
    uneven.time_s.push_back(even.time_s[i]);
    uneven.command.push_back(even.command[i]);
    uneven.movement.push_back(even.movement[i]);
  }
  identify::ActuatorFitOptions options;
  options.order = ActuatorOrder{2, false, false};
  const ActuatorFit found = fit(uneven, options);
  EXPECT_NEAR(found.dead_time_s.value, truth.dead_s, 0.003);
  EXPECT_LT(pole_error(truth, found), 0.05);
}

TEST(ActuatorFit, AnyNumberOfThreadsGivesTheSame) {
  base::Random random(9);
  const Rows rows = recorded({}, input(false, random), random);
  identify::ActuatorFitOptions one, three;
  one.threads = 1;
  three.threads = 3;
  const ActuatorFit a = fit(rows, one), b = fit(rows, three);
  EXPECT_EQ(a.dead_time_s.value, b.dead_time_s.value);
  EXPECT_EQ(a.lag_s.sd, b.lag_s.sd);
  ASSERT_EQ(a.tried.size(), b.tried.size());
  for (std::size_t i = 0; i < a.tried.size(); ++i) EXPECT_EQ(a.tried[i].rms, b.tried[i].rms);
}

TEST(ActuatorFit, RefusesWhatSaysNothing) {
  const auto refusal = [](const std::vector<double>& t, const std::vector<double>& u,
                          const std::vector<double>& y) -> std::string {
    try {
      identify::fit_actuator(t, u, y);
    } catch (const base::Error& error) {
      return error.what();
    }
    return "";
  };
  using ::testing::HasSubstr;
  const std::vector<double> few(20, 0.0);
  EXPECT_THAT(refusal(few, few, few), HasSubstr("20 rows, wanted at least 50"));
  std::vector<double> time, still(200, 0.3), moving;
  for (int k = 0; k < 200; ++k) {
    time.push_back(0.01 * k);
    moving.push_back(std::sin(0.1 * k));
  }
  EXPECT_THAT(refusal(time, still, moving), HasSubstr("the command stays at 0.3"));
  EXPECT_THAT(refusal(time, moving, still), HasSubstr("the movement stays at 0.3"));
  base::Random random(11);
  std::vector<double> noise;
  for (int k = 0; k < 200; ++k) noise.push_back(random.normal());
  EXPECT_THAT(refusal(time, moving, noise), HasSubstr("the movement does not follow the command"));
  // A single step does not tell three lags with a lead. The movement does follow, so that is
  // not what is said.
  std::vector<double> later, stepped, behind;
  for (int k = 0; k < 400; ++k) {
    later.push_back(0.01 * k);
    stepped.push_back(k > 150 ? 1.0 : 0.0);
    const double before = behind.empty() ? 0.0 : behind.back();
    behind.push_back(before + 0.2 * (stepped.back() - before));
  }
  for (double& value : behind) value += 0.01 * random.normal();
  identify::ActuatorFitOptions three;
  three.order = ActuatorOrder{3, true, false};
  try {
    identify::fit_actuator(later, stepped, behind, three);
    ADD_FAILURE() << "no refusal";
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("the movement follows the command, but the record cannot "
                                        "tell the numbers of 3 poles with a zero apart"));
    EXPECT_THAT(error.what(), HasSubstr("state a smaller order (--order 1, or 0)"));
  }
  std::vector<double> early(200, 0.0);
  early[3] = 1.0;
  EXPECT_THAT(refusal(time, early, noise), HasSubstr("in the first second or tenth"));
  moving[3] = NAN;
  EXPECT_THAT(refusal(time, moving, still), HasSubstr("not finite"));
}

}  // namespace actuator_fit_test
