#include "tyre_costs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace identify {

using vehicle::TyreCoefficients;

Unknowns unknowns_of(const std::vector<const TyreUnknown*>& list, const TyreCoefficients& reference,
                     const TyreCoefficients& rest) {
  Unknowns out{list, {}, {}, rest};
  for (const TyreUnknown* one : list) {
    out.centre.push_back(reference.*(one->member));
    out.spread.push_back(std::max(one->spread, 0.5 * std::abs(out.centre.back())));
  }
  return out;
}

TyreCost::TyreCost(const Unknowns& unknowns, std::size_t count, Read read)
    : unknowns_(unknowns), count_(count), read_(std::move(read)) {
  set_num_residuals(static_cast<int>(count));
  mutable_parameter_block_sizes()->push_back(static_cast<int>(unknowns.size()));
}

bool TyreCost::Evaluate(double const* const* parameters, double* residuals,
                        double** jacobians) const {
  constexpr double kDifference = 1e-5;  // of a spread, for slopes
  const double* p = parameters[0];
  TyreCoefficients tyre = unknowns_.at(p);
  read_(tyre, residuals);
  for (std::size_t i = 0; jacobians != nullptr && i < unknowns_.size(); ++i) {
    std::array<double, 4> up, down;
    double& member = tyre.*(unknowns_.list[i]->member);
    const double kept = member;
    member = unknowns_.value(i, p[i] + kDifference);
    read_(tyre, up.data());
    member = unknowns_.value(i, p[i] - kDifference);
    read_(tyre, down.data());
    member = kept;
    for (std::size_t k = 0; k < count_; ++k)
      jacobians[0][k * unknowns_.size() + i] = (up[k] - down[k]) / (2.0 * kDifference);
  }
  return std::all_of(residuals, residuals + count_, [](double r) { return std::isfinite(r); });
}

TyreCost force_cost(const Unknowns& unknowns, const vehicle::TyreInput<double>& condition,
                    double fx_n, double fy_n, const Noise& noise,
                    const vehicle::TyreOptions& options) {
  return {unknowns, (std::isnan(fx_n) ? 0u : 1u) + (std::isnan(fy_n) ? 0u : 1u),
          [=](const TyreCoefficients& tyre, double* out) {
            const auto force = vehicle::tyre_forces(tyre, condition, {}, options);
            if (!std::isnan(fx_n)) *out++ = (force.fx_n - fx_n) / noise.fx_n;
            if (!std::isnan(fy_n)) *out = (force.fy_n - fy_n) / noise.fy_n;
          }};
}

TyreCost moment_cost(const Unknowns& unknowns, const vehicle::TyreInput<double>& condition,
                     double mz_nm, double noise_nm, const vehicle::TyreOptions& options) {
  return {unknowns, 1, [=](const TyreCoefficients& tyre, double* out) {
            *out = (vehicle::tyre_forces(tyre, condition, {}, options).mz_nm - mz_nm) / noise_nm;
          }};
}

TyreCost guard_cost(const Unknowns& unknowns, const TyreCoefficients& reference,
                    const vehicle::TyreInput<double>& condition) {
  constexpr double kLeast = 0.15;  // of the reference's, what friction and stiffness must keep
  const vehicle::TyreInput<double> nominal{.fz_n = reference.nominal_load_n * reference.lfzo,
                                           .vx_mps = reference.nominal_speed_mps};
  const auto wanted = vehicle::tyre_forces(reference, nominal);
  // Stiffness goes to zero with the load; friction does not.
  const double share = kLeast * std::min(1.0, condition.fz_n / nominal.fz_n);
  return {unknowns, 4, [=](const TyreCoefficients& tyre, double* out) {
            const auto force = vehicle::tyre_forces(tyre, condition, {}, {.moments = false});
            const auto lacks = [](double value, double whole, double keeps) {
              return 100.0 * std::max(0.0, keeps - value / whole);
            };
            out[0] = lacks(force.mu_x, wanted.mu_x, kLeast);
            out[1] = lacks(force.mu_y, wanted.mu_y, kLeast);
            out[2] = lacks(force.slip_stiffness_n, wanted.slip_stiffness_n, share);
            out[3] = lacks(force.cornering_stiffness_npr, wanted.cornering_stiffness_npr, share);
          }};
}

}  // namespace identify
