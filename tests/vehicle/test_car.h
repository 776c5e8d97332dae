// A car for the tests: round numbers, every map given, so that every term has something to do.
#pragma once

#include <random>

#include "tyre_files.h"
#include "vehicle/step.h"

inline vehicle::CarFiles test_car_files() {
  vehicle::CarFiles files;
  files.tyre[0] = files.tyre[1] = vehicle::parse_tyre(test_tyre_text(), "test tyre").coefficients;
  for (vehicle::TyreCoefficients& t : files.tyre) {  // turn slip, of a public sample file
    t.pdxp1 = t.pdyp1 = 0.4;
    t.pkyp1 = t.phyp1 = t.qdrp1 = 1.0;
    t.phyp2 = 0.15;
    t.phyp4 = -4.0;
    t.pecp1 = 0.5;
    t.qdtp1 = 10.0;
    t.qcrp1 = 0.2;
    t.qcrp2 = t.qbrp1 = 0.1;
  }
  files.engine_torque_nm.x = {0, 100, 300, 600, 800, 900};
  files.engine_torque_nm.y = {0, 0.5, 1};
  files.engine_torque_nm.z = {0,   20,  40,  -10, 80,  160, -20, 120, 260,
                              -40, 160, 340, -55, 150, 320, -60, 100, 250};
  files.drag_factor = {{0.0, 0.06}, {0.0, 0.09}, {0.9, 1.0, 1.0, 1.1}};
  files.front_lift_factor = {{0.0, 0.06}, {0.0, 0.09}, {1.2, 1.25, 0.8, 0.85}};
  files.rear_lift_factor = {{0.0, 0.06}, {0.0, 0.09}, {1.1, 0.9, 1.15, 0.95}};
  files.yaw_drag_factor = {{0.0, 0.5}, {1.0, 1.3}};
  files.yaw_lift_factor = {{0.0, 0.5}, {1.0, 0.6}};
  files.wake_drag_factor = {{5.0, 40.0}, {-3.0, 0.0, 3.0}, {1.0, 0.6, 1.0, 1.0, 0.95, 1.0}};
  files.wake_lift_factor = {{5.0, 40.0}, {-3.0, 0.0, 3.0}, {1.0, 0.7, 1.0, 1.0, 0.97, 1.0}};
  files.pad_friction = {{0.0, 1e7}, {300, 600, 1000}, {0.35, 0.45, 0.40, 0.33, 0.43, 0.36}};
  return files;
}

/// All terms on that can be on together, and wind.
inline vehicle::Parameters<double> test_parameters() {
  vehicle::Parameters<double> p = vehicle::default_parameters();
  p[vehicle::Parameter::environment_wind_mps] = 3.0;
  p[vehicle::Parameter::environment_wind_heading_rad] = 0.7;
  p[vehicle::Parameter::brake_fade_1pmj] = 0.2;
  p[vehicle::Parameter::tyre_warm_up_loss] = 0.1;
  return p;
}

/// The same tyre without the shifts and camber effects that make a straight running tyre pull.
inline vehicle::TyreCoefficients symmetric_tyre() {
  vehicle::TyreCoefficients t = vehicle::parse_tyre(test_tyre_text(), "test tyre").coefficients;
  t.phx1 = t.pvx1 = t.phy1 = t.phy2 = t.pvy1 = t.pvy2 = 0.0;
  t.rhx1 = t.rhy1 = t.rvy1 = 0.0;
  t.pey3 = t.pex4 = 0.0;
  t.rby3 = 0.0;
  t.qv1 = 0.0;
  return t;
}

/// A state somewhere in the middle of driving: everything moves, all wheels are loaded.
inline vehicle::State<double> random_state(std::mt19937& random) {
  const auto around = [&](double middle, double width) {
    return middle + width * (2.0 * static_cast<double>(random() % 100001) / 1e5 - 1.0);
  };
  vehicle::State<double> s{};
  s[vehicle::kX] = around(0, 100);
  s[vehicle::kY] = around(0, 100);
  s[vehicle::kZ] = around(0.27, 0.003);
  s[vehicle::kRoll] = around(0, 0.01);
  s[vehicle::kPitch] = around(0, 0.005);
  s[vehicle::kYaw] = around(0, 3);
  s[vehicle::kVx] = around(40, 20);
  s[vehicle::kVy] = around(0, 1.5);
  s[vehicle::kVz] = around(0, 0.1);
  s[vehicle::kRollRate] = around(0, 0.2);
  s[vehicle::kPitchRate] = around(0, 0.2);
  s[vehicle::kYawRate] = around(0, 0.5);
  for (std::size_t i = 0; i < vehicle::kWheels; ++i) {
    s[vehicle::kTravel + i] = around(0.012, 0.025);
    s[vehicle::kTravelRate + i] = around(0, 0.2);
    s[vehicle::kSpin + i] = s[vehicle::kVx] / 0.29 * around(1, 0.05);
    s[vehicle::kSlipX + i] = around(0, 0.02);
    s[vehicle::kSlipY + i] = around(0, 0.02);
    s[vehicle::kTyre + i] = around(350, 50);
    s[vehicle::kDiscSurface + i] = around(600, 250);
    s[vehicle::kDiscCore + i] = around(500, 150);
  }
  s[vehicle::kEngine] = around(500, 300);
  s[vehicle::kBoost] = around(0.5, 0.5);
  s[vehicle::kFuel] = around(40, 20);
  s[vehicle::kPadHeat] = 1e6;
  s[vehicle::kTyreWarmth] = 0.4;
  s[vehicle::kManifold] = 1.2e5;
  s[vehicle::kCharge] = 1.9e5;
  s[vehicle::kExhaust] = 2.1e5;
  s[vehicle::kTurbo] = 13000;
  return s;
}

inline vehicle::Inputs<double> random_inputs(std::mt19937& random) {
  const auto share = [&] { return static_cast<double>(random() % 100001) / 1e5; };
  vehicle::Inputs<double> in;
  in.steer_rad = 0.2 * (share() - 0.5);
  in.throttle = share();
  for (double& pressure : in.brake_pa) pressure = 4e6 * share();
  in.gear = 1 + static_cast<int>(random() % 6);
  in.opponent = true;
  in.wake_x_m = 10 + 20 * share();
  in.wake_y_m = 2 * share() - 1;
  return in;
}
