#include "spline.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cstddef>

namespace road {

Spline Spline::smooth(const Knots& knots, double period_m) {
  Spline spline(knots, period_m);
  const auto n = static_cast<Eigen::Index>(knots.u_m.size());
  if (n < 2) return spline;
  const bool periodic = period_m > 0.0;
  Eigen::MatrixXd equation = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool first = i == 0 && !periodic;
    const bool last = i == n - 1 && !periodic;
    const std::size_t previous = (k + spline.u_.size() - 1) % spline.u_.size();
    const double h0 = first ? 0.0 : spline.step(previous);
    const double h1 = last ? 0.0 : spline.step(k);
    const double d0 = first ? 0.0 : spline.secant(previous);
    const double d1 = last ? 0.0 : spline.secant(k);
    const auto before = static_cast<Eigen::Index>(previous);
    const Eigen::Index after = (i + 1) % n;
    if (first) {  // second derivative 0
      equation(i, i) = 2.0, equation(i, after) = 1.0, right(i) = 3.0 * d1;
    } else if (last) {
      equation(i, i) = 2.0, equation(i, before) = 1.0, right(i) = 3.0 * d0;
    } else {  // equal second derivatives on both sides
      equation(i, before) += h1;
      equation(i, i) += 2.0 * (h0 + h1);
      equation(i, after) += h0;
      right(i) = 3.0 * (h1 * d0 + h0 * d1);
    }
  }
  const Eigen::VectorXd slope = equation.partialPivLu().solve(right);
  spline.slope_.assign(slope.data(), slope.data() + n);
  return spline;
}

Spline Spline::monotone(const Knots& knots, double period_m) {
  Spline spline(knots, period_m);
  const std::size_t n = spline.u_.size();
  if (n < 2) return spline;
  for (std::size_t i = 0; i < n; ++i) {
    if (period_m <= 0.0 && (i == 0 || i == n - 1)) continue;  // level at open ends
    const std::size_t previous = (i + n - 1) % n;
    const double d0 = spline.secant(previous);
    const double d1 = spline.secant(i);
    if (d0 * d1 <= 0.0) continue;
    const double w0 = 2.0 * spline.step(i) + spline.step(previous);
    const double w1 = spline.step(i) + 2.0 * spline.step(previous);
    spline.slope_[i] = (w0 + w1) / (w0 / d0 + w1 / d1);
  }
  return spline;
}

double Spline::at(double u_m) const {
  const std::size_t n = u_.size();
  if (n == 1) return value_[0];
  const bool periodic = period_m_ > 0.0;
  if (!periodic) u_m = std::clamp(u_m, u_.front(), u_.back());
  const auto above = std::upper_bound(u_.begin(), u_.end(), u_m);
  auto i = static_cast<std::size_t>(above - u_.begin());
  i = i == 0 ? (periodic ? n - 1 : 0) : i - 1;
  if (!periodic && i == n - 1) return value_[i];
  double offset = u_m - u_[i];
  if (offset < 0.0) offset += period_m_;
  const std::size_t next = (i + 1) % n;
  const double h = step(i);
  const double t = offset / h;
  const double s = 1.0 - t;
  return s * s * ((1.0 + 2.0 * t) * value_[i] + t * h * slope_[i]) +
         t * t * ((3.0 - 2.0 * t) * value_[next] - s * h * slope_[next]);
}

double Spline::largest() const { return *std::max_element(value_.begin(), value_.end()); }

}  // namespace road
