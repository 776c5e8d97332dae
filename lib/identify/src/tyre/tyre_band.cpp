#include <algorithm>
#include <cmath>

#include "tyre_solve.h"

namespace identify {

ForceBand force_band(const TyreFit& fit, const vehicle::TyreInput<double>& condition) {
  // The moment costs as much as both forces: only where something was fitted to it.
  const vehicle::TyreOptions law{.alpha = fit.alpha, .moments = fit.mz.rows > 0};
  Unknowns about{{}, {}, {}, fit.tyre};
  for (const FittedCoefficient& c : fit.coefficients) {
    about.list.push_back(&*std::ranges::find(tyre_unknowns(), c.keyword, &TyreUnknown::keyword));
    about.centre.push_back(c.value);
    about.spread.push_back(std::max(about.list.back()->spread, 0.5 * std::abs(c.reference)));
  }
  const TyreCost cost(about, 3, [&](const vehicle::TyreCoefficients& tyre, double* out) {
    const auto f = vehicle::tyre_forces(tyre, condition, {}, law);
    out[0] = f.fx_n, out[1] = f.fy_n, out[2] = f.mz_nm;
  });
  const auto n = static_cast<Eigen::Index>(about.size());
  const Eigen::MatrixXd slopes =
      Eigen::Map<const Eigen::VectorXd>(about.spread.data(), n).cwiseInverse().asDiagonal() *
      cost_at(cost, std::vector<double>(about.size(), 0.0)).slopes;
  const Eigen::Map<const Eigen::MatrixXd> covariance(fit.covariance.data(), n, n);
  const Eigen::VectorXd sd =
      (slopes.transpose() * covariance * slopes).diagonal().cwiseMax(0.0).cwiseSqrt();
  const auto at = vehicle::tyre_forces(fit.tyre, condition, {}, law);
  return {at.fx_n, at.fy_n, at.mz_nm, sd[0], sd[1], sd[2]};
}

}  // namespace identify
