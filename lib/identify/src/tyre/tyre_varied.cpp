#include "tyre_varied.h"

#include <Eigen/Dense>
#include <cmath>

#include "base/statistics.h"
#include "identify/tyre_fit.h"

namespace identify {
namespace {

double spread_of(const std::vector<double>& values) {
  return values.empty() ? 0.0 : base::quantile(values, 0.95) - base::quantile(values, 0.05);
}

/// What is left of camber beside a smooth function of side slip and load.
std::vector<double> camber_beside_slip(const TyreSamples& rows, double nominal_n) {
  constexpr Eigen::Index kTerms = 6;
  const auto n = static_cast<Eigen::Index>(rows.rows());
  Eigen::MatrixXd terms(n, kTerms);
  Eigen::VectorXd camber(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& c = rows.conditions[static_cast<std::size_t>(i)];
    const double a = c.tan_alpha, load = c.fz_n / nominal_n;
    terms.row(i) << 1.0, a, a * std::abs(a), a * a * a, load, a * load;
    camber[i] = c.gamma_rad;
  }
  const Eigen::VectorXd left =
      camber - terms * terms.completeOrthogonalDecomposition().solve(camber);
  return {left.begin(), left.end()};
}

}  // namespace

Varied varied(const TyreSamples& rows, const vehicle::TyreCoefficients& reference) {
  const double nominal_n = reference.nominal_load_n * reference.lfzo;
  std::vector<double> load, camber, pressure;
  for (const auto& c : rows.conditions) {
    load.push_back(c.fz_n / nominal_n);
    camber.push_back(c.gamma_rad);
    pressure.push_back(c.pressure_pa > 0 ? c.pressure_pa : reference.pressure_pa);
  }
  Varied out;
  const auto of = [&](Needs need) -> bool& { return out.by_need[static_cast<std::size_t>(need)]; };
  of(Needs::kLoad) = spread_of(load) > 0.2;
  of(Needs::kPressure) = reference.nominal_pressure_pa > 0.0 &&
                         spread_of(pressure) > 0.05 * reference.nominal_pressure_pa;
  if (spread_of(camber) > kDegree) {
    of(Needs::kCamber) = spread_of(camber_beside_slip(rows, nominal_n)) > kDegree;
    out.camber_follows = !of(Needs::kCamber);
  }
  return out;
}

}  // namespace identify
