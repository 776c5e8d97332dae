#include "identify/tyre_fit.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string_view>
#include <tuple>

#include "base/error.h"
#include "base/statistics.h"
#include "tyre_solve.h"
#include "tyre_varied.h"

namespace identify {
namespace {

using vehicle::TyreCoefficients;

constexpr double kPure = 0.02;  // slip below which a row is of pure slip
constexpr std::size_t kStageRows = 400, kFirstRows = 1500;
// Of a coefficient's spread, which is wide so that data can speak, where they cannot: a camber
// stiffness of a tenth of the cornering stiffness, as cars' tyres have.
constexpr double kConsidered = 0.5;
constexpr double kNoiseFloor = 2e-4;  // of the nominal load

struct Work {
  const TyreCoefficients& reference;
  const TyreFitOptions& options;
  vehicle::TyreOptions law;
  std::vector<vehicle::TyreInput<double>> guards;
};

/// The noise of one row.
Noise noise_of(const TyreSamples& rows, std::size_t i, const Noise& noise) {
  if (rows.fx_more.empty()) return noise;
  return {noise.fx_n * rows.fx_more[i], noise.fy_n * rows.fy_more[i]};
}

Solved solve(const Work& work, const Unknowns& unknowns, const TyreSamples& rows,
             const Noise& noise, std::vector<double> p, int rounds) {
  return solve(unknowns, std::move(p), rounds,
               [&](ceres::Problem& problem, ceres::LossFunction& loss, double* at) {
                 for (std::size_t i = 0; i < rows.rows(); ++i)
                   problem.AddResidualBlock(
                       new TyreCost(force_cost(unknowns, rows.conditions[i], rows.fx_n[i],
                                               rows.fy_n[i], noise_of(rows, i, noise), work.law)),
                       &loss, at);
                 for (const auto& guard : work.guards)
                   problem.AddResidualBlock(
                       new TyreCost(guard_cost(unknowns, work.reference, guard)), nullptr, at);
               });
}

double value_between(const std::vector<double>& values, double low, double high) {
  return values.empty() ? 0.0 : base::quantile(values, high) - base::quantile(values, low);
}

/// The rows of a stage, with the forces that it looks at.
TyreSamples rows_of(const TyreSamples& all, SlipKind kind) {
  TyreSamples out;
  for (std::size_t i = 0; i < all.rows(); ++i) {
    const auto& c = all.conditions[i];
    const bool slips = std::abs(c.kappa) > kPure, drifts = std::abs(c.tan_alpha) > kPure;
    const bool lateral = kind == SlipKind::kLateral && !slips;
    const bool longitudinal = kind == SlipKind::kLongitudinal && !drifts;
    const bool combined = kind == SlipKind::kCombined && slips && drifts;
    const double fx = longitudinal || combined ? all.fx_n[i] : NAN,
                 fy = lateral || combined ? all.fy_n[i] : NAN;
    if (std::isnan(fx) && std::isnan(fy)) continue;
    out.add_row(all, i);
    out.fx_n.back() = fx;
    out.fy_n.back() = fy;
  }
  return out;
}

std::string why_not(SlipKind kind, const TyreSamples& rows) {
  if (rows.rows() < kFewestRows)
    return fmt::format("{} rows of this kind, wanted at least {}", rows.rows(), kFewestRows);
  std::vector<double> slip;
  for (const auto& c : rows.conditions)
    slip.push_back(kind == SlipKind::kLongitudinal ? c.kappa : c.tan_alpha);
  const double range = value_between(slip, 0.05, 0.95);
  if (range < 0.01)
    return fmt::format("slip reaches over {:.4f} only, wanted at least 0.01", range);
  return "";
}

/// Robust sizes of what is left at `tyre`.
std::pair<TyreResiduals, TyreResiduals> force_residuals(const TyreSamples& rows,
                                                        const TyreCoefficients& tyre,
                                                        const vehicle::TyreOptions& law) {
  std::vector<double> fx, fy, fx_left, fy_left;
  for (std::size_t i = 0; i < rows.rows(); ++i) {
    const auto force = vehicle::tyre_forces(tyre, rows.conditions[i], {}, law);
    if (!std::isnan(rows.fx_n[i])) {
      fx.push_back(rows.fx_n[i]);
      fx_left.push_back(rows.fx_n[i] - force.fx_n);
    }
    if (!std::isnan(rows.fy_n[i])) {
      fy.push_back(rows.fy_n[i]);
      fy_left.push_back(rows.fy_n[i] - force.fy_n);
    }
  }
  const double least_n = kNoiseFloor * tyre.nominal_load_n;
  return {residuals_of(fx, fx_left, least_n), residuals_of(fy, fy_left, least_n)};
}

/// C, D and E of a curve, which slips far below its peak say nothing of.
bool is_of_peak(std::string_view keyword) {
  return (keyword[0] == 'P' && (keyword[1] == 'C' || keyword[1] == 'D' || keyword[1] == 'E')) ||
         keyword == "PPX3" || keyword == "PPX4" || keyword == "PPY3" || keyword == "PPY4";
}

/// Fits one kind of slip from several starts; moves `fit.tyre`.
TyreStage fit_stage(const Work& work, SlipKind kind, const TyreSamples& rows,
                    const std::vector<const TyreUnknown*>& list, TyreCoefficients& tyre) {
  TyreStage stage{kind, rows.rows(), work.options.starts, 0, {}};
  const TyreSamples few = thinned(rows, kStageRows);
  const Unknowns unknowns = unknowns_of(list, work.reference, tyre);
  const double begin_n = 0.01 * work.reference.nominal_load_n;
  const auto [best, agreeing] =
      best_of_starts(unknowns, kind, work.options, [&](std::vector<double> p) {
        return solve(work, unknowns, few, {begin_n, begin_n}, std::move(p), 40);
      });
  stage.agreeing = agreeing;
  if (!std::isfinite(best.cost)) {
    stage.why_not = "no start led anywhere";
    return stage;
  }
  const TyreCoefficients begun = unknowns.at(best.p.data());
  const auto [fx, fy] = force_residuals(few, begun, work.law);
  const Solved again = solve(work, unknowns, few, {fx.noise, fy.noise}, best.p, 40);
  tyre = std::isfinite(again.cost) ? unknowns.at(again.p.data()) : begun;
  return stage;
}

/// Covariance of p at the solution: what the loss leaves of every row, fewer where rows repeat each
/// other, and the prior; and what all forces may be off together, which no row more mends. From
/// `fitted` on, unknowns stay the reference's: their prior counts in what the others may be off by
/// (considered, not estimated).
Eigen::MatrixXd force_covariance(const Work& work, const Unknowns& unknowns, std::size_t fitted,
                                 const TyreSamples& rows, const TyreFit& fit,
                                 const std::vector<double>& p) {
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(n, n);
  // How far the fit moves by larger forces of either direction.
  Eigen::MatrixXd larger = Eigen::MatrixXd::Zero(n, 2);
  for (std::size_t i = 0; i < rows.rows(); ++i) {
    const Noise noise = noise_of(rows, i, {fit.fx.noise, fit.fy.noise});
    const CostAt cost = cost_at(
        force_cost(unknowns, rows.conditions[i], rows.fx_n[i], rows.fy_n[i], noise, work.law), p);
    for (Eigen::Index k = 0; k < cost.slopes.cols(); ++k) {
      const bool is_fx = k == 0 && !std::isnan(rows.fx_n[i]);
      const auto row = cost.slopes.col(k);
      const double counts = cost.weight / (is_fx ? fit.fx.repeats : fit.fy.repeats);
      normal.selfadjointView<Eigen::Lower>().rankUpdate(row, counts);
      const double force = is_fx ? rows.fx_n[i] * rows.fx_share / noise.fx_n
                                 : rows.fy_n[i] * rows.fy_share / noise.fy_n;
      larger.col(is_fx ? 0 : 1) += counts * force * row;
    }
  }
  normal = normal.selfadjointView<Eigen::Lower>();
  const auto f = static_cast<Eigen::Index>(fitted), c = n - f;
  const auto solver = normal.topLeftCorner(f, f).ldlt();
  const Eigen::MatrixXd moved = solver.solve(larger.topRows(f));
  Eigen::MatrixXd out = Eigen::MatrixXd::Identity(n, n);
  out.topLeftCorner(f, f) =
      solver.solve(Eigen::MatrixXd::Identity(f, f)) + moved * moved.transpose();
  if (c == 0) return out;
  const Eigen::MatrixXd by_others = -solver.solve(normal.topRightCorner(f, c));
  out.topLeftCorner(f, f) += by_others * by_others.transpose();
  out.topRightCorner(f, c) = by_others;
  out.bottomLeftCorner(c, f) = by_others.transpose();
  return out;
}

/// Forces and moments that run against the reference's are of other axes, which no fit mends.
void expect_same_signs(const TyreSamples& rows, const TyreCoefficients& reference,
                       vehicle::AlphaConvention alpha) {
  struct Sums {
    double sum = 0.0, size = 0.0;
    void add(double measured, double stated) {
      if (std::isnan(measured)) return;
      sum += stated * measured;
      size += std::abs(stated * measured);
    }
  } fx, fy, mz;
  for (std::size_t i = 0; i < rows.rows(); ++i) {
    const auto f = vehicle::tyre_forces(reference, rows.conditions[i], {}, {.alpha = alpha});
    fx.add(rows.fx_n[i], f.fx_n);
    fy.add(rows.fy_n[i], f.fy_n);
    if (!rows.mz_nm.empty()) mz.add(rows.mz_nm[i], f.mz_nm);
  }
  for (const auto& [sums, name, way_out] :
       {std::tuple{fx, "fx_n", "turn the sign of fx_n or kappa"},
        std::tuple{fy, "fy_n", "turn the sign of fy_n or alpha_rad"},
        std::tuple{mz, "mz_nm", "turn the sign of mz_nm, or leave the column out"}})
    if (sums.sum < -0.5 * sums.size)
      throw base::Error(
          fmt::format("{} runs against the reference's: other axes; {}", name, way_out));
}

/// Conditions at which the tyre must keep friction and stiffness.
std::vector<vehicle::TyreInput<double>> guards_for(const TyreSamples& rows,
                                                   const TyreCoefficients& tyre) {
  double load = 0.0, left = 0.0, right = 0.0;
  for (const auto& c : rows.conditions) {
    load = std::max(load, c.fz_n);
    left = std::min(left, c.gamma_rad);
    right = std::max(right, c.gamma_rad);
  }
  const double least = 0.1 * tyre.nominal_load_n, most = std::min(1.5 * load, tyre.fz_max_n);
  std::vector<vehicle::TyreInput<double>> out;
  for (int i = 0; i <= 6; ++i)
    for (const double camber : {left, 0.5 * (left + right), right})
      out.push_back({.fz_n = least + (most - least) * i / 6.0,
                     .gamma_rad = camber,
                     .vx_mps = tyre.nominal_speed_mps});
  return out;
}

}  // namespace

TyreFit fit_tyre(const TyreSamples& samples, const TyreCoefficients& reference,
                 const TyreFitOptions& options) {
  expect_same_signs(samples, reference, options.alpha);
  const TyreSamples rows = thinned(samples, std::max<std::size_t>(kFewestRows, options.most_rows));
  TyreFit fit;
  fit.tyre = reference;
  fit.alpha = options.alpha;
  fit.rows = rows.rows();
  // Loads above the file's last one are measured here, so that the formula has to hold there.
  for (const auto& c : samples.conditions) fit.tyre.fz_max_n = std::max(fit.tyre.fz_max_n, c.fz_n);
  const vehicle::TyreOptions law{.alpha = options.alpha, .moments = false};
  const Work work{reference, options, law, guards_for(rows, fit.tyre)};

  std::vector<const TyreUnknown*> all, considered;
  for (const SlipKind kind : {SlipKind::kLateral, SlipKind::kLongitudinal, SlipKind::kCombined}) {
    const TyreSamples part = rows_of(rows, kind);
    const TyreHold hold = options.hold[static_cast<std::size_t>(kind)];
    TyreStage stage{kind, part.rows(), 0, 0,
                    hold == TyreHold::kAll ? "it stays the reference's" : why_not(kind, part)};
    if (stage.why_not.empty()) {
      const Varied varies = varied(part, reference);
      auto list = list_of(kind, varies.by_need, reference.version);
      if (hold == TyreHold::kPeak) {
        const auto peak = std::stable_partition(
            list.begin(), list.end(), [](const TyreUnknown* u) { return !is_of_peak(u->keyword); });
        considered.insert(considered.end(), peak, list.end());
        list.erase(peak, list.end());
      }
      stage = fit_stage(work, kind, part, list, fit.tyre);
      if (stage.why_not.empty()) {
        all.insert(all.end(), list.begin(), list.end());
        if (varies.camber_follows) {
          const auto stay = list_of(kind, {false, false, true, false}, reference.version);
          considered.insert(considered.end(), stay.begin(), stay.end());
        }
      }
    }
    fit.stages.push_back(stage);
  }
  if (all.empty())
    throw base::Error(
        fmt::format("nothing to fit: side slip: {}; longitudinal slip: {}; combined: {}",
                    fit.stages[0].why_not, fit.stages[1].why_not, fit.stages[2].why_not));

  const Unknowns unknowns = unknowns_of(all, reference, fit.tyre);
  std::vector<double> p;
  for (std::size_t i = 0; i < all.size(); ++i)
    p.push_back((fit.tyre.*(all[i]->member) - unknowns.centre[i]) / unknowns.spread[i]);
  // The second round with all rows and the noise that the first left.
  const TyreSamples some = thinned(rows, kFirstRows);
  for (const TyreSamples* seen : {&some, &rows}) {
    std::tie(fit.fx, fit.fy) = force_residuals(rows, fit.tyre, law);
    const Solved solved = solve(work, unknowns, *seen, {fit.fx.noise, fit.fy.noise}, p, 100);
    if (!std::isfinite(solved.cost))
      throw base::Error("the fit does not settle; look at the rows for values of other units");
    p = solved.p;
    fit.tyre = unknowns.at(p.data());
  }
  std::tie(fit.fx, fit.fy) = force_residuals(rows, fit.tyre, law);
  const std::size_t fitted = all.size();
  all.insert(all.end(), considered.begin(), considered.end());
  p.resize(all.size(), 0.0);
  Unknowns both = unknowns_of(all, reference, fit.tyre);
  for (std::size_t i = fitted; i < all.size(); ++i) both.spread[i] *= kConsidered;
  append_coefficients(fit, both, p, force_covariance(work, both, fitted, rows, fit, p));
  fit.camber_follows = !considered.empty();
  if (!rows.mz_nm.empty()) fit_aligning(rows, reference, options, fit);
  return fit;
}

}  // namespace identify
