#include "vehicle/laws/brake_disc.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "test_car.h"

namespace brake_disc_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;
constexpr double kPerRpm = std::numbers::pi / 30.0;

// Worked by hand: a disc of 0.28 m at 100 rad/s has Re = 100 * 0.14^2 / 1.6e-5 = 122,500,
// turbulent: 2 * 0.015 * 122500^0.8 = 353.1 (by the diameter); air of 20 m/s: Re = 350,000, 0.04
// Re^0.8 = 1089.9. Slowly: 2 * 0.36 * 12250^0.5 = 79.69; 1 m/s: 0.70 * 17500^0.55 = 150.9.
TEST(BrakeDisc, KnowsItsFacesCorrelations) {
  const auto nusselt = [](double turning, double air, double still) {
    return laws::disc_face_nusselt<double>(0.28, turning, air, still);
  };
  EXPECT_NEAR(nusselt(100, 0, 0), 353.1, 0.4);
  EXPECT_NEAR(nusselt(0, 20, 0), 1089.9, 1.5);
  EXPECT_NEAR(nusselt(10, 0, 0), 79.69, 0.05);
  EXPECT_NEAR(nusselt(0, 1, 0), 150.9, 0.3);
  EXPECT_NEAR(nusselt(0, 0, 20), 20.0, 1e-3);
  // Joined: never below the greater, never above the sum, no jump anywhere.
  double last = 0;
  for (double speed = 0; speed < 80; speed += 0.01) {
    const double both = nusselt(speed / 0.3, speed, 20);
    EXPECT_GE(both, std::max(nusselt(speed / 0.3, 0, 0), nusselt(0, speed, 0)));
    if (speed > 0.3) {
      EXPECT_LT(both / last, 1.05) << speed;
    }
    EXPECT_GT(both, last);
    last = both;
  }
}

// The table of McPhee and Johnson (abstract, Int. J. Thermal Sciences 47, 2008, 458-467): between
// the fins of a vented rotor 27.0, 52.7 and 78.3 W/(m2 K) at 342, 684 and 1025 rpm. The abstract
// does not say its dimensions; those here are of a common front disc: 0.28 m outside, 0.16 m
// inside, channels of 15 mm. So this holds the level within a quarter and the growth within a
// fifth.
TEST(BrakeDisc, CoolsItsVanesAsMeasured) {
  const double rpm[] = {342, 684, 1025}, measured[] = {27.0, 52.7, 78.3};
  double factor[3];
  for (int i = 0; i < 3; ++i) {
    const double air = laws::vane_air_mps<double>(0.28, 0.16, rpm[i] * kPerRpm);
    factor[i] = laws::vane_nusselt<double>(0.015, 0.06, air) * 0.026 / 0.015 / measured[i];
    EXPECT_NEAR(factor[i], 1.0, 0.25) << rpm[i];
  }
  EXPECT_NEAR(factor[2] / factor[0], 1.0, 0.2);
}

// By hand: 10 m/s in channels of 15 mm, 60 mm long: Re = 9375; 0.023 (1 + 0.25^0.67) 9375^0.8
// 0.71^0.33 = 0.023 * 1.3950 * 1505.6 * 0.8931 = 43.1. 1 m/s: 1.86 (0.71 * 937.5)^(1/3) 0.25^0.33 =
// 1.86 * 8.731 * 0.6329 = 10.28.
TEST(BrakeDisc, KnowsItsVanesCorrelations) {
  EXPECT_NEAR(laws::vane_nusselt<double>(0.015, 0.06, 10), 43.1, 0.2);
  EXPECT_NEAR(laws::vane_nusselt<double>(0.015, 0.06, 1), 10.28, 0.02);
  // A disc of 0.30 m with vanes from 0.18 m: sqrt(0.09 - 0.0324) = 0.24 m, mean of in and out 0.8.
  EXPECT_NEAR(laws::vane_air_mps<double>(0.30, 0.18, 100), 100 * 0.12 * 0.8, 1e-9);
}

TEST(BrakeDisc, HasExactDerivatives) {
  using Jet = ceres::Jet<double, 3>;
  for (const double speed : {0.5, 3.0, 20.0, 60.0}) {
    const double d = 0.28, turning = speed / 0.3, still = 20, gap = 0.012, length = 0.06;
    const Jet face =
        laws::disc_face_nusselt<Jet>(Jet(d, 0), Jet(turning, 1), Jet(speed, 2), Jet(still));
    const auto differs = [](auto&& f, double x) {
      const double h = 1e-4 * x;
      return (8 * (f(x + h) - f(x - h)) - (f(x + 2 * h) - f(x - 2 * h))) / (12 * h);
    };
    const auto f = [&](double dd, double t, double v) {
      return laws::disc_face_nusselt<double>(dd, t, v, still);
    };
    const auto near = [](double got, double expected) {
      EXPECT_NEAR(got, expected, 1e-7 * std::abs(expected));
    };
    near(face.v[0], differs([&](double x) { return f(x, turning, speed); }, d));
    near(face.v[1], differs([&](double x) { return f(d, x, speed); }, turning));
    near(face.v[2], differs([&](double x) { return f(d, turning, x); }, speed));
    const Jet vane = laws::vane_nusselt<Jet>(Jet(gap, 0), Jet(length, 1), Jet(speed, 2));
    const auto v = [](double g, double l, double a) { return laws::vane_nusselt<double>(g, l, a); };
    near(vane.v[0], differs([&](double x) { return v(x, length, speed); }, gap));
    near(vane.v[1], differs([&](double x) { return v(gap, x, speed); }, length));
    near(vane.v[2], differs([&](double x) { return v(gap, length, x); }, speed));
  }
}

// In the car: the core loses heat through the vanes although it is as hot as the surface, and what
// both lose is h A (T - air) of the two places.
TEST(BrakeDisc, CoolsTheCoreThroughTheVanes) {
  const CarFiles files = test_car_files();
  Amplitudes<double> terms = default_amplitudes();
  for (const Term off : {Term::brake_radiation, Term::brake_heat_capacity}) terms[off] = 0.0;
  EXPECT_EQ(terms[Term::brake_vanes], 0.0);
  std::mt19937 random(5);
  State<double> s = random_state(random);
  for (std::size_t i = 0; i < kWheels; ++i) s[kDiscSurface + i] = s[kDiscCore + i] = 800;
  const auto rate = [&](double vanes) {
    terms[Term::brake_vanes] = vanes;
    const Car<double> car = make_car(files, test_parameters(), terms);
    State<double> out;
    Detail<double> detail;
    RoadCursors cursors;
    derivative(car, s, {}, Road(), cursors, out, detail);
    return std::pair(out, detail.wheel[0].spin_radps);
  };
  const auto [off, spin] = rate(0.0);
  const auto on = rate(1.0).first, half = rate(0.5).first;
  EXPECT_EQ(off[kDiscCore], 0.0);
  const double air = laws::vane_air_mps<double>(0.28, 0.16, spin);
  const double vane_w =
      laws::vane_nusselt<double>(0.012, 0.06, air) * 0.026 / 0.012 * 0.10 * (800 - 295);
  EXPECT_NEAR(on[kDiscCore] * 1900, -vane_w, 1e-6 * vane_w);
  EXPECT_GT(vane_w, 2000);  // some kilowatts at 40 m/s
  EXPECT_LT(vane_w, 20000);
  EXPECT_NEAR(half[kDiscCore], 0.5 * on[kDiscCore], 1e-9);
  EXPECT_NEAR(half[kDiscSurface], 0.5 * (on[kDiscSurface] + off[kDiscSurface]), 1e-9);
  Parameters<double> p = test_parameters();
  p[P::front_disc_inner_m] = 0.3;
  EXPECT_ANY_THROW(make_car(files, p, terms));
}

}  // namespace brake_disc_test
