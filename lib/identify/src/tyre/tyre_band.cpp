#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "identify/tyre_fit.h"

namespace identify {

using vehicle::TyreCoefficients;

ForceBand force_band(const TyreFit& fit, const vehicle::TyreInput<double>& condition) {
  // The moment costs as much as both forces: only where something was fitted to it.
  const vehicle::TyreOptions law{.alpha = fit.alpha, .moments = fit.mz.rows > 0};
  const auto at = vehicle::tyre_forces(fit.tyre, condition, {}, law);
  ForceBand out{at.fx_n, at.fy_n, at.mz_nm, 0.0, 0.0, 0.0};
  const auto n = static_cast<Eigen::Index>(fit.coefficients.size());
  Eigen::VectorXd dfx(n), dfy(n), dmz(n);
  TyreCoefficients tyre = fit.tyre;
  for (const TyreUnknown& one : tyre_unknowns()) {
    const auto found = std::find_if(fit.coefficients.begin(), fit.coefficients.end(),
                                    [&](const auto& c) { return c.keyword == one.keyword; });
    if (found == fit.coefficients.end()) continue;
    const double step = 1e-5 * std::max(one.spread, 0.5 * std::abs(found->reference));
    double& member = tyre.*(one.member);
    const double kept = member;
    member = kept + step;
    const auto up = vehicle::tyre_forces(tyre, condition, {}, law);
    member = kept - step;
    const auto down = vehicle::tyre_forces(tyre, condition, {}, law);
    member = kept;
    const auto i = found - fit.coefficients.begin();
    dfx(i) = (up.fx_n - down.fx_n) / (2.0 * step);
    dfy(i) = (up.fy_n - down.fy_n) / (2.0 * step);
    dmz(i) = (up.mz_nm - down.mz_nm) / (2.0 * step);
  }
  const Eigen::Map<const Eigen::MatrixXd> covariance(fit.covariance.data(), n, n);
  out.fx_sd_n = std::sqrt(std::max(0.0, dfx.dot(covariance * dfx)));
  out.fy_sd_n = std::sqrt(std::max(0.0, dfy.dot(covariance * dfy)));
  out.mz_sd_nm = std::sqrt(std::max(0.0, dmz.dot(covariance * dmz)));
  return out;
}

}  // namespace identify
