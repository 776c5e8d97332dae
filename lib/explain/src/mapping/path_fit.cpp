#include "path_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace explain {

Fit through_zero(const std::vector<double>& x, const std::vector<double>& y) {
  double xx = 0, xy = 0, yy = 0;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
    if (std::isfinite(x[i]) && std::isfinite(y[i])) {
      xx += x[i] * x[i];
      xy += x[i] * y[i];
      yy += y[i] * y[i];
    }
  if (xx <= 0 || yy <= 0) return {};
  return {xy / xx, xy / std::sqrt(xx * yy)};
}

namespace {

double wrap(double a) { return std::remainder(a, 2 * std::numbers::pi); }

}  // namespace

Path path_of(const std::vector<double>& t, const std::vector<double>& x,
             const std::vector<double>& y) {
  const std::size_t n = t.size();
  std::size_t half = 1;
  while (half * 2 < n / 4 && t[std::min(n - 1, half)] - t[0] < 0.2) ++half;
  Path p;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  p.course.assign(n, nan);
  p.rate = p.speed = p.acceleration = p.course;
  for (std::size_t i = half; i + half < n; ++i) {
    const double dt = t[i + half] - t[i - half];
    const double dx = x[i + half] - x[i - half], dy = y[i + half] - y[i - half];
    if (!(dt > 0)) continue;
    p.speed[i] = std::hypot(dx, dy) / dt;
    if (p.speed[i] > 4.0) p.course[i] = std::atan2(dy, dx);
  }
  for (std::size_t i = half; i + half < n; ++i) {
    const double dt = t[i + half] - t[i - half];
    if (!(dt > 0)) continue;
    p.rate[i] = wrap(p.course[i + half] - p.course[i - half]) / dt;
    p.acceleration[i] = (p.speed[i + half] - p.speed[i - half]) / dt;
  }
  return p;
}

std::vector<double> acceleration_of(const std::vector<double>& t,
                                    const std::vector<double>& speed) {
  std::vector<double> out(t.size(), std::numeric_limits<double>::quiet_NaN());
  std::size_t from = 0, to = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    while (t[from] < t[i] - 0.15) ++from;
    while (to + 1 < t.size() && t[to] < t[i] + 0.15) ++to;
    if (t[to] - t[from] > 0.1 && t[to] - t[from] < 1.0)
      out[i] = (speed[to] - speed[from]) / (t[to] - t[from]);
  }
  return out;
}

}  // namespace explain
