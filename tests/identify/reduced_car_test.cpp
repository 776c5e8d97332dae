// The formulas of a reduced car against numbers worked out by hand.
#include "identify/reduced_car.h"

#include <gtest/gtest.h>

#include <cmath>

namespace reduced_car_test {

using identify::CurveInput, identify::PlanarState, identify::ReducedCar, identify::WheelCurve;

WheelCurve curve(double load_n) {
  return {load_n,
          {1.5, 0.0, 0.0},
          {8.0, 4.0, 1.0},
          {9.0, 5.0, 1.0},
          {20.0, 1.0},
          {0.0, 0.0},
          {1.6, 0.0},
          {25.0, 0.0},
          0.0,
          1.5,
          1.6,
          -0.5,
          0.0,
          0.0,
          0.0,
          0.0,
          0.0};
}

/// A tonne on four equal tyres, mass in the middle, no air, no roll.
ReducedCar plain() {
  ReducedCar car;
  car.mass_kg = 1000.0;
  car.yaw_inertia_kgm2 = 1500.0;
  car.wheelbase_m = 3.0;
  car.front_m = car.rear_m = 1.5;
  car.cog_height_m = 0.5;
  car.density_kgpm3 = 0.0;
  for (int a = 0; a < 2; ++a) {
    car.track_m[a] = 1.5;
    car.radius_m[a] = 0.3;
    car.wheel[a] = curve(2500.0);
    car.axle[a] = curve(5000.0);
  }
  car.roll_m[0] = 0.3;
  return car;
}

TEST(ReducedCar, CurveHasItsStiffnessAndItsPeak) {
  const WheelCurve c = curve(2500.0);
  CurveInput in;
  in.fz_n = 2500.0;
  in.tan_alpha = 1e-6;
  EXPECT_NEAR(identify::curve_forces(c, in).fy_n / 1e-6, 20.0 * 2500.0, 1.0);  // sin(2 atan 1) = 1
  double most = 0.0;
  for (in.tan_alpha = 0.0; in.tan_alpha < 0.6; in.tan_alpha += 0.001)
    most = std::max(most, identify::curve_forces(c, in).fy_n);
  EXPECT_NEAR(most, 1.5 * 2500.0, 1.0);
  in.tan_alpha = 0.0;
  in.kappa = 1e-6;
  EXPECT_NEAR(identify::curve_forces(c, in).fx_n / 1e-6, 25.0 * 2500.0, 1.0);
  in.fz_n = 0.0;
  EXPECT_EQ(identify::curve_forces(c, in).fx_n, 0.0);
}

TEST(ReducedCar, SlipForAForceMakesIt) {
  const WheelCurve c = curve(2500.0);
  for (const double tan_alpha : {0.0, 0.05, -0.1})
    for (const double fx : {-2500.0, -500.0, 300.0, 2000.0}) {
      CurveInput in;
      in.fz_n = 3000.0;
      in.tan_alpha = tan_alpha;
      in.kappa = identify::slip_for_force(c, in, fx);
      EXPECT_NEAR(identify::curve_forces(c, in).fx_n, fx, 0.005 * std::abs(fx)) << tan_alpha;
      EXPECT_GT(in.kappa * fx, 0.0);
    }
  CurveInput in;
  in.fz_n = 3000.0;
  in.kappa = identify::slip_for_force(c, in, 1e5);  // more than there is: the largest
  EXPECT_NEAR(identify::curve_forces(c, in).fx_n, 1.6 * 3000.0, 1.0);
}

TEST(ReducedCar, LoadsAreThoseOfStatics) {
  const ReducedCar car = plain();
  PlanarState in;
  in.vx_mps = 20.0;
  in.an_mps2 = 10.0;
  in.ax_mps2 = 3.0;
  const auto fz = identify::axle_loads(car, in, 0.0);
  EXPECT_NEAR(fz[0], 5000.0 - 500.0, 1e-9);  // m ax h / L = 1000 * 3 * 0.5 / 3
  EXPECT_NEAR(fz[1], 5000.0 + 500.0, 1e-9);
}

TEST(ReducedCar, RoadPressesByGravityBankAndCurvature) {
  // A banked turn at the speed at which nothing is felt sideways: an = g / cos(bank).
  const double bank = 0.4, radius = 50.0, g = 9.81;
  const double v = std::sqrt(g * bank * radius);
  // A left turn leans to the left: the slope upwards to the left is negative.
  using identify::control::control_normal_mps2;
  EXPECT_NEAR(control_normal_mps2(g, v, 1.0 / radius, -bank, 0.0, 0.0),
              g * std::sqrt(1.0 + bank * bank), 1e-9);
  EXPECT_NEAR(control_normal_mps2(g, 30.0, 0.0, 0.0, 0.0, 0.005), g + 4.5, 1e-12);
  EXPECT_NEAR(control_normal_mps2(g, 30.0, 0.0, 0.0, 0.75, 0.0), 0.8 * g, 1e-12);
}

TEST(ReducedCar, NeutralCarTurnsWithoutYawMoment) {
  const ReducedCar car = plain();
  PlanarState in;
  in.vx_mps = 20.0;
  in.an_mps2 = 10.0;
  in.yaw_rate_radps = 0.2;
  const double slip = 4000.0 / 2.0 / (20.0 * 5000.0);  // m v r / 2 over the axle's stiffness
  in.vy_mps = -std::tan(slip) * in.vx_mps + 1.5 * in.yaw_rate_radps;
  in.steer_rad = slip + std::atan((in.vy_mps + 1.5 * in.yaw_rate_radps) / in.vx_mps);
  for (const auto& f : {identify::single_track(car, in), identify::double_track(car, in)}) {
    EXPECT_NEAR(f.ay_mps2, 4.0, 0.12);  // the curves bend a little
    EXPECT_NEAR(f.yaw_moment_nm, 0.0, 30.0);
    EXPECT_NEAR(f.missing_n, 0.0, 1e-6);
  }
}

TEST(ReducedCar, LimitIsThatOfFriction) {
  PlanarState in;
  in.vx_mps = 25.0;
  in.an_mps2 = 10.0;
  // Small steering angles: nearly mu an.
  EXPECT_NEAR(identify::steady_limit(plain(), in, false), 15.0, 0.1);
  EXPECT_NEAR(identify::steady_limit(plain(), in, true), 15.0, 0.1);
  in.fx_n[0] = -20000.0;  // more than the tyres have
  EXPECT_EQ(identify::steady_limit(plain(), in, true), 0.0);
}

TEST(ReducedCar, DifferentialsMoveWhatTheyCan) {
  ReducedCar car = plain();
  PlanarState in;
  in.vx_mps = 20.0;
  in.yaw_rate_radps = 0.4;
  const auto moved_nm = [&] {
    const double fz_n[] = {2500.0, 2500.0}, tan_alpha[] = {0.0, 0.0};
    double kappa[2];
    return identify::control::control_rear_slips(&car, &in, fz_n, tan_alpha, kappa);
  };
  EXPECT_EQ(moved_nm(), 0.0);  // open
  car.preload_nm = 60.0;
  car.drive_ramp = 0.4;
  car.stick_radps = 0.2;
  in.drive_nm = 100.0;
  in.fx_n[1] = 100.0 / 0.3;
  // In a left turn the left wheel is the slower one: torque goes to it, (60 + 0.4 * 100) / 2.
  EXPECT_NEAR(moved_nm(), -50.0, 2.0);
  car.preload_nm = car.drive_ramp = 0.0;
  car.lock_nms = 1e6;
  in.drive_nm = in.fx_n[1] = 0.0;
  // Locked: the wheels turn alike, so slips differ by r t / v; small slips: force 25 fz slip each.
  in.yaw_rate_radps = 0.02;
  const double slip = 0.5 * 0.02 * 1.5 / 20.0;
  EXPECT_NEAR(moved_nm(), -25.0 * 2500.0 * slip * 0.3, 0.2);
}

TEST(ReducedCar, SlipsFollowOverTheRelaxationLength) {
  ReducedCar car = plain();
  car.sigma_m[0] = car.sigma_m[1] = 0.5;
  PlanarState in;
  in.vx_mps = 20.0;
  in.an_mps2 = 10.0;
  identify::SlipLags lags{};
  identify::single_track(car, in, &lags, 0.0);
  in.steer_rad = 0.01;
  const double whole = identify::single_track(car, in).axle_fy_n[0];
  double fy = 0.0;
  for (int k = 0; k < 25; ++k) fy = identify::single_track(car, in, &lags, 0.001).axle_fy_n[0];
  EXPECT_NEAR(fy / whole, 1.0 - std::exp(-1.0), 0.01);  // 25 ms at 20 m/s: 0.5 m
}

}  // namespace reduced_car_test
