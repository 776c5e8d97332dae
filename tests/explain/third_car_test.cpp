// The third car of the blind trials: its physics by balances that it does not compute, and how well
// the stated tyre files describe its tyres.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/temporary_folder.h"
#include "trials/electric_tyre.h"
#include "trials/stated_electric.h"
#include "trials/truth_car_electric.h"
#include "vehicle/magic_formula.h"
#include "vehicle/tyre_file.h"

namespace third_car_test {

using namespace trials;

const Track& circle() {
  static const Track track = make_track(300, 0, 0, 0, 0);
  return track;
}

/// Round a circle at the speed that pedals hold, until nothing changes any more.
struct Steady {
  const Track& track = circle();
  State x{};
  Output o{};
  explicit Steady(const TruthCar& car, double speed_mps = 40) {
    x[0] = track.x[0], x[1] = track.y[0], x[2] = track.heading[0], x[3] = speed_mps;
    x[kWheelFl] = x[kWheelFr] = speed_mps / car.radius_f;
    x[kWheelRl] = x[kWheelRr] = speed_mps / car.radius_r;
    double s_m = 0, integral = 0;
    for (int step = 0; step < 8000; ++step) {
      const double error = speed_mps - x[3];
      integral += 0.0005 * error;
      const auto [s, v] = project(track, x[0], x[1], s_m);
      const double ahead = std::remainder(track.at(s).heading - x[2], 2 * std::acos(-1.0));
      const Commands c{.steer = 0.012 - 0.004 * v + 0.3 * ahead,
                       .throttle = std::clamp(0.3 * error + integral, 0.0, 1.0),
                       .gear = 1};
      advance(car, track, x, c, s_m, &o);
    }
  }
};

TEST(ThirdCar, LoadsBalanceWeightDownforceAndTheMomentOfDrag) {
  TruthCar low = electric_car(TyreLaw::kBrush), high = low;
  low.electric->levelled = high.electric->levelled = true;
  low.electric->drag_height = 0;
  high.electric->drag_height = 0.5;
  const Steady a(low), b(high);
  const double q = 0.5 * low.density * b.x[3] * b.x[3];
  EXPECT_NEAR(b.x[3], 40, 0.2);
  // All that presses is carried by the wheels. The banking of this road presses a little too.
  EXPECT_NEAR(b.o.fz_front + b.o.fz_rear, low.mass * b.o.az + q * (low.lift_f + low.lift_r), 20);
  // Drag that acts half a metre up takes its moment over the wheelbase off the front axle.
  const double moved = q * low.drag * 0.5 / (low.a + low.b);
  EXPECT_GT(moved, 100);
  EXPECT_NEAR(a.o.fz_front - b.o.fz_front, moved, 0.05 * moved);
}

TEST(ThirdCar, ItsBodyLeansOutOfTheCurveAndAccelerometersWithIt) {
  TruthCar leaning = electric_car(TyreLaw::kBrush), levelled = leaning;
  levelled.electric->levelled = true;
  const Steady a(leaning), b(levelled);
  EXPECT_GT(b.o.ay, 2);  // to the left
  EXPECT_GT(a.x[kHeave + 1], 0.002);
  EXPECT_NEAR(a.o.ay - b.o.ay, a.o.az * a.x[kHeave + 1], 0.005);
  // What is felt is the same, seen from axes that have turned.
  EXPECT_LT(a.o.az, b.o.az - 0.005);
  EXPECT_NEAR(std::hypot(a.o.ax, a.o.ay, a.o.az), std::hypot(b.o.ax, b.o.ay, b.o.az), 0.002);
  // Springs that are half as stiff, tyres aside, lean nearly twice as far.
  TruthCar soft = leaning;
  for (double* k : {&soft.electric->spring[0], &soft.electric->spring[1], &soft.electric->bar[0],
                    &soft.electric->bar[1]})
    *k *= 0.5;
  soft.electric->tyre_npm = leaning.electric->tyre_npm = 1e8;
  const double ratio = Steady(soft).x[kHeave + 1] / Steady(leaning).x[kHeave + 1];
  EXPECT_NEAR(ratio, 2, 0.05);
}

TEST(ThirdCar, ItsActuatorsHaveOnePole) {
  const TruthCar car = electric_car(TyreLaw::kTable);
  Steady held(car);
  double s_m = project(held.track, held.x[0], held.x[1], held.o.s).first;
  const double from = held.x[kPressed], to = 1e6;
  const int steps = static_cast<int>(std::lround(car.electric->brake_s * 1000));
  for (int step = 0; step < steps; ++step)
    advance(car, held.track, held.x, {.brake_pa = to, .gear = 1}, s_m, nullptr);
  EXPECT_NEAR((held.x[kPressed] - from) / (to - from), 1 - std::exp(-1), 1e-6);
}

TEST(ThirdCar, StiffnessAlongGrowsFasterThanTheLoadAndThatAcrossSlower) {
  for (const TyreLaw law : {TyreLaw::kBrush, TyreLaw::kTable}) {
    const ElectricTyre tyre{law, 2700, 1.6, 0.1, 27, 22};
    const auto along = [&](double n) {
      return electric_tyre(tyre, n * 2700, 1, 1e-5, 0).x / (n * 2700 * 1e-5);
    };
    const auto across = [&](double n) {
      return -electric_tyre(tyre, n * 2700, 1, 0, 1e-5).y / (n * 2700 * 1e-5);
    };
    EXPECT_NEAR(along(1), 27, 0.01);
    EXPECT_NEAR(across(1), 22, 0.01);
    EXPECT_GT(along(1.5), 1.03 * along(1));
    EXPECT_LT(across(1.5), 0.97 * across(1));
    // Beyond the peak it slides, and never pulls more than its friction.
    EXPECT_LT(std::abs(electric_tyre(tyre, 2700, 1, 0, 0.5).y), 1.6 * 2700);
  }
}

TEST(ThirdCar, TheStatedTyreFileIsItsTyreWithinAFewPerCent) {
  const support::TemporaryFolder folder;
  for (const TyreLaw law : {TyreLaw::kBrush, TyreLaw::kTable}) {
    const TruthCar car = electric_car(law);
    StatedTyre stated{car.load_f, car.mu_f,     car.mu_load,     car.c_f,
                      car.ck,     car.radius_f, car.relaxation_f};
    stated.fit = &electric_fit(law);
    const auto file = vehicle::read_tyre(folder.file("front.tir", tir(stated)));
    const ElectricTyre tyre{law, car.load_f, car.mu_f, car.mu_load, car.ck, car.c_f};
    double sum = 0, count = 0;
    for (const double n : {0.5, 0.8, 1.0, 1.2, 1.5})
      for (double kappa = -0.08; kappa < 0.085; kappa += 0.02)
        for (double tan_alpha = 0; tan_alpha < 0.105; tan_alpha += 0.015) {
          const TyreForce real = electric_tyre(tyre, n * car.load_f, 1, kappa, tan_alpha);
          vehicle::TyreInput<double> in;
          in.fz_n = n * car.load_f, in.kappa = kappa, in.tan_alpha = tan_alpha, in.vx_mps = 30;
          const auto said = vehicle::tyre_forces(file.coefficients, in, {});
          const double peak = tyre.mu * in.fz_n;
          sum +=
              std::pow((said.fx_n - real.x) / peak, 2) + std::pow((said.fy_n - real.y) / peak, 2);
          count += 1;
        }
    const double rms = std::sqrt(sum / count);
    EXPECT_LT(rms, 0.025) << (law == TyreLaw::kBrush ? "brush" : "table");
    EXPECT_GT(rms, 0.002);  // two laws, not one written twice
  }
}

}  // namespace third_car_test
