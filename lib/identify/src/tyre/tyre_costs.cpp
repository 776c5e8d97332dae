#include "tyre_costs.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace identify {
namespace {

using vehicle::TyreCoefficients;

constexpr double kDifference = 1e-5;  // of a spread, for slopes
constexpr double kLeast = 0.15;       // of the reference's, what friction and stiffness must keep

/// Values of `read(tyre)` at p and, where asked, their slopes by central differences.
template <std::size_t kMost, class Read>
void with_slopes(const Unknowns& unknowns, const double* p, std::size_t count, const Read& read,
                 double* values, double* slopes) {
  TyreCoefficients tyre = unknowns.at(p);
  read(tyre, values);
  if (slopes == nullptr) return;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    std::array<double, kMost> up, down;
    double& member = tyre.*(unknowns.list[i]->member);
    const double kept = member;
    member = unknowns.value(i, p[i] + kDifference);
    read(tyre, up.data());
    member = unknowns.value(i, p[i] - kDifference);
    read(tyre, down.data());
    member = kept;
    for (std::size_t k = 0; k < count; ++k)
      slopes[k * unknowns.size() + i] = (up[k] - down[k]) / (2.0 * kDifference);
  }
}

}  // namespace

Unknowns unknowns_of(const std::vector<const TyreUnknown*>& list,
                     const vehicle::TyreCoefficients& reference,
                     const vehicle::TyreCoefficients& rest) {
  Unknowns out{list, {}, {}, rest};
  for (const TyreUnknown* one : list) {
    out.centre.push_back(reference.*(one->member));
    out.spread.push_back(std::max(one->spread, 0.5 * std::abs(out.centre.back())));
  }
  return out;
}

RowCost::RowCost(const Unknowns& unknowns, const vehicle::TyreInput<double>& condition, double fx_n,
                 double fy_n, const Noise& noise, const vehicle::TyreOptions& options)
    : unknowns_(unknowns),
      condition_(condition),
      fx_n_(fx_n),
      fy_n_(fy_n),
      noise_(noise),
      options_(options),
      count_((std::isnan(fx_n) ? 0u : 1u) + (std::isnan(fy_n) ? 0u : 1u)) {
  set_num_residuals(static_cast<int>(count_));
  mutable_parameter_block_sizes()->push_back(static_cast<int>(unknowns.size()));
}

bool RowCost::Evaluate(double const* const* parameters, double* residuals,
                       double** jacobians) const {
  const auto read = [&](const TyreCoefficients& tyre, double* out) {
    const auto force = vehicle::tyre_forces(tyre, condition_, {}, options_);
    if (!std::isnan(fx_n_)) *out++ = (force.fx_n - fx_n_) / noise_.fx_n;
    if (!std::isnan(fy_n_)) *out = (force.fy_n - fy_n_) / noise_.fy_n;
  };
  with_slopes<2>(unknowns_, parameters[0], count_, read, residuals,
                 jacobians ? jacobians[0] : nullptr);
  return std::all_of(residuals, residuals + count_, [](double r) { return std::isfinite(r); });
}

MomentCost::MomentCost(const Unknowns& unknowns, const vehicle::TyreInput<double>& condition,
                       double mz_nm, double noise_nm, const vehicle::TyreOptions& options)
    : unknowns_(unknowns),
      condition_(condition),
      mz_nm_(mz_nm),
      noise_nm_(noise_nm),
      options_(options) {
  set_num_residuals(1);
  mutable_parameter_block_sizes()->push_back(static_cast<int>(unknowns.size()));
}

bool MomentCost::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  const auto read = [&](const TyreCoefficients& tyre, double* out) {
    *out = (vehicle::tyre_forces(tyre, condition_, {}, options_).mz_nm - mz_nm_) / noise_nm_;
  };
  with_slopes<1>(unknowns_, parameters[0], 1, read, residuals, jacobians ? jacobians[0] : nullptr);
  return std::isfinite(*residuals);
}

GuardCost::GuardCost(const Unknowns& unknowns, const TyreCoefficients& reference,
                     const vehicle::TyreInput<double>& condition)
    : unknowns_(unknowns), condition_(condition) {
  set_num_residuals(4);
  mutable_parameter_block_sizes()->push_back(static_cast<int>(unknowns.size()));
  vehicle::TyreInput<double> nominal;
  nominal.fz_n = reference.nominal_load_n * reference.lfzo;
  nominal.vx_mps = reference.nominal_speed_mps;
  wanted_ = vehicle::tyre_forces(reference, nominal);
  // Stiffness goes to zero with the load; friction does not.
  share_ = kLeast * std::min(1.0, condition.fz_n / nominal.fz_n);
}

bool GuardCost::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  const auto lacks = [](double value, double whole, double share) {
    return 100.0 * std::max(0.0, share - value / whole);
  };
  const auto read = [&](const TyreCoefficients& tyre, double* out) {
    const auto force = vehicle::tyre_forces(tyre, condition_, {}, {.moments = false});
    out[0] = lacks(force.mu_x, wanted_.mu_x, kLeast);
    out[1] = lacks(force.mu_y, wanted_.mu_y, kLeast);
    out[2] = lacks(force.slip_stiffness_n, wanted_.slip_stiffness_n, share_);
    out[3] = lacks(force.cornering_stiffness_npr, wanted_.cornering_stiffness_npr, share_);
  };
  with_slopes<4>(unknowns_, parameters[0], 4, read, residuals, jacobians ? jacobians[0] : nullptr);
  return true;
}

PriorCost::PriorCost(std::size_t count) : count_(count) {
  set_num_residuals(static_cast<int>(count));
  mutable_parameter_block_sizes()->push_back(static_cast<int>(count));
}

bool PriorCost::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  std::copy_n(parameters[0], count_, residuals);
  if (jacobians && jacobians[0])
    for (std::size_t i = 0; i < count_ * count_; ++i)
      jacobians[0][i] = i % (count_ + 1) == 0 ? 1.0 : 0.0;
  return true;
}

}  // namespace identify
