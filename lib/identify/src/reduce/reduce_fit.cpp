#include "reduce_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/least_squares.h"

namespace identify {
namespace {

using P = vehicle::Parameter;
using T = vehicle::Term;

}  // namespace

PlanarState planar_state(const CarMoment& m) {
  PlanarState out;
  out.vx_mps = m.vx_mps;
  out.vy_mps = m.vy_mps;
  out.yaw_rate_radps = m.yaw_rate_radps;
  out.steer_rad = m.steer_rad;
  out.ax_mps2 = m.ax_mps2;
  out.an_mps2 = m.an_mps2;
  for (std::size_t i = 0; i < 4; ++i) out.fx_n[i / 2] += m.wheel[i].fx_n;
  out.drive_nm = m.drive_nm;
  return out;
}

bool grips(const CarMoment& m) {
  return std::all_of(m.wheel.begin(), m.wheel.end(),
                     [](const WheelMoment& w) { return std::abs(w.kappa) <= kMostWheelSlip; });
}

ReducedCar plain_numbers(const vehicle::Car<double>& car, double fuel_kg) {
  const auto& p = car.parameters;
  ReducedCar out;
  out.fuel_kg = fuel_kg;
  out.mass_kg = p[P::chassis_mass_kg] + fuel_kg;
  out.wheelbase_m = p[P::chassis_wheelbase_m];
  out.front_m = p[P::chassis_cog_behind_front_m];
  out.rear_m = out.wheelbase_m - out.front_m;
  const double share = fuel_kg / out.mass_kg;
  out.cog_behind_m = -share * car.tank_m.x;
  out.cog_height_m = p[P::chassis_cog_height_m] + share * car.tank_m.z;
  out.yaw_inertia_kgm2 =
      p[P::chassis_yaw_inertia_kgm2] + p[P::chassis_mass_kg] * share * car.tank_m.x * car.tank_m.x;
  for (std::size_t a = 0; a < 2; ++a) {
    out.track_m[a] = p.axle(a, P::front_track_m);
    out.radius_m[a] = car.static_radius_m[a];
  }
  out.ackermann = p[P::steering_ackermann];
  out.gravity_mps2 = p[P::environment_gravity_mps2];
  out.density_kgpm3 = p[P::aero_density_kgpm3];
  out.side_area_m2 = car.terms[T::aero_drag] * p[P::aero_side_area_m2];
  out.side_behind_m = p[P::aero_side_behind_cog_m];
  out.drag_area_m2 = car.terms[T::aero_drag] * p[P::aero_drag_area_m2];
  const double slips = car.terms[T::limited_slip];
  out.preload_nm = slips * p[P::differential_preload_nm];
  out.drive_ramp = slips * p[P::differential_drive_ramp];
  out.coast_ramp = slips * p[P::differential_coast_ramp];
  out.stick_radps = p[P::differential_stick_radps];
  out.lock_nms = car.terms[T::locked_differential] * p[P::differential_lock_nms];
  return out;
}

void fit_loads(ReducedCar& car, const std::vector<CarMoment>& moments,
               std::vector<PartError>& errors) {
  for (std::size_t a = 0; a < 2; ++a) {
    Equation lift, transfer, camber;
    for (const CarMoment& m : moments) {
      const PlanarState s = planar_state(m);
      const WheelMoment &l = m.wheel[2 * a], &r = m.wheel[2 * a + 1];
      const double v2 = s.vx_mps * s.vx_mps, q = 0.5 * car.density_kgpm3 * v2;
      const double more = s.an_mps2 - car.gravity_mps2;
      lift.add({q, q * v2, q * s.ax_mps2, q * more, q * (std::abs(s.vy_mps) / s.vx_mps),
                q * (m.ay_mps2 * m.ay_mps2), car.mass_kg * s.ax_mps2 * more},
               l.fz_n + r.fz_n - axle_loads(car, s, m.ay_mps2)[a]);
      if (l.fz_n > kLeastLoad_n && r.fz_n > kLeastLoad_n)
        transfer.add({car.mass_kg * m.ay_mps2, l.fy_n + r.fy_n, car.mass_kg * m.ay_mps2 * v2,
                      car.mass_kg * m.ay_mps2 * more},
                     0.5 * (r.fz_n - l.fz_n));
      for (std::size_t i = 2 * a; i < 2 * a + 2; ++i)
        camber.add({side_of(i), side_of(i) * m.wheel[i].fz_n, m.ay_mps2}, m.wheel[i].camber_rad);
    }
    const std::vector<double> areas = linear_fit(lift);
    std::copy_n(areas.begin(), 6, car.lift_m2[a]);
    car.along_pressed[a] = areas[6];
    const std::vector<double> shares = linear_fit(transfer);
    car.transfer_mass[a] = shares[0];
    car.transfer_force[a] = shares[1];
    car.transfer_speed[a] = shares[2];
    car.transfer_pressed[a] = shares[3];
    const std::vector<double> lean = linear_fit(camber);
    std::copy(lean.begin(), lean.end(), car.camber[a]);

    ErrorSum load, across, angle;
    for (const CarMoment& m : moments) {
      const WheelMoment &l = m.wheel[2 * a], &r = m.wheel[2 * a + 1];
      load.add(l.fz_n + r.fz_n, axle_loads(car, planar_state(m), m.ay_mps2)[a]);
      if (l.fz_n > kLeastLoad_n && r.fz_n > kLeastLoad_n)
        across.add(0.5 * (r.fz_n - l.fz_n), shares[1] * (l.fy_n + r.fy_n) +
                                                car.mass_kg * m.ay_mps2 *
                                                    (shares[0] + shares[2] * m.vx_mps * m.vx_mps +
                                                     shares[3] * (m.an_mps2 - car.gravity_mps2)));
      for (std::size_t i = 2 * a; i < 2 * a + 2; ++i)
        angle.add(m.wheel[i].camber_rad,
                  side_of(i) * (lean[0] + lean[1] * m.wheel[i].fz_n) + lean[2] * m.ay_mps2);
    }
    errors.push_back(load.as(fmt::format("{} axle load", recording::kAxleNames[a]), "N"));
    errors.push_back(
        across.as(fmt::format("{} lateral load transfer", recording::kAxleNames[a]), "N"));
    errors.push_back(angle.as(fmt::format("{} inclination", recording::kAxleNames[a]), "rad"));
  }
}

void fit_radius(ReducedCar& car, const std::vector<CarMoment>& moments,
                std::vector<PartError>& errors) {
  Equation e;
  const double load_n = 0.5 * car.mass_kg * car.gravity_mps2 * car.front_m / car.wheelbase_m;
  car.wheel[1].load_n = load_n;
  for (const CarMoment& m : moments)
    for (const WheelMoment& w : {m.wheel[2], m.wheel[3]}) {
      if (std::abs(w.kappa) > 0.1 || w.fz_n < kLeastLoad_n || w.spin_radps < 1.0) continue;
      e.add({1.0, w.fz_n / load_n - 1.0}, w.ground_mps * (1.0 + w.kappa) / w.spin_radps);
    }
  const std::vector<double> found = linear_fit(e);
  std::copy(found.begin(), found.end(), car.roll_m);
  ErrorSum sum;
  for (std::size_t i = 0; i < e.wanted.size(); ++i)
    sum.add(e.wanted[i], found[0] + found[1] * e.columns[1][i]);
  errors.push_back(sum.as("rear rolling radius", "m"));
}

void fit_yaw(ReducedCar& car, const std::vector<CarMoment>& moments,
             std::vector<PartError>& errors) {
  // With the forces of the full car, so that only what they leave is the trails'.
  struct Row {
    double left_nm, full_nm;
    std::array<double, 4> fy_n, tan_alpha;
  };
  std::vector<Row> rows;
  for (const CarMoment& m : moments) {
    if (!grips(m)) continue;
    const PlanarState s = planar_state(m);
    const std::array<double, 4> slip = wheel_slips(car, s);
    double steer[4];
    control::control_wheel_angles(&car, s.steer_rad, steer);
    Row row{};
    double forces = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const WheelMoment& w = m.wheel[i];
      const double x_m = (i < 2 ? car.front_m : -car.rear_m) + car.cog_behind_m;
      const double cs = std::cos(steer[i]), ss = std::sin(steer[i]);
      forces += x_m * (w.fy_n * cs + w.fx_n * ss) -
                0.5 * side_of(i) * car.track_m[i / 2] * (w.fx_n * cs - w.fy_n * ss);
      row.fy_n[i] = w.fy_n;
      row.tan_alpha[i] = slip[i] + w.lag;
    }
    const double speed = std::hypot(s.vx_mps, s.vy_mps), q = 0.5 * car.density_kgpm3;
    forces -= q * speed * s.vy_mps *
              ((car.cog_behind_m - car.side_behind_m) * car.side_area_m2 +
               car.cog_behind_m * car.drag_area_m2);
    row.full_nm = m.yaw_moment_nm;
    row.left_nm = m.yaw_moment_nm - forces;
    rows.push_back(row);
  }
  const auto aligning = [&](const Row& row, const std::vector<double>& v) {
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = row.tan_alpha[i] / v[2 + i / 2];
      sum -= row.fy_n[i] * v[i / 2] / (1.0 + x * x);
    }
    return sum;
  };
  std::vector<Unknown> unknowns{{"front trail", 0.03, -0.1, 0.3, 0.05},
                                {"rear trail", 0.03, -0.1, 0.3, 0.05},
                                {"front slip", 0.1, 0.01, 2.0, 0.1},
                                {"rear slip", 0.1, 0.01, 2.0, 0.1}};
  least_squares(unknowns, [&](const std::vector<double>& values, std::vector<double>& left) {
    left.resize(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      left[i] = aligning(rows[i], values) - rows[i].left_nm;
  });
  std::vector<double> found;
  for (const Unknown& u : unknowns) found.push_back(u.value);
  for (std::size_t a = 0; a < 2; ++a) {
    car.trail_m[a] = found[a];
    car.trail_slip[a] = found[2 + a];
  }
  ErrorSum sum;
  for (const Row& row : rows)
    sum.add(row.full_nm, row.full_nm - row.left_nm + aligning(row, found));
  errors.push_back(sum.as("yaw moment of given forces", "N m"));
}

void fit_relaxation(ReducedCar& car, const std::vector<std::vector<CarMoment>>& sweeps,
                    std::vector<PartError>& errors) {
  for (std::size_t a = 0; a < 2; ++a) {
    ErrorSum sum;
    std::vector<Unknown> sigma{{"sigma", 0.3, 0.02, 1.5, 1.0}};
    least_squares(sigma, [&](const std::vector<double>& values, std::vector<double>& left) {
      sum = {};
      left.clear();
      car.sigma_m[a] = values[0];
      for (const auto& sweep : sweeps) {
        control::control_lags lag{};
        double before_s = 0.0;
        for (const CarMoment& m : sweep) {
          const PlanarState s = planar_state(m);
          CurveInput at;
          at.fz_n = axle_loads(car, s, m.ay_mps2)[a];
          at.tan_alpha = control::control_lagged(
              &lag.axle[a], lag.begun, axle_slips(car, s)[a], s.vx_mps,
              control::control_relaxation_m(&car.axle[a], car.sigma_m[a], at.fz_n),
              m.time_s - before_s);
          lag.begun = 1;
          before_s = m.time_s;
          at.kappa = slip_for_force(car.axle[a], at, s.fx_n[a]);
          const double full_n = m.wheel[2 * a].fy_n + m.wheel[2 * a + 1].fy_n,
                       fy_n = curve_forces(car.axle[a], at).fy_n;
          sum.add(full_n, fy_n);
          left.push_back(fy_n - full_n);
        }
      }
    });
    errors.push_back(
        sum.as(fmt::format("{} axle in swept sines, side force", recording::kAxleNames[a]), "N"));
  }
}

void judge_differential(const ReducedCar& car, const std::vector<CarMoment>& moments,
                        std::vector<PartError>& errors) {
  ErrorSum out;
  for (const CarMoment& m : moments) {
    bool before_peak = true;  // beyond it a wheel is on its way to spin or to lock
    for (const std::size_t i : {2u, 3u})
      before_peak =
          before_peak && std::abs(m.wheel[i].kappa) < 0.1 && m.wheel[i].fz_n > kLeastLoad_n;
    if (!before_peak) continue;
    const ReducedForces f = double_track(car, planar_state(m));
    out.add(m.differential_nm, f.differential_nm);
  }
  if (out.of > 0.0) errors.push_back(out.as("torque that the differential moves", "N m"));
}

double steady_limit(const ReducedCar& car, PlanarState in, bool two_tracks, double most_rad) {
  constexpr double kStep_rad = 0.008;
  const double most_missing_n = 0.01 * car.mass_kg * in.an_mps2;
  const auto at = [&](double front_rad, double rear_rad) {
    ReducedForces out;
    for (int round = 0; round < 3; ++round) {  // the yaw rate belongs to the lateral acceleration
      in.vy_mps = -std::tan(rear_rad) * in.vx_mps + car.rear_m * in.yaw_rate_radps;
      in.steer_rad =
          front_rad + std::atan((in.vy_mps + car.front_m * in.yaw_rate_radps) / in.vx_mps);
      out = two_tracks ? double_track(car, in) : single_track(car, in);
      const double yaw_rate = out.ay_mps2 / in.vx_mps;
      const bool settled = std::abs(yaw_rate - in.yaw_rate_radps) < 1e-4;
      in.yaw_rate_radps = yaw_rate;
      if (settled) break;
    }
    return out;
  };
  // One slip angle grows, the other is the one without yaw moment; both ways, as either axle may
  // be the first at its limit.
  double most = 0.0;
  for (const bool front_grows : {true, false}) {
    in.yaw_rate_radps = 0.0;
    double other = 0.0, most_n = 0.0;
    const int steps = static_cast<int>(std::ceil(most_rad / kStep_rad));
    for (int step = 1; step <= steps; ++step) {
      const double grows = most_rad * step / steps;
      const double sign = front_grows ? 1.0 : -1.0;  // of the moment over the growing angle
      double low = std::max(-0.02, other - 0.03), high = std::min(most_rad, other + 0.05);
      ReducedForces found;
      const auto moment = [&](double x) {
        found = front_grows ? at(grows, x) : at(x, grows);
        return sign * found.yaw_moment_nm;
      };
      double at_low = moment(low), at_high = moment(high);
      if (at_low < 0.0 || at_high > 0.0) {
        other = at_low < 0.0 ? low : high;  // no balance here: may come back
        continue;
      }
      for (int i = 0; i < 14 && high - low > 2e-5; ++i) {
        other =
            i % 3 == 2 ? 0.5 * (low + high) : (low * -at_high + high * at_low) / (at_low - at_high);
        const double m = moment(other);
        (m > 0.0 ? low : high) = other;
        (m > 0.0 ? at_low : at_high) = m;
      }
      const double force_n = found.axle_fy_n[front_grows ? 0 : 1];
      if (force_n < kPastPeak * most_n) break;  // from here on the car slides
      most_n = std::max(most_n, force_n);
      if (found.missing_n < most_missing_n) most = std::max(most, found.ay_mps2);
    }
  }
  return most;
}

}  // namespace identify
