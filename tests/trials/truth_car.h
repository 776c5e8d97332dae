// The second car of the blind trials: a planar double-track model of its own. It shares nothing
// with lib/vehicle: brush tyres, fourth-order Runge-Kutta, a road that is a formula. The third car
// (truth_car_electric.h) is another one behind the same functions.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "electric.h"

namespace trials {

inline constexpr double kGravity = 9.81;

/// A closed track in polar form with hills and banking as sums of sines.
struct Track {
  double length_m = 0.0;
  std::vector<double> x, y, heading, curvature;  ///< nodes 1 m apart (step_m), closed
  double step_m = 1.0;
  std::array<double, 3> hill{}, hill_phase{};
  double bank_base = 0.0;
  double lean_m = 0.5;  ///< banking into a turn, per its curvature
  /// Short unevenness on part of the width: cosine waves, or kerb teeth with flanks of an eighth.
  struct Feature {
    double begin_m, end_m, right_m, left_m, height_m, wave_m;
    bool teeth;
  };
  std::vector<Feature> feature;
  double shift_m =
      0.0;  ///< heights and banking lie this much further along than the reference line says

  struct Point {
    double x, y, heading, curvature;
  };
  Point at(double s) const;
  double height(double s) const;
  double grade(double s) const;
  double bank(double s) const;
  double vertical(double s) const;
  double rough(double s, double v) const;  ///< of the features
};
Track make_track(double radius_m, double a2, double a3, double a5, double phase);

/// What the simulation will not know about. An amount of 0 is the car without it; that of a term
/// which every tyre has (load sensitivity, combined slip, relaxation) is a factor on what this car
/// has.
struct Effect {
  std::string mechanism, channel;
  double amount = 0.0;
  double begin_m = 0.0, end_m = 0.0;  ///< of road effects
  double extra = 0.0;                 ///< rise time, direction, ...
};

struct TruthCar {
  double mass = 740, a = 1.62, b = 1.38, h = 0.29, inertia = 950, track_f = 1.58, track_r = 1.54;
  double mu_f = 1.55, mu_r = 1.6, mu_load = 0.12, c_f = 24, c_r = 27,
         ck = 30;  ///< per nominal load
  double load_f = 3500, load_r = 4000;
  double roll_front = 0.55;
  double drag = 0.95, lift_f = 1.0, lift_r = 1.5, density = 1.2, rolling = 0.013;
  double torque = 300, torque_peak = 560, torque_width = 700, engine_drag = 25;
  double engine_inertia = 0.09, wheel_inertia = 0.9, radius_f = 0.318, radius_r = 0.32,
         final_drive = 3.0;
  std::array<double, 6> ratio{2.9, 2.1, 1.65, 1.36, 1.16, 1.02};
  double brake_f = 2.0e-4 * 4, brake_r = 1.25e-4 * 4;  ///< N m per Pa and axle
  double efficiency = 0.95;
  double relaxation_f = 0.22, relaxation_r = 0.25;  ///< m
  double camber = 0.0;                              ///< rad, tops leaning inwards
  std::vector<Effect> effects;
  std::optional<Electric> electric;  ///< what makes it the third car; none: the second

  double engine_nm(double omega, double throttle) const;
};

/// x, y, yaw, vx, vy, r, front wheels, rear left, rear right, boost, warmth, heat, load transfers x
/// y, lagged slips front rear, time. The third car uses more and some of them otherwise
/// (truth_car_electric.h).
using State = std::array<double, 31>;
struct Commands {
  double steer = 0, throttle = 0, brake_pa = 0;
  int gear = 3;
};
/// What a tyre does, along and across its wheel, and the slips that it feels.
struct Tyre {
  double fx = 0, fy = 0, fz = 0, kappa = 0, tan_alpha = 0;
};
struct Output {
  double ax = 0, ay = 0, az = 0, fz_front = 0, fz_rear = 0, s = 0, v = 0;
  std::array<Tyre, 4> tyre{};  ///< front left, front right, rear left, rear right
};

/// Banking of the true road: the track's and what effects add.
double true_bank(const TruthCar& car, const Track& track, double s);

/// One millisecond. `s_m` is the place on the track, moved on.
void advance(const TruthCar& car, const Track& track, State& state, const Commands& c, double& s_m,
             Output* out);

/// Where (x, y) lies: arc length near `s_m` and offset to the left.
std::pair<double, double> project(const Track& track, double x, double y, double s_m);

}  // namespace trials
