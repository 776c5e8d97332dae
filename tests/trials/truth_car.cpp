#include "truth_car.h"

#include <algorithm>
#include <numbers>

#include "effects.h"
#include "truth_car_electric.h"

namespace trials {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// Brush tyre with parabolic pressure: forces over combined theoretical slip.
void brush(double fz, double mu, double cx, double cy, double kappa, double tan_alpha, double& fx,
           double& fy) {
  const double sx = kappa / (1 + kappa), sy = tan_alpha / (1 + kappa);
  const double gx = cx * sx, gy = cy * sy, g = std::hypot(gx, gy);
  if (g < 1e-9 || fz <= 0) {
    fx = fy = 0;
    return;
  }
  const double t = g / (3 * mu * fz);
  const double f = t >= 1 ? mu * fz : mu * fz * (3 * t - 3 * t * t + t * t * t);
  fx = f * gx / g;
  fy = -f * gy / g;
}

void rates(const TruthCar& car, const Track& track, const State& x, const Commands& c, double s,
           const Warp& warped, State& d, Output* out) {
  const double vx = std::max(3.0, x[3]), vy = x[4], r = x[5];
  const RoadBelow road = road_below(car, track, x, s, vx, warped);
  const double grade = road.grade, bank = road.bank, plus = road.plus, grip = road.grip;
  const double wheelbase = car.a + car.b;
  double mass = car.mass - amount(car, "vehicle.fuel_burn") * x[16];
  mass *= 1 + amount(car, "parameter.mass");

  const auto [air_x, air_y] = air_past(car, x, vx, vy);
  const double q = 0.5 * car.density * air_x * std::hypot(air_x, air_y);
  const double drag = q * car.drag * factor(car, "vehicle.aero_drag") *
                      (1 + amount(car, "parameter.drag")),
               side_air = 0.5 * car.density * 1.2 * std::hypot(air_x, air_y) * air_y;
  const double down = factor(car, "vehicle.aero_downforce") *
                      (1 + amount(car, "parameter.downforce")) *
                      (1 - amount(car, "vehicle.aero_ride_height") * (1 - std::exp(-q / 1500)));
  const double front = mass * plus * car.b / wheelbase + q * car.lift_f * down - x[12];
  const double rear = mass * plus * car.a / wheelbase + q * car.lift_r * down + x[12];
  const double tf = x[13] * car.roll_front / car.track_f,
               tr = x[13] * (1 - car.roll_front) / car.track_r;

  double torque = car.engine_nm(0.5 * (x[7] + x[8]) *
                                    car.ratio[static_cast<std::size_t>(std::max(1, c.gear) - 1)] *
                                    car.final_drive,
                                c.throttle);
  torque *= 1 + amount(car, "parameter.engine_torque") * (torque > 0 ? 1 : 0);
  for (const Effect& e : car.effects)
    if (e.mechanism == "outside.misfire" && std::fmod(x[16], 23.0) < 2.0)
      torque *= 1 - e.amount * c.throttle;
  d.fill(0);
  for (const Effect& e : car.effects)
    if (e.mechanism == "vehicle.turbo_lag") {
      const double lack = c.throttle - x[9];
      if (lack > 0 && torque > 0) torque *= 1 - e.amount * lack;
      const double omega = 0.5 * (x[7] + x[8]) *
                           car.ratio[static_cast<std::size_t>(std::max(1, c.gear) - 1)] *
                           car.final_drive;
      // A turbine driven by the exhaust's power: its own law, not that of lib/vehicle.
      d[9] =
          lack > 0 ? lack / (e.extra * (0.6 + 0.6 * (700 / std::max(200.0, omega)))) : lack / 0.15;
    }
  const double ratio =
      c.gear > 0 ? car.ratio[static_cast<std::size_t>(c.gear - 1)] * car.final_drive : 0;
  const double drive =
      c.gear > 0 ? torque * ratio * (torque > 0 ? car.efficiency : 1 / car.efficiency) : 0;
  double fade = 1 + amount(car, "parameter.brake_gain");
  for (const Effect& e : car.effects)
    if (e.mechanism == "vehicle.brake_friction_temperature")
      fade *= 1 - e.amount * std::tanh(x[11]);
  const double bf = car.brake_f * c.brake_pa * fade, br = car.brake_r * c.brake_pa * fade;

  double warm = 1;
  for (const Effect& e : car.effects)
    if (e.mechanism == "vehicle.tyre_thermal")
      warm -= e.amount * (1 - x[10]),
          d[10] = (1 - x[10]) / e.extra * (0.3 + 0.7 * std::min(2.0, std::abs(r * vx) / 8));
  const double cd = std::cos(c.steer), sd = std::sin(c.steer);
  const double alpha_f = (vy + car.a * r) / vx, alpha_r = (vy - car.b * r) / vx;
  const double slip_f = std::tan(std::atan(alpha_f) - c.steer), slip_r = alpha_r;
  const double relax = std::max(0.15, factor(car, "vehicle.tyre_relaxation"));
  d[14] = (slip_f - x[14]) * vx / (car.relaxation_f * relax);
  d[15] = (slip_r - x[15]) * vx / (car.relaxation_r * relax);
  const double loads = factor(car, "vehicle.tyre_load_sensitivity"),
               combined = factor(car, "vehicle.tyre_combined_slip");
  const double thrust = amount(car, "vehicle.tyre_camber") * car.camber;
  const auto axle = [&](double load, double transfer, double nominal, double mu0, double cn,
                        double kl, double kr, double slip, Tyre* tyre) {
    double fy = 0;
    for (const bool left : {true, false}) {
      const double fz = std::max(100.0, load / 2 - (left ? transfer : -transfer)), n = fz / nominal;
      const double mu = mu0 * (1 - loads * car.mu_load * (n - 1)) * grip * warm *
                        (1 + amount(car, "parameter.tyre_grip"));
      const double cy = cn * nominal * n * std::exp(-0.14 * loads * (n - 1)) * (0.5 + 0.5 * warm),
                   cx = car.ck * fz;
      double fx = 0, side = 0;
      brush(fz, mu, cx, cy, left ? kl : kr, slip, fx, side);
      if (combined != 1) {
        double fx_alone = 0, side_alone = 0, none = 0;
        brush(fz, mu, cx, cy, left ? kl : kr, 0, fx_alone, none);
        brush(fz, mu, cx, cy, 0, slip, none, side_alone);
        fx = combined * fx + (1 - combined) * fx_alone;
        side = combined * side + (1 - combined) * side_alone;
      }
      side += (left ? -1 : 1) * thrust * fz;
      tyre[left ? 0 : 1] = {fx, side, fz, left ? kl : kr, slip};
      fy += side;
    }
    return fy;
  };
  const auto kappa = [&](double omega, double radius, double v) {
    return std::clamp((omega * radius - v) / std::max(5.0, v), -0.9, 0.9);
  };
  std::array<Tyre, 4> tyre{};
  const double kf = kappa(x[6], car.radius_f, vx * cd + (vy + car.a * r) * sd);
  const double vl = vx - r * car.track_r / 2, vr = vx + r * car.track_r / 2;
  const double fyf = axle(front, tf, car.load_f, car.mu_f, car.c_f, kf, kf, x[14], &tyre[0]);
  const double fyr = axle(rear, tr, car.load_r, car.mu_r, car.c_r, kappa(x[7], car.radius_r, vl),
                          kappa(x[8], car.radius_r, vr), x[15], &tyre[2]);
  const double frl = tyre[2].fx, frr = tyre[3].fx;
  const double fxf = tyre[0].fx + tyre[1].fx;
  double lock = 0;
  for (const Effect& e : car.effects)
    if (e.mechanism == "vehicle.differential") lock = e.amount;
  const double couple = lock * 900 * (x[7] - x[8]);
  d[6] = (-bf - fxf * car.radius_f) / (2 * car.wheel_inertia);
  const double jr = car.wheel_inertia + 0.5 * car.engine_inertia * ratio * ratio;
  d[7] = (0.5 * drive - 0.5 * br - frl * car.radius_r - couple) / jr;
  d[8] = (0.5 * drive - 0.5 * br - frr * car.radius_r + couple) / jr;

  double fx = fxf * cd - fyf * sd + frl + frr - drag - car.rolling * (front + rear);
  double fy = fyf * cd + fxf * sd + fyr - side_air;
  double mz = car.a * (fyf * cd + fxf * sd) - car.b * fyr + 0.5 * car.track_r * (frr - frl) +
              0.15 * side_air;
  // Effects nobody has in a library.
  fx -= amount(car, "outside.slip_drag") * 40000 * std::abs(vy / vx) * std::abs(vy / vx) * vx;
  mz += amount(car, "outside.torque_steer") * drive * 0.05;
  mz += amount(car, "outside.brake_pull") * (bf + br) * 0.05;
  fx += amount(car, "outside.surge") * mass * std::sin(kTwoPi * x[16] / 6.3);
  fy += amount(car, "outside.gust") * mass * (std::fmod(x[16], 41.0) < 3.0 ? 1.0 : 0.0);
  const double sfx = fx / mass, sfy = fy / mass;
  d[0] = vx * std::cos(x[2]) - vy * std::sin(x[2]);
  d[1] = vx * std::sin(x[2]) + vy * std::cos(x[2]);
  d[2] = r;
  d[3] = sfx - kGravity * grade + r * vy;
  d[4] = sfy - kGravity * bank - r * vx;
  d[5] = mz / car.inertia;
  d[11] = (bf + br) * vx / car.radius_f / 0.9e6 - x[11] / 14.0;
  d[12] = (mass * sfx * car.h / wheelbase - x[12]) / 0.06;
  d[13] = (mass * sfy * car.h - x[13]) / 0.06;
  d[16] = 1;
  if (out != nullptr) *out = {sfx, sfy, plus, front, rear, s, 0, tyre};
}

}  // namespace

double TruthCar::engine_nm(double omega, double throttle) const {
  if (electric) return motor_nm(*this, omega, throttle);
  const double z = (omega - torque_peak) / torque_width;
  return throttle * torque * (1 - z * z) *
             (omega > 830 ? std::max(0.0, 1 - (omega - 830) / 20) : 1.0) -
         (1 - throttle) * engine_drag * (0.5 + omega / 800);
}

Track::Point Track::at(double s) const {
  const double n = static_cast<double>(x.size());
  double place = std::fmod(s / step_m, n);
  if (place < 0) place += n;
  auto i = static_cast<std::size_t>(place);
  if (i >= x.size()) i = 0;
  const std::size_t j = (i + 1) % x.size();
  const double f = place - static_cast<double>(i);
  return {x[i] + f * (x[j] - x[i]), y[i] + f * (y[j] - y[i]),
          heading[i] + f * std::remainder(heading[j] - heading[i], kTwoPi),
          curvature[i] + f * (curvature[j] - curvature[i])};
}

double Track::height(double s) const {
  s -= shift_m;
  double z = 0;
  for (std::size_t k = 0; k < 3; ++k)
    z += hill[k] * std::sin(kTwoPi * static_cast<double>(k + 1) * s / length_m + hill_phase[k]);
  return z;
}
double Track::grade(double s) const {
  s -= shift_m;
  double z = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double w = kTwoPi * static_cast<double>(k + 1) / length_m;
    z += hill[k] * w * std::cos(w * s + hill_phase[k]);
  }
  return z;
}
double Track::vertical(double s) const {
  s -= shift_m;
  double z = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double w = kTwoPi * static_cast<double>(k + 1) / length_m;
    z -= hill[k] * w * w * std::sin(w * s + hill_phase[k]);
  }
  return z;
}
double Track::rough(double s, double v) const {
  double z = 0;
  double u = std::fmod(s, length_m);
  if (u < 0) u += length_m;
  for (const Feature& f : feature) {
    if (u < f.begin_m || u > f.end_m || v < f.right_m || v > f.left_m) continue;
    const double place = (u - f.begin_m) / f.wave_m, part = place - std::floor(place);
    if (f.teeth)
      z += f.height_m * std::clamp(std::min(part, 1 - part) * 8, 0.0, 1.0);
    else
      z += f.height_m * 0.5 * (1 - std::cos(kTwoPi * part));
  }
  return z;
}
double Track::bank(double s) const {
  s -= shift_m;
  return bank_base * std::sin(kTwoPi * 2 * s / length_m + 1.0) - lean_m * at(s).curvature;
}

Track make_track(double radius_m, double a2, double a3, double a5, double phase) {
  const auto point = [&](double t) {
    const double r = radius_m * (1 + a2 * std::cos(2 * t) + a3 * std::cos(3 * t + phase) +
                                 a5 * std::cos(5 * t + 2 * phase));
    return std::pair{r * std::cos(t), r * std::sin(t)};
  };
  // Equal chords that close: walk with a chord, correct it until the walk ends where it began.
  const int n = static_cast<int>(kTwoPi * radius_m * 1.05 / 1.0);
  const auto walk = [&](double chord, std::vector<double>* angles) {
    double t = 0;
    for (int i = 0; i < n; ++i) {
      if (angles != nullptr) angles->push_back(t);
      const auto [x0, y0] = point(t);
      double low = t, high = t + 4 * chord / (0.5 * radius_m);
      for (int k = 0; k < 50; ++k) {
        const double mid = 0.5 * (low + high);
        const auto [x, y] = point(mid);
        (std::hypot(x - x0, y - y0) < chord ? low : high) = mid;
      }
      t = low;
    }
    return t;
  };
  double low = 0.3, high = 3;
  for (int k = 0; k < 60; ++k) {
    const double mid = 0.5 * (low + high);
    (walk(mid, nullptr) < kTwoPi ? low : high) = mid;
  }
  Track track;
  track.step_m = low;
  std::vector<double> angles;
  walk(low, &angles);
  for (const double t : angles) {
    const auto [x, y] = point(t);
    track.x.push_back(x);
    track.y.push_back(y);
  }
  const std::size_t m = track.x.size();
  for (std::size_t i = 0; i < m; ++i) {
    const std::size_t j = (i + 1) % m, h = (i + m - 1) % m;
    track.heading.push_back(std::atan2(track.y[j] - track.y[h], track.x[j] - track.x[h]));
  }
  for (std::size_t i = 0; i < m; ++i) {
    const std::size_t j = (i + 2) % m, h = (i + m - 2) % m;
    track.curvature.push_back(std::remainder(track.heading[j] - track.heading[h], kTwoPi) /
                              (4 * low));
  }
  track.length_m = low * static_cast<double>(m);
  return track;
}

std::pair<double, double> project(const Track& track, double x, double y, double s_m) {
  double s = s_m;
  for (int k = 0; k < 3; ++k) {
    const Track::Point p = track.at(s);
    s += ((x - p.x) * std::cos(p.heading) + (y - p.y) * std::sin(p.heading)) / (1 - 0.0);
  }
  const Track::Point p = track.at(s);
  return {s, -(x - p.x) * std::sin(p.heading) + (y - p.y) * std::cos(p.heading)};
}

void advance(const TruthCar& car, const Track& track, State& x, const Commands& c, double& s_m,
             Output* out) {
  constexpr double h = 0.001;
  State k1, k2, k3, k4, y;
  const auto change = [&](const State& at, State& d, Output* o, const Warp& warped) {
    if (car.electric)
      electric_rates(car, track, at, c, s_m, warped, d, o);
    else
      rates(car, track, at, c, s_m, warped, d, o);
  };
  const Warp warped = warp(car, track, s_m, project(track, x[0], x[1], s_m).second);
  change(x, k1, out, warped);
  for (std::size_t i = 0; i < x.size(); ++i) y[i] = x[i] + 0.5 * h * k1[i];
  change(y, k2, nullptr, warped);
  for (std::size_t i = 0; i < x.size(); ++i) y[i] = x[i] + 0.5 * h * k2[i];
  change(y, k3, nullptr, warped);
  for (std::size_t i = 0; i < x.size(); ++i) y[i] = x[i] + h * k3[i];
  change(y, k4, nullptr, warped);
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  s_m += h * x[3];
  if (out != nullptr) {
    const auto [s, v] = project(track, x[0], x[1], s_m);
    s_m = s;
    out->s = s;
    out->v = v;
  }
}

}  // namespace trials
