
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tyre_solve.h"
#include "tyre_varied.h"

namespace identify {
namespace {

using vehicle::TyreCoefficients;

constexpr std::size_t kFewRows = 400;
constexpr double kCombined = 0.02;    // slip of both directions above which the force's arm shows
constexpr double kLeastNoise = 1e-4;  // of the nominal load times the radius

TyreSamples with_moment(const TyreSamples& all) {
  TyreSamples out;
  for (std::size_t i = 0; i < all.rows(); ++i)
    if (!std::isnan(all.mz_nm[i])) out.add_row(all, i);
  return out;
}

std::vector<const TyreUnknown*> unknowns_for(const TyreSamples& rows,
                                             const TyreCoefficients& reference) {
  const Varied varies = varied(rows, reference);
  auto out = list_of(SlipKind::kAligning, varies.by_need, reference.version);
  const auto combined = std::count_if(
      rows.conditions.begin(), rows.conditions.end(), [](const vehicle::TyreInput<double>& c) {
        return std::abs(c.kappa) > kCombined && std::abs(c.tan_alpha) > kCombined;
      });
  if (static_cast<std::size_t>(combined) < kFewestRows) return out;
  const auto arm = list_of(SlipKind::kAligningArm, varies.by_need, reference.version);
  out.insert(out.end(), arm.begin(), arm.end());
  return out;
}

TyreResiduals moment_residuals(const TyreSamples& rows, const TyreCoefficients& tyre,
                               const vehicle::TyreOptions& law) {
  std::vector<double> left;
  for (std::size_t i = 0; i < rows.rows(); ++i)
    left.push_back(rows.mz_nm[i] - vehicle::tyre_forces(tyre, rows.conditions[i], {}, law).mz_nm);
  return residuals_of(rows.mz_nm, left, kLeastNoise * tyre.nominal_load_n * tyre.unloaded_radius_m);
}

/// In spreads: what the loss leaves of every row, fewer where rows repeat each other, and the
/// prior.
Eigen::MatrixXd moment_covariance(const Unknowns& unknowns, const TyreSamples& rows,
                                  const TyreResiduals& mz, const vehicle::TyreOptions& law,
                                  const std::vector<double>& p) {
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(n, n);
  for (std::size_t i = 0; i < rows.rows(); ++i) {
    const CostAt cost =
        cost_at(moment_cost(unknowns, rows.conditions[i], rows.mz_nm[i], mz.noise, law), p);
    normal.selfadjointView<Eigen::Lower>().rankUpdate(cost.slopes.col(0), cost.weight / mz.repeats);
  }
  normal = normal.selfadjointView<Eigen::Lower>();
  return normal.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
}

}  // namespace

void fit_aligning(const TyreSamples& all, const TyreCoefficients& reference,
                  const TyreFitOptions& options, TyreFit& fit) {
  const TyreSamples rows = with_moment(all);
  TyreStage& stage =
      fit.stages.emplace_back(TyreStage{SlipKind::kAligning, rows.rows(), options.starts, 0, {}});
  if (rows.rows() < kFewestRows) {
    stage.why_not =
        fmt::format("{} rows with a moment, wanted at least {}", rows.rows(), kFewestRows);
    return;
  }
  const vehicle::TyreOptions law{.alpha = options.alpha};
  const Unknowns unknowns = unknowns_of(unknowns_for(rows, reference), reference, fit.tyre);
  const auto solve_with = [&](const TyreSamples& some, double noise_nm, std::vector<double> p) {
    return solve(unknowns, std::move(p), 60,
                 [&](ceres::Problem& problem, ceres::LossFunction& loss, double* at) {
                   for (std::size_t i = 0; i < some.rows(); ++i)
                     problem.AddResidualBlock(
                         new TyreCost(moment_cost(unknowns, some.conditions[i], some.mz_nm[i],
                                                  noise_nm, law)),
                         &loss, at);
                 });
  };
  const TyreSamples few = thinned(rows, kFewRows);
  const double begin_nm =
      100.0 * kLeastNoise * reference.nominal_load_n * reference.unloaded_radius_m;
  auto [solved, agreeing] = best_of_starts(
      unknowns, SlipKind::kAligning, options,
      [&](std::vector<double> p) { return solve_with(few, begin_nm, std::move(p)); });
  stage.agreeing = agreeing;
  // The second round by the noise that the first left.
  for (const TyreSamples* seen : {&few, &rows}) {
    if (!std::isfinite(solved.cost)) break;
    const double noise_nm = moment_residuals(rows, unknowns.at(solved.p.data()), law).noise;
    solved = solve_with(*seen, noise_nm, solved.p);
  }
  if (!std::isfinite(solved.cost)) {
    stage.why_not = "no start led anywhere";
    return;
  }
  fit.tyre = unknowns.at(solved.p.data());
  fit.mz = moment_residuals(rows, fit.tyre, law);
  append_coefficients(fit, unknowns, solved.p,
                      moment_covariance(unknowns, rows, fit.mz, law, solved.p));
}

}  // namespace identify
