#include "identify/reduced_car.h"

#include <bit>

#include "control_car.h"

namespace identify {
namespace {

// The C structs have the same numbers in the same order.
control::control_curve c_of(const WheelCurve& curve) {
  return std::bit_cast<control::control_curve>(curve);
}
control::control_car c_of(const ReducedCar& car) {
  return std::bit_cast<control::control_car>(car);
}
control::control_state c_of(const PlanarState& in) {
  return std::bit_cast<control::control_state>(in);
}

using Track = control::control_forces (*)(const control::control_car*,
                                          const control::control_state*, control::control_lags*,
                                          double);

ReducedForces by_track(Track track, const ReducedCar& car, const PlanarState& in, SlipLags* lags,
                       double step_s) {
  const control::control_car p = c_of(car);
  const control::control_state state = c_of(in);
  auto c_lags = lags ? std::bit_cast<control::control_lags>(*lags) : control::control_no_lags();
  const auto out = std::bit_cast<ReducedForces>(track(&p, &state, &c_lags, step_s));
  if (lags != nullptr) *lags = std::bit_cast<SlipLags>(c_lags);
  return out;
}

}  // namespace

CurveForces curve_forces(const WheelCurve& curve, const CurveInput& in) {
  CurveForces out;
  const control::control_curve c = c_of(curve);
  control::control_curve_forces(&c, in.fz_n, in.tan_alpha, in.kappa, in.gamma_rad, in.side, in.grip,
                                in.stiffness, &out.fx_n, &out.fy_n);
  return out;
}

double slip_for_force(const WheelCurve& curve, CurveInput in, double fx_n) {
  const control::control_curve c = c_of(curve);
  return control::control_slip_for_force(&c, in.fz_n, in.tan_alpha, in.grip, in.stiffness, fx_n);
}

double relaxation_m(const WheelCurve& curve, double sigma_m, double fz_n) {
  const control::control_curve c = c_of(curve);
  return control::control_relaxation_m(&c, sigma_m, fz_n);
}

std::array<double, 2> axle_slips(const ReducedCar& car, const PlanarState& in) {
  const control::control_car p = c_of(car);
  const control::control_state state = c_of(in);
  std::array<double, 2> out{};
  control::control_axle_slips(&p, &state, out.data());
  return out;
}

std::array<double, 4> wheel_angles(const ReducedCar& car, double steer_rad) {
  const control::control_car p = c_of(car);
  std::array<double, 4> out{};
  control::control_wheel_angles(&p, steer_rad, out.data());
  return out;
}

std::array<double, 4> wheel_slips(const ReducedCar& car, const PlanarState& in) {
  const control::control_car p = c_of(car);
  const control::control_state state = c_of(in);
  std::array<double, 4> out{};
  control::control_wheel_slips(&p, &state, out.data());
  return out;
}

std::array<double, 2> axle_loads(const ReducedCar& car, const PlanarState& in, double ay_mps2) {
  const control::control_car p = c_of(car);
  const control::control_state state = c_of(in);
  std::array<double, 2> out{};
  control::control_axle_loads(&p, &state, ay_mps2, out.data());
  return out;
}

NormalShares normal_shares(double gravity_mps2, double vx_mps, double curvature_1pm, double bank,
                           double grade, double vertical_curvature_1pm) {
  std::array<double, 3> share{};
  control::control_normal_shares(gravity_mps2, vx_mps, curvature_1pm, bank, grade,
                                 vertical_curvature_1pm, share.data());
  return {share[0], share[1], share[2]};
}

RearSlips rear_slips(const ReducedCar& car, const PlanarState& in,
                     const std::array<CurveInput, 2>& rear) {
  const control::control_car p = c_of(car);
  const control::control_state state = c_of(in);
  const double fz_n[] = {rear[0].fz_n, rear[1].fz_n};
  const double tan_alpha[] = {rear[0].tan_alpha, rear[1].tan_alpha};
  RearSlips out;
  out.moved_nm = control::control_rear_slips(&p, &state, fz_n, tan_alpha, out.kappa.data());
  return out;
}

ReducedForces single_track(const ReducedCar& car, const PlanarState& in, SlipLags* lags,
                           double step_s) {
  return by_track(control::control_single_track_lagged, car, in, lags, step_s);
}

ReducedForces double_track(const ReducedCar& car, const PlanarState& in, SlipLags* lags,
                           double step_s) {
  return by_track(control::control_double_track_lagged, car, in, lags, step_s);
}

double ellipse_radius(const std::array<double, 6>& ellipse, double ax_mps2, double ay_mps2) {
  return control::control_ellipse_radius(ellipse.data(), ax_mps2, ay_mps2);
}

}  // namespace identify
