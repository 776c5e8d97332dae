#include "electric_tyre.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace trials {
namespace {

/// Relative to the nominal load.
struct AtLoad {
  double along, across, loss;  ///< stiffnesses over load, loss of peak per mu_load
};

/// Straight between the measured points, and on beyond them.
template <std::size_t N>
double between(const std::array<double, N>& x, const std::array<double, N>& y, double at) {
  std::size_t i = 0;
  while (i + 2 < N && at > x[i + 1]) ++i;
  return y[i] + (at - x[i]) / (x[i + 1] - x[i]) * (y[i + 1] - y[i]);
}

AtLoad at_load(TyreLaw law, double n) {
  if (law == TyreLaw::kBrush) return {std::pow(n, 0.16), 1.25 / (1 + 0.25 * n), n - 1};
  constexpr std::array<double, 5> load{0.3, 0.7, 1.0, 1.4, 2.0};
  return {between(load, {0.86, 0.955, 1.0, 1.05, 1.10}, n),
          between(load, {1.145, 1.065, 1.0, 0.925, 0.825}, n),
          between(load, {-0.62, -0.27, 0.0, 0.42, 1.1}, n)};
}

/// Force over peak, over slip times stiffness over peak: begins with slope 1.
double shape(TyreLaw law, double slip) {
  if (law == TyreLaw::kBrush) {
    const double left = std::max(0.0, 1 - slip / 3);
    return (1 - left * left * left) * (1 - 0.05 * std::min(1.0, slip / 6));
  }
  // A cubic between measured points, with slopes from their neighbours.
  constexpr std::array<double, 13> x{0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5,
                                     2.0, 2.5,  3.0, 4.0,  6.0, 12.0};
  constexpr std::array<double, 13> y{0.0,   0.244, 0.466, 0.648, 0.786, 0.882, 0.943,
                                     0.994, 1.0,   0.992, 0.968, 0.93,  0.88};
  if (slip >= x.back()) return y.back();
  std::size_t i = 0;
  while (slip >= x[i + 1]) ++i;
  const auto slope = [&](std::size_t k) {
    if (k == 0) return 1.0;
    const std::size_t j = std::min(k + 1, x.size() - 1);
    return (y[j] - y[k - 1]) / (x[j] - x[k - 1]);
  };
  const double h = x[i + 1] - x[i], t = (slip - x[i]) / h, u = 1 - t;
  return u * u * (1 + 2 * t) * y[i] + t * t * (3 - 2 * t) * y[i + 1] +
         h * t * u * (u * slope(i) - t * slope(i + 1));
}

}  // namespace

TyreForce electric_tyre(const ElectricTyre& tyre, double load_n, double sensitivity, double kappa,
                        double tan_alpha) {
  constexpr double kAlongOverAcross = 1.05;  // of the peaks
  const AtLoad at = at_load(tyre.law, load_n / tyre.load_n);
  const double peak = tyre.mu * load_n * (1 - sensitivity * tyre.mu_load * at.loss);
  const double gx = tyre.along * load_n * (1 + sensitivity * (at.along - 1)) * kappa,
               gy = tyre.across * load_n * (1 + sensitivity * (at.across - 1)) * tan_alpha;
  const double slip = std::hypot(gx / (kAlongOverAcross * peak), gy / peak);
  const double share = slip > 1e-9 ? shape(tyre.law, slip) / slip : 1.0;
  return {gx * share, -gy * share};
}

}  // namespace trials
