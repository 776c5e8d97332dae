// A car for planning and control: few formulas, few numbers, nothing that has to be integrated but
// the planar motion.
//
// Axes: x forward along the road, y left, normal up. Slip angles and side forces: positive to the
// left. Types and formulas are C text (control_*.inc), read as C++ here: the same lines that
// control_header() writes.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace identify {

namespace control {
#include "identify/control_car.inc"
#include "identify/control_double_track.inc"
#include "identify/control_single_track.inc"
}  // namespace control

using WheelCurve = control::control_curve;
using ReducedForces = control::control_forces;
using SlipLags = control::control_lags;  ///< {} before the first use

/// All numbers of a reduced car.
struct ReducedCar : control::control_car {
  ReducedCar() : control::control_car{} {
    gravity_mps2 = 9.80665;
    density_kgpm3 = 1.2;
    trail_slip[0] = trail_slip[1] = 0.1;
    stick_radps = 1.0;
  }
};

/// Where the car is in the plane and what presses it.
struct PlanarState : control::control_state {
  PlanarState() : control::control_state{} {
    an_mps2 = 9.80665;
    grip[0] = grip[1] = stiffness[0] = stiffness[1] = 1.0;
  }
};

/// gamma: inclination as in tyre files; side: 1 left, -1 right wheel; an axle has neither.
struct CurveInput {
  double fz_n = 0.0, tan_alpha = 0.0, kappa = 0.0;
  double gamma_rad = 0.0, side = 0.0;
};
struct CurveForces {
  double fx_n = 0.0, fy_n = 0.0;
};
inline CurveForces curve_forces(const WheelCurve& curve, const CurveInput& in) {
  CurveForces out;
  control::control_curve_forces(&curve, in.fz_n, in.tan_alpha, in.kappa, in.gamma_rad, in.side, 1.0,
                                1.0, &out.fx_n, &out.fy_n);
  return out;
}

/// The slip of least size that makes `fx_n` at that slip angle; where the wheel cannot, the slip of
/// its largest force.
inline double slip_for_force(const WheelCurve& curve, const CurveInput& in, double fx_n) {
  return control::control_slip_for_force(&curve, in.fz_n, in.tan_alpha, 1.0, 1.0, fx_n);
}

/// Tangents of the kinematic slip angles of the axles (their middles) and of the wheels, toe left
/// out: that is in the curves.
inline std::array<double, 2> axle_slips(const ReducedCar& car, const PlanarState& in) {
  std::array<double, 2> out;
  control::control_axle_slips(&car, &in, out.data());
  return out;
}
inline std::array<double, 4> wheel_slips(const ReducedCar& car, const PlanarState& in) {
  std::array<double, 4> out;
  control::control_wheel_slips(&car, &in, out.data());
  return out;
}

/// Load of the axles at a lateral acceleration.
inline std::array<double, 2> axle_loads(const ReducedCar& car, const PlanarState& in,
                                        double ay_mps2) {
  std::array<double, 2> out;
  control::control_axle_loads(&car, &in, ay_mps2, out.data());
  return out;
}

/// Steady answers; with `lags` and a step, the slip angles follow with their relaxation lengths.
inline ReducedForces single_track(const ReducedCar& car, const PlanarState& in,
                                  SlipLags* lags = nullptr, double step_s = 0.0) {
  SlipLags none{};
  return control::control_single_track_lagged(&car, &in, lags ? lags : &none, step_s);
}
inline ReducedForces double_track(const ReducedCar& car, const PlanarState& in,
                                  SlipLags* lags = nullptr, double step_s = 0.0) {
  SlipLags none{};
  return control::control_double_track_lagged(&car, &in, lags ? lags : &none, step_s);
}

/// Largest steady lateral acceleration, without yaw moment, at this speed, load and longitudinal
/// forces: `in` without its planar motion. Slip angles up to `most_rad` are looked at, those beyond
/// the largest side force of the axle that leads are not; 0: the tyres do not have the longitudinal
/// forces.
double steady_limit(const ReducedCar& car, PlanarState in, bool two_tracks, double most_rad = 0.25);

}  // namespace identify
