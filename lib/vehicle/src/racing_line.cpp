#include "vehicle/racing_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vehicle/error.h"

namespace vehicle {
namespace {

/// Range of v at u that is road without a hole, around the middle of the grid.
struct Width {
  double low, high;
};

Width width_at(const crg::Surface& road, double u_m) {
  const auto& v_m = road.file().grid.v_m;
  const double middle = 0.5 * (v_m.front() + v_m.back());
  const double step = (v_m.back() - v_m.front()) / (4.0 * static_cast<double>(v_m.size() - 1));
  // Start from the valid place nearest to the middle.
  double start = middle;
  for (std::size_t i = 0; i <= 4 * v_m.size(); ++i) {
    const double offset = (i % 2 == 0 ? 0.5 : -0.5) * static_cast<double>(i + i % 2) * step;
    start = std::clamp(middle + offset, v_m.front(), v_m.back());
    if (std::isfinite(road.z_at_uv(u_m, start))) break;
  }
  Width out{start, start};
  while (out.low - step >= v_m.front() && std::isfinite(road.z_at_uv(u_m, out.low - step)))
    out.low -= step;
  while (out.high + step <= v_m.back() && std::isfinite(road.z_at_uv(u_m, out.high + step)))
    out.high += step;
  return out;
}

/// Neighbour of i at distance k, round the lap or stopped at the ends.
std::size_t neighbour(std::size_t i, std::ptrdiff_t k, std::size_t n, bool closed) {
  const auto size = static_cast<std::ptrdiff_t>(n);
  std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + k;
  if (closed) j = (j % size + size) % size;
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(j, 0, size - 1));
}

double wrapped(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

}  // namespace

RacingLine plan_line(const crg::Surface& road, const RacingLineOptions& options) {
  const crg::ReferenceLine& reference = road.reference_line();
  const double u_begin = reference.u_begin_m;
  const double u_length = reference.u_step_m * static_cast<double>(reference.size() - 1);
  RacingLine line;
  line.closed = reference.closed;
  const auto n = static_cast<std::size_t>(std::max(8.0, std::round(u_length / options.station_m)));
  line.u_begin_m = u_begin;
  line.u_step_m = u_length / static_cast<double>(line.closed ? n : n - 1);
  line.v_m.resize(n);

  std::vector<double> low(n), high(n);
  std::vector<crg::Point2> base(n), normal(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double u = u_begin + line.u_step_m * static_cast<double>(i);
    // The narrowest of a few cuts around the station, so that holes between stations count.
    Width w = width_at(road, u);
    for (const double shift : {-0.5, -0.25, 0.25, 0.5}) {
      const double near = std::clamp(u + shift * line.u_step_m, u_begin, u_begin + u_length);
      const Width other = width_at(road, near);
      w.low = std::max(w.low, other.low);
      w.high = std::min(w.high, other.high);
    }
    low[i] = w.low + options.margin_m;
    high[i] = w.high - options.margin_m;
    if (low[i] > high[i])
      throw Error(
          fmt::format("the road at u = {:.1f} m is {:.2f} m wide; a line with {:.2f} m to both "
                      "edges needs more",
                      u, w.high - w.low, options.margin_m));
    base[i] = road.xy_of_uv(u, 0.0);
    const crg::Point2 left = road.xy_of_uv(u, 1.0);
    normal[i] = {left.x_m - base[i].x_m, left.y_m - base[i].y_m};
    line.v_m[i] = 0.5 * (low[i] + high[i]);
  }

  // Projected relaxation of sum |P[i-k] - 2 P[i] + P[i+k]|^2 over the offsets, coarse to fine: a
  // stride of k moves long waves, a stride of 1 the details.
  const auto point = [&](std::size_t i) {
    return crg::Point2{base[i].x_m + line.v_m[i] * normal[i].x_m,
                       base[i].y_m + line.v_m[i] * normal[i].y_m};
  };
  std::ptrdiff_t stride = 1;
  while (static_cast<std::size_t>(stride) * 16 < n && stride < 32) stride *= 2;
  for (; stride >= 1; stride /= 2) {
    const auto coarse = [&](std::size_t i) { return i % static_cast<std::size_t>(stride) == 0; };
    for (int sweep = 0; sweep < options.sweeps; ++sweep) {
      double largest = 0.0;
      for (std::size_t i = 0; i < n; ++i) {
        if (!coarse(i)) continue;
        // Minimum over v[i] of the three second differences that contain P[i].
        double gradient = 0.0, weight = 0.0;
        for (const auto& [shift, factor] :
             {std::pair{-stride, 1.0}, std::pair{std::ptrdiff_t{0}, -2.0},
              std::pair{stride, 1.0}}) {
          const std::size_t c = neighbour(i, shift, n, line.closed);
          const std::size_t a = neighbour(c, -stride, n, line.closed);
          const std::size_t b = neighbour(c, stride, n, line.closed);
          if (!line.closed && (a == c || b == c)) continue;
          const crg::Point2 pa = point(a), pc = point(c), pb = point(b);
          const double dx = pa.x_m - 2.0 * pc.x_m + pb.x_m;
          const double dy = pa.y_m - 2.0 * pc.y_m + pb.y_m;
          gradient += factor * (dx * normal[i].x_m + dy * normal[i].y_m);
          weight += factor * factor;
        }
        if (weight == 0.0) continue;
        const double before = line.v_m[i];
        line.v_m[i] = std::clamp(before - gradient / weight, low[i], high[i]);
        largest = std::max(largest, std::abs(line.v_m[i] - before));
      }
      if (largest < 1e-5) break;
    }
    // Stations between those of this level follow linearly and are kept on the road.
    if (stride > 1)
      for (std::size_t i = 0; i < n; ++i) {
        if (coarse(i)) continue;
        const std::size_t a = i - i % static_cast<std::size_t>(stride);
        std::size_t b = a + static_cast<std::size_t>(stride);
        const double span = static_cast<double>(b >= n && line.closed ? n - a : b - a);
        b = b >= n ? (line.closed ? 0 : a) : b;
        const double t = static_cast<double>(i - a) / span;
        line.v_m[i] = std::clamp(line.v_m[a] + t * (line.v_m[b] - line.v_m[a]), low[i], high[i]);
      }
  }

  line.x_m.resize(n);
  line.y_m.resize(n);
  line.s_m.assign(n, 0.0);
  line.heading_rad.resize(n);
  line.curvature_1pm.resize(n);
  line.bank.resize(n);
  line.grade.resize(n);
  line.vertical_curvature_1pm.resize(n);
  line.speed_mps.assign(n, 0.0);
  std::vector<double> z(n);
  for (std::size_t i = 0; i < n; ++i) {
    const crg::Point2 p = point(i);
    line.x_m[i] = p.x_m;
    line.y_m[i] = p.y_m;
    z[i] = road.z_at_uv(u_begin + line.u_step_m * static_cast<double>(i), line.v_m[i]);
    if (i > 0)
      line.s_m[i] = line.s_m[i - 1] + std::hypot(p.x_m - line.x_m[i - 1], p.y_m - line.y_m[i - 1]);
  }
  line.length_m = line.s_m.back();
  if (line.closed)
    line.length_m +=
        std::hypot(line.x_m.front() - line.x_m.back(), line.y_m.front() - line.y_m.back());
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t a = neighbour(i, -1, n, line.closed), b = neighbour(i, 1, n, line.closed);
    line.heading_rad[i] = std::atan2(line.y_m[b] - line.y_m[a], line.x_m[b] - line.x_m[a]);
    if (i > 0)
      line.heading_rad[i] =
          line.heading_rad[i - 1] + wrapped(line.heading_rad[i] - line.heading_rad[i - 1]);
    const double before = std::hypot(line.x_m[i] - line.x_m[a], line.y_m[i] - line.y_m[a]);
    const double after = std::hypot(line.x_m[b] - line.x_m[i], line.y_m[b] - line.y_m[i]);
    if (before > 0.0 && after > 0.0) {
      const double turn = wrapped(std::atan2(line.y_m[b] - line.y_m[i], line.x_m[b] - line.x_m[i]) -
                                  std::atan2(line.y_m[i] - line.y_m[a], line.x_m[i] - line.x_m[a]));
      line.curvature_1pm[i] = 2.0 * turn / (before + after);
      line.grade[i] = (z[b] - z[a]) / (before + after);
      line.vertical_curvature_1pm[i] =
          2.0 * ((z[b] - z[i]) / after - (z[i] - z[a]) / before) / (before + after);
    }
    const double u = u_begin + line.u_step_m * static_cast<double>(i);
    const double left = road.z_at_uv(u, line.v_m[i] + 0.5),
                 right = road.z_at_uv(u, line.v_m[i] - 0.5);
    line.bank[i] = std::isfinite(left) && std::isfinite(right) ? left - right : 0.0;
  }
  // A kink of the grid must not count as a crest: smooth the vertical curvature over three
  // stations.
  std::vector<double> smooth = line.vertical_curvature_1pm;
  for (std::size_t i = 0; i < n; ++i)
    smooth[i] = (line.vertical_curvature_1pm[neighbour(i, -1, n, line.closed)] +
                 line.vertical_curvature_1pm[i] +
                 line.vertical_curvature_1pm[neighbour(i, 1, n, line.closed)]) /
                3.0;
  line.vertical_curvature_1pm = smooth;
  return line;
}

void plan_speed(RacingLine& line, const Car<double>& car, const SpeedOptions& options) {
  using P = Parameter;
  const Parameters<double>& p = car.parameters;
  const double mass = p[P::chassis_mass_kg] + options.fuel_kg;
  const double g = p[P::environment_gravity_mps2];
  const double half_density = 0.5 * p[P::aero_density_kgpm3];
  const double lift_area = value_of(car.terms[Term::aero_downforce]) *
                           (p[P::front_lift_area_m2] + p[P::rear_lift_area_m2]);
  const double drag_area = value_of(car.terms[Term::aero_drag]) * p[P::aero_drag_area_m2];

  // Friction the tyres have at the load of this speed; the weaker axle counts, and the temperature.
  double warmth = 1.0;
  if (car.terms[Term::tyre_thermal] > 0.0) {
    const double cold = (p[P::tyre_window_begin_k] - options.tyre_k) / p[P::tyre_cold_width_k];
    const double hot = (options.tyre_k - p[P::tyre_window_end_k]) / p[P::tyre_hot_width_k];
    if (cold > 0)
      warmth -=
          car.terms[Term::tyre_thermal] * p[P::tyre_cold_loss] * cold * cold / (1 + cold * cold);
    if (hot > 0)
      warmth -= car.terms[Term::tyre_thermal] * p[P::tyre_hot_loss] * hot * hot / (1 + hot * hot);
  }
  const auto friction = [&](double load_n, bool lateral) {
    double mu = 10.0;
    for (std::size_t a = 0; a < 2; ++a) {
      const double fz =
          load_n * car.static_load_n[a] / (2.0 * (car.static_load_n[0] + car.static_load_n[1]));
      const TyreForces<double> f = tyre_forces(
          car.files->tyre[a],
          TyreInput<double>{std::max(fz, 100.0), 0, 0, 0, 30, p.axle(a, P::front_tyre_pressure_pa)},
          {}, {.moments = false});
      mu = std::min(mu, std::abs(lateral ? f.mu_y : f.mu_x) * p.axle(a, P::front_tyre_grip));
    }
    return mu * warmth * options.grip_usage;
  };
  const auto load = [&](std::size_t i, double v) {
    const double tilt =
        1.0 / std::sqrt(1.0 + line.bank[i] * line.bank[i] + line.grade[i] * line.grade[i]);
    // Weight, downforce, dips and crests, and the part of the cornering force a bank takes up.
    const double n =
        mass * (g * tilt +
                v * v * (line.vertical_curvature_1pm[i] - line.curvature_1pm[i] * line.bank[i])) +
        half_density * lift_area * v * v;
    return std::max(n, 0.1 * mass * g);
  };
  // Lateral force the tyres must give at v: the turn, less what gravity on the bank gives. The bank
  // rises to the left, so it pushes to the right.
  const auto lateral = [&](std::size_t i, double v) {
    return mass * std::abs(v * v * line.curvature_1pm[i] + g * line.bank[i]);
  };
  const std::size_t n = line.v_m.size();
  std::vector<double>& speed = line.speed_mps;
  speed.assign(n, options.top_mps);
  for (std::size_t i = 0; i < n; ++i) {
    // Largest speed with grip to spare; a bank alone never asks for a minimum speed here.
    double fast = options.top_mps, slow = 3.0;
    const auto holds = [&](double v) {
      return lateral(i, v) <= friction(load(i, v), true) * load(i, v);
    };
    if (holds(fast)) continue;
    for (int k = 0; k < 40; ++k) {
      const double v = 0.5 * (fast + slow);
      (holds(v) ? slow : fast) = v;
    }
    speed[i] = slow;
  }
  const auto spare = [&](std::size_t i, double v) {
    const double used = lateral(i, v) / std::max(1.0, friction(load(i, v), true) * load(i, v));
    return std::sqrt(std::max(0.0, 1.0 - used * used));
  };
  const auto distance = [&](std::size_t i) {
    return i + 1 < n ? line.s_m[i + 1] - line.s_m[i] : line.length_m - line.s_m[i];
  };
  const double driven_share = car.static_load_n[1] / (car.static_load_n[0] + car.static_load_n[1]);
  const double radius = car.static_radius_m[1];
  const auto engine_force = [&](double v) {
    double best = 0.0;
    for (std::size_t k = 0; k < 6; ++k) {
      const double ratio =
          p.value[static_cast<std::size_t>(P::gearbox_ratio_1) + k] * p[P::gearbox_final];
      const double speed_e = ratio * v / radius;
      if (ratio <= 0.0 || speed_e > p[P::engine_limit_radps]) continue;
      best = std::max(best, p[P::engine_torque] *
                                evaluate(car.files->engine_torque_nm,
                                         std::max(speed_e, p[P::clutch_full_radps]), 1.0) *
                                ratio * p[P::gearbox_efficiency] / radius);
    }
    return best;
  };
  // Twice round a closed lap, so that the end knows the beginning. An open road ends rolling.
  const std::size_t rounds = line.closed ? 2 * n : n;
  if (options.standing_start) speed[0] = std::min(speed[0], 3.0);
  for (std::size_t k = 0; k + 1 < rounds; ++k) {  // forwards: acceleration
    const std::size_t i = k % n, j = (k + 1) % n;
    if (options.standing_start && j == 0) break;
    const double v = speed[i];
    const double grip = 0.9 * friction(load(i, v), false) * load(i, v) * driven_share * spare(i, v);
    const double force = std::min(grip, engine_force(v)) - half_density * drag_area * v * v -
                         mass * g * line.grade[i];
    speed[j] =
        std::min(speed[j], std::sqrt(std::max(9.0, v * v + 2.0 * force / mass * distance(i))));
  }
  for (std::size_t k = rounds; k-- > 1;) {  // backwards: braking
    const std::size_t j = k % n, i = (k - 1) % n;
    if (!line.closed && j == 0) continue;
    const double v = speed[j];
    const double grip = 0.85 * friction(load(i, v), false) * load(i, v) * spare(i, v);
    const double force = grip + half_density * drag_area * v * v + mass * g * line.grade[i];
    speed[i] =
        std::min(speed[i],
                 std::sqrt(std::max(9.0, v * v + 2.0 * std::max(0.0, force) / mass * distance(i))));
  }
}

}  // namespace vehicle
