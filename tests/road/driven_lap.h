// A drive round a closed curve that is known in closed form, as a logger would have it.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace road {

struct DrivenLap {
  std::vector<double> time_s, x_m, y_m, vx_mps, yaw_rate_radps;
  double lap_m = 0.0, lap_s = 0.0;
};

/// r = 200 + 40 cos(3a + 0.5) + 25 sin 2a, counter-clockwise from the angle a = 1 on, `laps` of it,
/// 20 rows a second, at 20 to 30 m/s.
inline std::complex<double> curve_at(double a) {
  return std::polar(200.0 + 40.0 * std::cos(3.0 * a + 0.5) + 25.0 * std::sin(2.0 * a), a);
}

inline DrivenLap drive_round(double laps, double rows_a_second = 20.0) {
  constexpr double kStep = 1e-4;  // of the angle
  DrivenLap out;
  const auto speed = [](double a) { return 25.0 + 5.0 * std::cos(2.0 * a); };
  const auto heading = [](double a) { return std::arg(curve_at(a + 1e-5) - curve_at(a - 1e-5)); };
  double t = 0.0, next = 0.0;
  const double end = 2.0 * std::numbers::pi * laps;
  for (double gone = 0.0; gone < end; gone += kStep) {
    const double a = 1.0 + gone, step_m = std::abs(curve_at(a + kStep) - curve_at(a));
    if (t >= next) {
      const double turn = std::remainder(heading(a + kStep) - heading(a), 2.0 * std::numbers::pi);
      out.time_s.push_back(t);
      out.x_m.push_back(curve_at(a).real());
      out.y_m.push_back(curve_at(a).imag());
      out.vx_mps.push_back(speed(a));
      out.yaw_rate_radps.push_back(turn / step_m * speed(a));
      next += 1.0 / rows_a_second;
    }
    if (gone < 2.0 * std::numbers::pi) out.lap_m += step_m, out.lap_s += step_m / speed(a);
    t += step_m / speed(a);
  }
  return out;
}

}  // namespace road
