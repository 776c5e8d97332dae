#include "off_the_line.h"

#include <Eigen/Dense>
#include <cmath>

#include "not_known.h"
#include "turning_windows.h"

namespace explain {
namespace {

/// One standard deviation of the bell around a place, and how much of it is looked at: cars leave a
/// line over a hundred metres or more, and a second derivative magnifies noise of positions.
constexpr double kBell_m = 20.0, kReach_m = 2.5 * kBell_m;
/// Who bends away from the line faster than this comes from a pit lane or an apron, which lean as
/// they like: laps on a real oval stay below 0.3 per km.
constexpr double kMostBend_1pm = 1e-3;

/// Value, first and second derivative at `at` of the parabola through the values beside it.
Eigen::Vector3d parabola_at(const std::vector<double>& way_m, const std::vector<double>& value,
                            std::size_t at) {
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double first = 0.0, last = 0.0;
  const auto add = [&](std::size_t i) {
    const double x = (way_m[i] - way_m[at]) / kBell_m;
    if (!(std::abs(x) < kReach_m / kBell_m && std::isfinite(value[i]))) return false;
    const Eigen::Vector3d power{1, x, x * x};
    const double weight = std::exp(-0.5 * x * x);
    square += weight * power * power.transpose();
    right += weight * value[i] * power;
    first = std::min(first, x), last = std::max(last, x);
    return true;
  };
  for (std::size_t i = at; i < value.size() && add(i); ++i) {
  }
  for (std::size_t i = at; i-- > 0 && add(i);) {
  }
  if (last - first < 2) return Eigen::Vector3d::Constant(kNaN);
  const Eigen::Vector3d c = square.ldlt().solve(right);
  return {c[0], c[1] / kBell_m, 2 * c[2] / (kBell_m * kBell_m)};
}

}  // namespace

OffTheLine off_the_line(const Turning& log, const Eigen::VectorXd& line_v_m, double length_m,
                        bool closed) {
  const std::size_t n = log.u_m.size();
  std::vector<double> way_m(n, 0.0), beside_m(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Beside b = beside(log.u_m[i], length_m, closed, line_v_m.size());
    beside_m[i] = log.v_m[i] - (1 - b.share) * line_v_m[b.first] - b.share * line_v_m[b.second];
    if (i > 0) way_m[i] = way_m[i - 1] + went(log, i - 1, length_m, closed);
    if (std::isnan(way_m[i])) way_m[i] = 0.0;  // beyond a gap another count begins
  }
  OffTheLine out{std::vector<double>(n, kNaN), std::vector<double>(n, kNaN),
                 std::vector<double>(n, kNaN)};
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(beside_m[i])) continue;
    const Eigen::Vector3d p = parabola_at(way_m, beside_m, i);
    if (!(std::abs(p[2]) < kMostBend_1pm)) continue;
    out.beside_m[i] = p[0];
    out.slope[i] = p[1];
    out.bend_1pm[i] = p[2];
  }
  return out;
}

}  // namespace explain
