#include "identify/reduced_car.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace identify {
namespace {

constexpr double kSmallLoad_n = 1.0;
constexpr double kMostSlip = 0.4;
constexpr int kRounds = 12;  // of lateral acceleration and load

double magic(double x, double stiffness, double most, double c, double e) {
  if (!(std::abs(most) > 1e-9)) return 0.0;
  const double bx = stiffness / (c * most) * x;
  return most * std::sin(c * std::atan(bx - e * (bx - std::atan(bx))));
}

/// cos(w[2] atan(b (own + shift))) / cos(w[2] atan(b shift)), b = w[0] cos(atan(w[1] other))
double weight(const std::array<double, 3>& w, double other, double own, double shift = 0.0) {
  const double b = w[0] / std::sqrt(1.0 + w[1] * w[1] * other * other);
  return std::cos(w[2] * std::atan(b * (own + shift))) /
         std::max(0.1, std::cos(w[2] * std::atan(b * shift)));
}

/// Longitudinal force by slip.
double fx_of(const WheelCurve& curve, const CurveInput& in, double kappa) {
  const double f = in.fz_n / curve.load_n - 1.0;
  const double most = (curve.mx[0] + curve.mx[1] * f) * in.fz_n * in.grip;
  const double stiffness = (curve.kx[0] + curve.kx[1] * f) * in.fz_n * in.stiffness;
  return weight(curve.wx, kappa, in.tan_alpha) * magic(kappa, stiffness, most, curve.cx, curve.ex);
}

double aligning(const ReducedCar& car, std::size_t axle, double fy_n, double tan_alpha) {
  const double x = tan_alpha / car.trail_slip[axle];
  return -fy_n * car.trail_m[axle] / (1.0 + x * x);
}

double moved_load(const ReducedCar& car, std::size_t a, double ay_mps2, double fy_n,
                  double vx_mps) {
  return car.transfer_mass[a] * car.mass_kg * ay_mps2 + car.transfer_force[a] * fy_n +
         car.transfer_speed[a] * car.mass_kg * ay_mps2 * vx_mps * vx_mps;
}

struct Balance {
  double ay_mps2 = 0.0, yaw_moment_nm = 0.0;
};

Balance balance(const ReducedCar& car, const PlanarState& in, double front_y_n, double rear_y_n,
                double other_nm) {
  const double q = 0.5 * car.density_kgpm3;
  const double speed = std::hypot(in.vx_mps, in.vy_mps);
  const double side_n = -q * car.side_area_m2 * speed * in.vy_mps;
  const double drag_n = -q * car.drag_area_m2 * speed * in.vy_mps;
  Balance out;
  out.ay_mps2 = (front_y_n + rear_y_n + side_n + drag_n) / car.mass_kg;
  out.yaw_moment_nm =
      (car.front_m + car.cog_behind_m) * front_y_n - (car.rear_m - car.cog_behind_m) * rear_y_n +
      (car.cog_behind_m - car.side_behind_m) * side_n + car.cog_behind_m * drag_n + other_nm;
  return out;
}

double lagged(double& state, bool begun, double steady, double vx_mps, double sigma_m,
              double step_s) {
  state = begun ? state + (steady - state) *
                              (1.0 - std::exp(-std::abs(vx_mps) / std::max(0.02, sigma_m) * step_s))
                : steady;
  return state;
}

}  // namespace

CurveForces curve_forces(const WheelCurve& curve, const CurveInput& in) {
  CurveForces out;
  if (in.fz_n < kSmallLoad_n) return out;
  const double f = in.fz_n / curve.load_n - 1.0;
  const double most = std::max(0.05, curve.mu[0] + curve.mu[1] * f + curve.mu[2] * f * f) *
                      std::max(0.1, 1.0 - curve.mu_camber * in.gamma_rad * in.gamma_rad) * in.fz_n *
                      in.grip;
  const double stiffness = curve.k[0] * curve.load_n *
                           std::sin(2.0 * std::atan(in.fz_n / (curve.k[1] * curve.load_n))) *
                           in.stiffness;
  const double x = in.tan_alpha + curve.shift_camber * in.gamma_rad + in.side * curve.shift_side;
  const double e = std::min(1.0, curve.e[0] + curve.e[1] * f);
  out.fy_n = weight(curve.wy, in.tan_alpha, in.kappa, curve.shift_kappa) *
                 magic(x, stiffness, most, curve.c, e) +
             in.fz_n * in.grip * (curve.push_camber * in.gamma_rad + in.side * curve.push_side);
  out.fx_n = fx_of(curve, in, in.kappa);
  return out;
}

double slip_for_force(const WheelCurve& curve, CurveInput in, double fx_n) {
  if (in.fz_n < kSmallLoad_n || fx_n == 0.0) return 0.0;
  const double f = in.fz_n / curve.load_n - 1.0;
  const double most = (curve.mx[0] + curve.mx[1] * f) * in.fz_n * in.grip;
  const double stiffness = (curve.kx[0] + curve.kx[1] * f) * in.fz_n * in.stiffness;
  if (!(most > 1e-9) || !(stiffness > 1e-9)) return 0.0;
  const double b = stiffness / (curve.cx * most), e = curve.ex;
  const double peak = 0.5 * std::numbers::pi / curve.cx;
  // Without the weight's own slip the formula turns round; the weight comes in by repetition.
  double kappa = 0.0, y = 0.0;
  for (int round = 0; round < 4; ++round) {
    const double g = weight(curve.wx, kappa, in.tan_alpha);
    const double ratio = g > 1e-6 ? fx_n / (most * g) : (fx_n > 0.0 ? 1.0 : -1.0);
    const double angle =
        std::abs(ratio) < 1.0 ? std::asin(ratio) / curve.cx : (ratio > 0.0 ? peak : -peak);
    const double wanted = std::tan(std::clamp(angle, -1.55, 1.55));
    if (round == 0) y = wanted;
    for (int i = 0; i < 12; ++i) {  // y - e (y - atan(y)) = wanted
      const double miss = y - e * (y - std::atan(y)) - wanted;
      y -= miss / (1.0 - e + e / (1.0 + y * y));
      if (std::abs(miss) < 1e-6 * (1.0 + std::abs(wanted))) break;  // squared by the step
    }
    const double next = std::clamp(y / b, -kMostSlip, kMostSlip);
    const bool done = std::abs(next - kappa) < 1e-7;
    kappa = next;
    if (done) break;
  }
  return kappa;
}

double relaxation_m(const WheelCurve& curve, double sigma_m, double fz_n) {
  return sigma_m * std::sin(2.0 * std::atan(std::max(0.0, fz_n) / (curve.k[1] * curve.load_n))) /
         std::sin(2.0 * std::atan(1.0 / curve.k[1]));
}

std::array<double, 2> axle_slips(const ReducedCar& car, const PlanarState& in) {
  return {
      std::tan(in.steer_rad - std::atan2(in.vy_mps + car.front_m * in.yaw_rate_radps, in.vx_mps)),
      -(in.vy_mps - car.rear_m * in.yaw_rate_radps) / in.vx_mps};
}

std::array<double, 4> wheel_angles(const ReducedCar& car, double steer_rad) {
  const double more =
      car.ackermann * steer_rad * steer_rad * car.track_m[0] / (2.0 * car.wheelbase_m);
  return {steer_rad + more, steer_rad - more, 0.0, 0.0};
}

std::array<double, 4> wheel_slips(const ReducedCar& car, const PlanarState& in) {
  std::array<double, 4> out = wheel_angles(car, in.steer_rad);
  for (std::size_t i = 0; i < 4; ++i) {
    const double x_m = i < 2 ? car.front_m : -car.rear_m;
    const double y_m = (i % 2 == 0 ? 0.5 : -0.5) * car.track_m[i / 2];
    out[i] = std::tan(out[i] - std::atan2(in.vy_mps + x_m * in.yaw_rate_radps,
                                          in.vx_mps - y_m * in.yaw_rate_radps));
  }
  return out;
}

std::array<double, 2> axle_loads(const ReducedCar& car, const PlanarState& in, double ay_mps2) {
  const double front_m = car.front_m + car.cog_behind_m, rear_m = car.wheelbase_m - front_m;
  const double along = car.mass_kg * in.ax_mps2 * car.cog_height_m / car.wheelbase_m;
  const double v2 = in.vx_mps * in.vx_mps, q = 0.5 * car.density_kgpm3 * v2;
  const double beta = std::abs(in.vy_mps) / std::max(1.0, std::abs(in.vx_mps));
  std::array<double, 2> out;
  for (std::size_t a = 0; a < 2; ++a) {
    const auto& l = car.lift_m2[a];
    const double lift = l[0] + l[1] * v2 + l[2] * in.ax_mps2 +
                        l[3] * (in.an_mps2 - car.gravity_mps2) + l[4] * beta +
                        l[5] * ay_mps2 * ay_mps2;
    out[a] =
        std::max(0.0, car.mass_kg * in.an_mps2 * (a == 0 ? rear_m : front_m) / car.wheelbase_m +
                          (a == 0 ? -along : along) + q * lift);
  }
  return out;
}

NormalShares normal_shares(double gravity_mps2, double vx_mps, double curvature_1pm, double bank,
                           double grade, double vertical_curvature_1pm) {
  const double cos_bank = 1.0 / std::sqrt(1.0 + bank * bank);
  const double cos_grade = 1.0 / std::sqrt(1.0 + grade * grade);
  const double v2 = vx_mps * vx_mps * cos_grade * cos_grade;  // of the plan
  return {gravity_mps2 * cos_bank * cos_grade, -v2 * curvature_1pm * bank * cos_bank,
          v2 * vertical_curvature_1pm * cos_grade * cos_bank};
}

namespace {

/// What the rear wheels need to know of one another.
struct RearAxle {
  const ReducedCar& car;
  const PlanarState& in;
  const std::array<CurveInput, 2>& rear;

  /// Force that brakes ask of a wheel: by load.
  double braked_n(std::size_t i) const {
    return (in.fx_n[1] - in.drive_nm / car.radius_m[1]) * rear[i].fz_n /
           std::max(kSmallLoad_n, rear[0].fz_n + rear[1].fz_n);
  }
  /// Speed of a wheel that rolls freely, rad/s.
  double rolling_radps(std::size_t i) const {
    const double ground_mps =
        in.vx_mps - (i == 0 ? 0.5 : -0.5) * car.track_m[1] * in.yaw_rate_radps;
    return ground_mps /
           (car.roll_m[0] + car.roll_m[1] * (rear[i].fz_n / car.wheel[1].load_n - 1.0));
  }
  double slip_when_moved(std::size_t i, double moved_nm) const {
    const double wanted =
        braked_n(i) + (0.5 * in.drive_nm + (i == 0 ? -moved_nm : moved_nm)) / car.radius_m[1];
    return slip_for_force(car.wheel[1], rear[i], wanted);
  }
};

RearSlips limited_slip(const RearAxle& axle, double capacity_nm) {
  const auto excess = [&](double moved_nm) {
    double speed[2];
    for (std::size_t i = 0; i < 2; ++i)
      speed[i] = axle.rolling_radps(i) * (1.0 + axle.slip_when_moved(i, moved_nm));
    return capacity_nm * std::tanh((speed[0] - speed[1]) / axle.car.stick_radps) - moved_nm;
  };
  RearSlips out;
  if (capacity_nm > 0.0) {
    // Falling through zero once: false position with halved ends (Illinois).
    double low = -capacity_nm, high = capacity_nm;
    double at_low = excess(low), at_high = excess(high);
    int side = 0;
    for (int i = 0; i < 60 && high - low > 1e-2; ++i) {
      const double middle = at_low > at_high ? (low * -at_high + high * at_low) / (at_low - at_high)
                                             : 0.5 * (low + high);
      const double at_middle = excess(middle);
      out.moved_nm = middle;
      if (std::abs(at_middle) < 1e-2) break;
      const bool up = at_middle > 0.0;
      (up ? low : high) = middle;
      (up ? at_low : at_high) = at_middle;
      if (side == (up ? 1 : -1)) (up ? at_high : at_low) *= 0.5;
      side = up ? 1 : -1;
    }
  }
  for (std::size_t i = 0; i < 2; ++i) out.kappa[i] = axle.slip_when_moved(i, out.moved_nm);
  return out;
}

RearSlips locked(const RearAxle& axle) {
  const double radius_m = axle.car.radius_m[1];
  const double mean_radps = 0.5 * (axle.rolling_radps(0) + axle.rolling_radps(1));
  RearSlips out;
  double apart_radps = 0.0;  // what the lock yields
  for (int round = 0; round < 3; ++round) {
    double low = -kMostSlip, high = kMostSlip, fx_n[2];
    for (int i = 0; i < 26; ++i) {
      const double speed = mean_radps * (1.0 + 0.5 * (low + high));
      for (std::size_t k = 0; k < 2; ++k) {
        out.kappa[k] =
            std::clamp((speed + (k == 0 ? 0.5 : -0.5) * apart_radps) / axle.rolling_radps(k) - 1.0,
                       -kMostSlip, kMostSlip);
        fx_n[k] = fx_of(axle.car.wheel[1], axle.rear[k], out.kappa[k]);
      }
      (fx_n[0] + fx_n[1] < axle.in.fx_n[1] ? low : high) = 0.5 * (low + high);
    }
    out.moved_nm = 0.5 * radius_m * ((fx_n[1] - axle.braked_n(1)) - (fx_n[0] - axle.braked_n(0)));
    apart_radps = out.moved_nm / axle.car.lock_nms;
  }
  return out;
}

}  // namespace

RearSlips rear_slips(const ReducedCar& car, const PlanarState& in,
                     const std::array<CurveInput, 2>& rear) {
  const RearAxle axle{car, in, rear};
  if (car.lock_nms > 0.0) return locked(axle);
  const double ramp = in.drive_nm > 0.0 ? car.drive_ramp : car.coast_ramp;
  return limited_slip(axle, 0.5 * (car.preload_nm + ramp * std::abs(in.drive_nm)));
}

ReducedForces single_track(const ReducedCar& car, const PlanarState& in, SlipLags* lags,
                           double step_s) {
  ReducedForces out;
  std::array<double, 2> slip = axle_slips(car, in);
  out.axle_fz_n = axle_loads(car, in, in.vx_mps * in.yaw_rate_radps);
  if (lags != nullptr) {
    for (std::size_t a = 0; a < 2; ++a)
      slip[a] = lagged(lags->axle[a], lags->begun, slip[a], in.vx_mps,
                       relaxation_m(car.axle[a], car.sigma_m[a], out.axle_fz_n[a]), step_s);
    lags->begun = true;
  }
  for (int round = 0; round < kRounds; ++round) {
    out.axle_fz_n = axle_loads(car, in, out.ay_mps2);
    double missing = 0.0;
    for (std::size_t a = 0; a < 2; ++a) {
      CurveInput at{out.axle_fz_n[a], slip[a], 0.0, 0.0, 0.0, in.grip[a], in.stiffness[a]};
      at.kappa = slip_for_force(car.axle[a], at, in.fx_n[a]);
      const CurveForces made = curve_forces(car.axle[a], at);
      out.axle_fy_n[a] = made.fy_n;
      missing += std::abs(made.fx_n - in.fx_n[a]);
    }
    const double front_y =
        out.axle_fy_n[0] * std::cos(in.steer_rad) + in.fx_n[0] * std::sin(in.steer_rad);
    out.missing_n = missing;
    // What the wheels of an axle do to yaw because their loads differ: brakes and the turned front
    // wheels by load, the engine by the differential.
    double other = 0.0;
    std::array<CurveInput, 2> rear;
    for (std::size_t a = 0; a < 2; ++a) {
      const double fz = std::max(kSmallLoad_n, out.axle_fz_n[a]);
      const double moved = std::clamp(moved_load(car, a, out.ay_mps2, out.axle_fy_n[a], in.vx_mps),
                                      -0.5 * fz, 0.5 * fz);
      const double drive_n = a == 1 ? in.drive_nm / car.radius_m[1] : 0.0;
      const double turned = a == 0 ? std::sin(in.steer_rad) : 0.0;
      other += aligning(car, a, out.axle_fy_n[a], slip[a]) +
               car.track_m[a] * moved / fz * (in.fx_n[a] - drive_n - out.axle_fy_n[a] * turned);
      if (a == 1)
        for (std::size_t i = 0; i < 2; ++i)
          rear[i] = {0.5 * fz + (i == 0 ? -moved : moved),
                     slip[1],
                     0.0,
                     0.0,
                     i == 0 ? 1.0 : -1.0,
                     in.grip[1],
                     in.stiffness[1]};
    }
    out.differential_nm = rear_slips(car, in, rear).moved_nm;
    other += car.track_m[1] * out.differential_nm / car.radius_m[1];
    const Balance b = balance(car, in, front_y, out.axle_fy_n[1], other);
    const double change = b.ay_mps2 - out.ay_mps2;
    out.ay_mps2 = b.ay_mps2;
    out.yaw_moment_nm = b.yaw_moment_nm;
    if (std::abs(change) < 1e-5) break;
  }
  return out;
}

ReducedForces double_track(const ReducedCar& car, const PlanarState& in, SlipLags* lags,
                           double step_s) {
  ReducedForces out;
  const std::array<double, 4> steer = wheel_angles(car, in.steer_rad);
  std::array<double, 4> slip = wheel_slips(car, in);
  const std::array<double, 4> steady = slip;
  const SlipLags before = lags != nullptr ? *lags : SlipLags{};
  for (int round = 0; round < kRounds; ++round) {
    out.axle_fz_n = axle_loads(car, in, out.ay_mps2);
    std::array<CurveInput, 4> at;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t a = i / 2;
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      const double moved = moved_load(car, a, out.ay_mps2, out.axle_fy_n[a], in.vx_mps);
      const double half = 0.5 * out.axle_fz_n[a];
      out.fz_n[i] = std::clamp(half - side * moved, 0.0, 2.0 * half);
      if (lags != nullptr) {
        lags->wheel[i] = before.wheel[i];
        slip[i] = lagged(lags->wheel[i], before.begun, steady[i], in.vx_mps,
                         relaxation_m(car.wheel[a], car.sigma_m[a], out.fz_n[i]), step_s);
      }
      const auto& g = car.camber[a];
      at[i] = {out.fz_n[i],
               slip[i],
               0.0,
               side * (g[0] + g[1] * out.fz_n[i]) + g[2] * out.ay_mps2,
               side,
               in.grip[a],
               in.stiffness[a]};
    }
    const RearSlips turns = rear_slips(car, in, {at[2], at[3]});
    out.differential_nm = turns.moved_nm;
    std::array<double, 2> force{}, made_x{};
    double moment = 0.0;
    out.axle_fy_n = {};
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t a = i / 2;
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      // Brakes share by load, as the front wheels here have nothing else.
      at[i].kappa =
          a == 1
              ? turns.kappa[i - 2]
              : slip_for_force(car.wheel[0], at[i],
                               in.fx_n[0] * out.fz_n[i] / std::max(kSmallLoad_n, out.axle_fz_n[0]));
      const CurveForces made = curve_forces(car.wheel[a], at[i]);
      out.fx_n[i] = made.fx_n;
      made_x[a] += made.fx_n;
      out.fy_n[i] = made.fy_n;
      const double cs = std::cos(steer[i]), ss = std::sin(steer[i]);
      force[a] += made.fy_n * cs + made.fx_n * ss;
      out.axle_fy_n[a] += made.fy_n;
      moment += aligning(car, a, made.fy_n, slip[i]);
      moment -= 0.5 * side * car.track_m[a] * (made.fx_n * cs - made.fy_n * ss);
    }
    out.missing_n = std::abs(made_x[0] - in.fx_n[0]) + std::abs(made_x[1] - in.fx_n[1]);
    const Balance b = balance(car, in, force[0], force[1], moment);
    const double change = b.ay_mps2 - out.ay_mps2;
    out.ay_mps2 = b.ay_mps2;
    out.yaw_moment_nm = b.yaw_moment_nm;
    if (std::abs(change) < 1e-5) break;
  }
  if (lags != nullptr) lags->begun = true;
  return out;
}

}  // namespace identify
