#include "tyre_solve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "base/parallel.h"
#include "base/random.h"
#include "base/statistics.h"
#include "identify/clustered_fit.h"

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

Solved solve(const Unknowns& unknowns, std::vector<double> p, int rounds,
             const std::function<void(ceres::Problem&, ceres::LossFunction&, double*)>& add_rows) {
  ceres::CauchyLoss loss(kLossScale);  // rows share it
  ceres::Problem::Options owned;
  owned.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(owned);
  add_rows(problem, loss, p.data());
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  problem.AddResidualBlock(
      new ceres::NormalPrior(ceres::Matrix::Identity(n, n), ceres::Vector::Zero(n)), nullptr,
      p.data());
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    problem.SetParameterLowerBound(p.data(), static_cast<int>(i), unknowns.low(i));
    problem.SetParameterUpperBound(p.data(), static_cast<int>(i), unknowns.high(i));
    p[i] = std::clamp(p[i], unknowns.low(i), unknowns.high(i));
  }
  ceres::Solver::Options options = one_thread(rounds);
  options.function_tolerance = 1e-8;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return {std::move(p), summary.IsSolutionUsable() ? summary.final_cost : INFINITY};
}

Started best_of_starts(const Unknowns& unknowns, SlipKind kind, const TyreFitOptions& options,
                       const std::function<Solved(std::vector<double>)>& solve_from) {
  const auto count = static_cast<std::size_t>(std::max(1, options.starts));
  std::vector<Solved> solved(count);
  base::parallel_for(count, 1, options.threads, [&](std::size_t from, std::size_t to) {
    for (std::size_t s = from; s < to; ++s) {
      base::Random random(options.seed * 1000003u +
                          std::uint64_t{101} * static_cast<unsigned>(kind) + s);
      std::vector<double> p(unknowns.size(), 0.0);
      if (s > 0)
        for (std::size_t i = 0; i < p.size(); ++i)
          if (unknowns.list[i]->needs == Needs::kSlip)
            p[i] = std::clamp(1.2 * random.normal(), unknowns.low(i), unknowns.high(i));
      solved[s] = solve_from(p);
    }
  });
  Started out{*std::min_element(solved.begin(), solved.end(),
                                [](const auto& a, const auto& b) { return a.cost < b.cost; })};
  for (const Solved& one : solved)
    if (one.cost <= 1.01 * out.best.cost + 1e-9) ++out.agreeing;
  return out;
}

std::vector<const TyreUnknown*> list_of(SlipKind kind, const std::array<bool, 4>& varies,
                                        int version) {
  std::vector<const TyreUnknown*> out;
  for (const TyreUnknown& one : tyre_unknowns())
    if (one.kind == kind && varies[static_cast<std::size_t>(one.needs)] &&
        (version == 52 ? one.in_52 : one.in_6x))
      out.push_back(&one);
  return out;
}

CostAt cost_at(const TyreCost& cost, const std::vector<double>& p) {
  CostAt out;
  out.slopes.resize(static_cast<Eigen::Index>(p.size()), cost.num_residuals());
  const double* parameters[] = {p.data()};
  double* jacobians[] = {out.slopes.data()};
  Eigen::VectorXd left = Eigen::VectorXd::Zero(cost.num_residuals());
  cost.Evaluate(parameters, left.data(), jacobians);
  out.weight = 1.0 / (1.0 + left.squaredNorm() / (kLossScale * kLossScale));
  return out;
}

TyreResiduals residuals_of(const std::vector<double>& measured, const std::vector<double>& left,
                           double least) {
  TyreResiduals out;
  out.rows = left.size();
  out.noise = least;
  if (left.empty()) return out;
  const auto count = static_cast<double>(left.size());
  std::vector<double> size;
  double left2 = 0.0, measured2 = 0.0;
  for (std::size_t i = 0; i < left.size(); ++i) {
    size.push_back(std::abs(left[i]));
    left2 += left[i] * left[i];
    measured2 += measured[i] * measured[i];
  }
  out.size = std::sqrt(measured2 / count);
  out.rms = std::sqrt(left2 / count);
  out.noise = std::max(least, 1.4826 * base::median(size));
  double near2 = 0.0, product = 0.0, far = 0.0;
  const double most = 4.0 * out.noise;
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (size[i] > most) far += 1.0;
    if (i == 0 || size[i] > most || size[i - 1] > most) continue;
    near2 += 0.5 * (left[i] * left[i] + left[i - 1] * left[i - 1]);
    product += left[i] * left[i - 1];
  }
  out.far = far / count;
  out.repeats = rows_as_one(product, near2);
  return out;
}

void append_coefficients(TyreFit& fit, const Unknowns& unknowns, const std::vector<double>& p,
                         const Eigen::MatrixXd& covariance) {
  const std::size_t before = fit.coefficients.size(), n = before + unknowns.size();
  std::vector<double> all(n * n, 0.0);
  for (std::size_t i = 0; i < before; ++i)
    std::copy_n(&fit.covariance[i * before], before, &all[i * n]);
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto ii = static_cast<Eigen::Index>(i);
    FittedCoefficient one;
    one.keyword = unknowns.list[i]->keyword;
    one.kind = unknowns.list[i]->kind;
    one.value = unknowns.value(i, p[i]);
    one.reference = unknowns.centre[i];
    const double variance = covariance(ii, ii);
    one.sd = unknowns.spread[i] * std::sqrt(std::max(0.0, variance));
    one.from_data = std::clamp(1.0 - variance, 0.0, 1.0);
    one.at_bound = p[i] < unknowns.low(i) + 1e-6 || p[i] > unknowns.high(i) - 1e-6;
    fit.coefficients.push_back(one);
    for (std::size_t j = 0; j < unknowns.size(); ++j)
      all[(before + i) * n + before + j] =
          unknowns.spread[i] * unknowns.spread[j] * covariance(ii, static_cast<Eigen::Index>(j));
  }
  fit.covariance = std::move(all);
}

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
