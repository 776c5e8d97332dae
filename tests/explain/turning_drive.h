// A rigid car on an oval that leans, moved along a given path: positions, heading, the rate about
// its own upright axis, all by differences of exact places. No car model, no forces.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include "base/random.h"
#include "crg/surface.h"
#include "explain/signals.h"
#include "recording/table.h"

namespace explain_test {

constexpr double kPi = std::numbers::pi;

struct TurningDrive {
  // The road: two turns to the left of `radius_m`, between them stretches that hardly turn.
  double radius_m = 230, stretch_m = 450, stretch_radius_m = 1e9, into_turn_m = 60;
  double turn_deg = 20, stretch_deg = 8;
  double lean_over_m = 80;  ///< from the one to the other, its middle is where the turn begins
  double pivot_m = 7.5;     ///< left of the line; the road turns about it
  double half_width_m = 7.5;
  // The drive.
  double speed_mps = 45, beside_m = 3, laps = 3;
  double wander_m = 0;           ///< of the drive, and of the stated line, which was made of one
  double slip_per_mps2 = -5e-4;  ///< angle of the body to its path per lateral acceleration
  // The logger.
  double yaw_filter_s = 0.2, yaw_delay_s = 0.1, ax_filter_s = 2.47;
  double gyro_gain = 0.0, gyro_bias_radps = 0.0;
  bool heading = true, side_slip = true;
  unsigned seed = 1;
};

using Vec = std::array<double, 3>;
inline Vec sum(const Vec& a, double k, const Vec& b) {
  return {a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]};
}
inline double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vec unit(const Vec& a) { return sum({0, 0, 0}, 1 / std::sqrt(dot(a, a)), a); }
inline double step_up(double t) {
  t = std::min(1.0, std::max(0.0, t));
  return t * t * t * (10 - 15 * t + 6 * t * t);
}

/// The oval: each half is a stretch and a turn, and turns by half a circle.
class LeaningOval {
 public:
  static constexpr double kStep_m = 0.25;
  explicit LeaningOval(const TurningDrive& d) : d_(d) {
    const double of_turn = kPi - d.stretch_m / d.stretch_radius_m;
    turn_m_ = of_turn * d.radius_m + d.into_turn_m;
    const double half_m = d.stretch_m + turn_m_;
    const auto steps = 2 * static_cast<std::size_t>(std::ceil(half_m / kStep_m));
    step_m_ = 2 * half_m / static_cast<double>(steps);
    // The ramps of the curvature are counted, so that each half turns by pi exactly.
    double turned = 0;
    for (std::size_t i = 0; i < steps; ++i) turned += shape(at(i) + 0.5 * step_m_) * step_m_;
    scale_ = (2 * kPi - 2 * d.stretch_m / d.stretch_radius_m) / turned;
    Vec p{0, 0, 0};
    double heading = 0;
    for (std::size_t i = 0; i <= steps; ++i) {
      place.push_back(p);
      heading_rad.push_back(heading);
      const double k = curvature(at(i) + 0.5 * step_m_);
      const double middle = heading + 0.5 * k * step_m_;
      p = sum(p, step_m_, {std::cos(middle), std::sin(middle), 0});
      heading += k * step_m_;
    }
  }
  double length_m() const { return step_m_ * static_cast<double>(place.size() - 1); }
  /// Lean to the left, rad; of the turns, negative.
  double lean_rad(double s) const {
    const double half = 0.5 * length_m(), at = std::fmod(s, half), w = d_.lean_over_m;
    const double in = step_up((at - d_.stretch_m) / w + 0.5) - step_up((at - half) / w + 0.5) +
                      (1 - step_up(at / w + 0.5));
    return -(d_.stretch_deg + (d_.turn_deg - d_.stretch_deg) * in) * kPi / 180;
  }
  double curvature(double s) const { return scale_ * shape(s) + 1 / d_.stretch_radius_m * flat(s); }
  Vec at(double s, double v) const {
    const double place_m = std::fmod(s, length_m()) / step_m_;
    const auto i = std::min(static_cast<std::size_t>(place_m), place.size() - 2);
    const double t = (place_m - static_cast<double>(i)) * step_m_;
    const double k = (heading_rad[i + 1] - heading_rad[i]) / step_m_;
    const double half = heading_rad[i] + 0.5 * k * t, all = heading_rad[i] + k * t;
    const Vec on = sum(place[i], t, {std::cos(half), std::sin(half), 0});
    return sum(on, 1,
               {-v * std::sin(all), v * std::cos(all), std::tan(lean_rad(s)) * (v - d_.pivot_m)});
  }
  double wander_m(double s) const { return d_.wander_m * std::sin(2 * kPi * 9 * s / length_m()); }
  /// Stated flat, as edges without heights or a driven line would make it.
  crg::Crg flat_road() const {
    // Equally far apart along the line that wanders.
    const auto beside = [&](double s) { return at(s, wander_m(s)); };
    std::vector<double> went_m{0.0};
    for (std::size_t i = 1; i < place.size(); ++i) {
      Vec step = sum(beside(at(i)), -1, beside(at(i - 1)));
      step[2] = 0;
      went_m.push_back(went_m.back() + std::sqrt(dot(step, step)));
    }
    crg::ReferenceLine line;
    const double u_step_m = went_m.back() / static_cast<double>(place.size() - 1);
    line.u_step_m = u_step_m;
    line.closed = true;
    std::size_t before = 0;
    for (std::size_t i = 0; i < place.size(); ++i) {
      const double u_m = u_step_m * static_cast<double>(i);
      while (before + 2 < went_m.size() && went_m[before + 1] < u_m) ++before;
      const double part = (u_m - went_m[before]) / (went_m[before + 1] - went_m[before]);
      const Vec on = beside(i + 1 < place.size() ? at(before) + part * step_m_ : 0.0);
      line.x_m.push_back(on[0]);
      line.y_m.push_back(on[1]);
      line.heading_rad.push_back(
          i == 0 ? 0.0 : std::atan2(line.y_m[i] - line.y_m[i - 1], line.x_m[i] - line.x_m[i - 1]));
    }
    line.heading_rad[0] = line.heading_rad[1];
    crg::Grid grid;
    grid.u_step_m = u_step_m;
    const int columns = static_cast<int>(d_.half_width_m / 0.5) + 2;
    for (int j = -columns; j <= columns; ++j) grid.v_m.push_back(0.5 * j);
    grid.z_m.assign(place.size() * grid.v_m.size(), 0.0f);
    return crg::make_crg(line, grid);
  }

  std::vector<Vec> place;
  std::vector<double> heading_rad;

 private:
  double at(std::size_t i) const { return step_m_ * static_cast<double>(i); }
  double shape(double s) const {
    const double half = d_.stretch_m + turn_m_, at = std::fmod(s, half) - d_.stretch_m;
    return step_up(at / d_.into_turn_m) * step_up((turn_m_ - at) / d_.into_turn_m);
  }
  double flat(double s) const {
    const double at = std::fmod(s, d_.stretch_m + turn_m_);
    return 1 / (1 - d_.into_turn_m / d_.stretch_m) * step_up(at / d_.into_turn_m) *
           step_up((d_.stretch_m - at) / d_.into_turn_m);
  }

  TurningDrive d_;
  double turn_m_ = 0, step_m_ = 0, scale_ = 1;
};

/// As a logger of 25 Hz has it.
inline recording::Table logged(const TurningDrive& d) {
  const LeaningOval road(d);
  base::Random random(d.seed);
  constexpr double kDt = 1.0 / 400;
  constexpr std::size_t kEvery = 16;
  const double phase = random.uniform(0, 2 * kPi), wave = random.uniform(0.5, 1.5);
  const auto beside = [&](double s) {
    return d.beside_m + road.wander_m(s) +
           wave * std::sin(2 * kPi * s / road.length_m() * 1.3 + phase);
  };
  const auto on = [&](double s) { return road.at(s, beside(s)); };
  std::vector<double> s{0.0};
  while (s.back() < d.laps * road.length_m()) {
    const double v = d.speed_mps * (1 + 0.08 * std::sin(s.back() / 270 + phase));
    const Vec a = on(s.back()), b = on(s.back() + 0.05);
    const Vec along = sum(b, -1, a);
    s.push_back(s.back() + v * kDt * 0.05 / std::sqrt(dot(along, along)));
  }
  const std::size_t n = s.size() - 2;
  std::vector<Vec> p, nose, up;
  std::vector<double> speed, slip;
  for (std::size_t i = 1; i <= n; ++i) {
    p.push_back(on(s[i]));
    const Vec moved = sum(on(s[i + 1]), -1, on(s[i - 1]));
    speed.push_back(std::sqrt(dot(moved, moved)) / (2 * kDt));
    const double v = beside(s[i]);
    const Vec along = sum(road.at(s[i] + 0.02, v), -1, road.at(s[i], v)),
              across = sum(road.at(s[i], v + 0.02), -1, road.at(s[i], v));
    up.push_back(unit(cross(along, across)));
    slip.push_back(d.slip_per_mps2 * (speed.back() * speed.back() * road.curvature(s[i]) *
                                          std::cos(road.lean_rad(s[i])) +
                                      9.81 * std::sin(road.lean_rad(s[i]))));
    const Vec course = unit(moved), left = cross(up.back(), course);
    nose.push_back(
        sum(sum({0, 0, 0}, std::cos(slip.back()), course), -std::sin(slip.back()), left));
  }
  recording::Table out;
  std::array<std::vector<double>, 8> column;
  double lagging = 0, ax = 0, drift = 0;
  std::vector<double> late;
  const auto round8 = [](double x) { return std::round(x * 1e8) * 1e-8; };
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const Vec turning = sum(nose[i + 1], -1, nose[i - 1]);
    const double yaw_rate = dot(turning, cross(up[i], nose[i])) / (2 * kDt);
    if (i == 1) lagging = yaw_rate;
    lagging +=
        (yaw_rate - lagging) * (d.yaw_filter_s > 0 ? 1 - std::exp(-kDt / d.yaw_filter_s) : 1);
    late.push_back(lagging);
    const double vx = speed[i] * std::cos(slip[i]);
    ax += ((speed[i + 1] - speed[i - 1]) / (2 * kDt) - ax) * (1 - std::exp(-kDt / d.ax_filter_s));
    drift += -drift * kDt / 5 + 5e-4 * std::sqrt(2 * kDt / 5) * random.normal();
    if (i % kEvery != 0) continue;
    const auto back = static_cast<std::size_t>(d.yaw_delay_s / kDt);
    const double gyro = late[late.size() > back ? late.size() - 1 - back : 0];
    const std::array<double, 8> row{
        static_cast<double>(i) * kDt,
        p[i][0] + 0.02 * random.normal(),
        p[i][1] + 0.02 * random.normal(),
        vx + 0.03 * random.normal(),
        speed[i] * std::sin(slip[i]) + 0.02 * random.normal(),
        std::atan2(nose[i][1], nose[i][0]) + drift + 1e-3 * random.normal(),
        (1 + d.gyro_gain) * gyro + d.gyro_bias_radps + 2e-3 * random.normal(),
        ax + 1e-3 * random.normal()};
    for (std::size_t k = 0; k < 8; ++k) column[k].push_back(round8(row[k]));
  }
  constexpr const char* kNames[] = {
      "time_s", "x_m", "y_m", "vx_mps", "vy_mps", "yaw_rad", "yaw_rate_radps", "ax_mps2"};
  for (std::size_t k = 0; k < 8; ++k)
    if ((k != 4 || d.side_slip) && (k != 5 || d.heading)) out.add(kNames[k], std::move(column[k]));
  return out;
}

}  // namespace explain_test
