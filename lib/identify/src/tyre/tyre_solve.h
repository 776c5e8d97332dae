// From starts to the best solution of a fit of a tyre, and how far its rows are from it.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <functional>
#include <vector>

#include "identify/tyre_fit.h"
#include "tyre_costs.h"

namespace identify {

inline constexpr std::size_t kFewestRows = 30;  ///< of a stage
inline constexpr double kLossScale = 2.5;       ///< noise at which Cauchy's loss turns

struct Solved {
  std::vector<double> p;
  double cost = INFINITY;
};

/// The p that minimises what `add_rows(problem, loss, p)` adds, plus the distance to the reference,
/// within the bounds; from `p` on, which is put within them first.
Solved solve(const Unknowns& unknowns, std::vector<double> p, int rounds,
             const std::function<void(ceres::Problem&, ceres::LossFunction&, double*)>& add_rows);

/// The best of several starts: the reference, and curves around it. No solution: infinite cost.
struct Started {
  Solved best;
  int agreeing = 0;  ///< starts that came within 1 % of its cost
};
Started best_of_starts(const Unknowns& unknowns, SlipKind kind, const TyreFitOptions& options,
                       const std::function<Solved(std::vector<double>)>& solve_from);

/// The unknowns of a kind that the rows can tell: by Needs, and by the formula's version.
std::vector<const TyreUnknown*> list_of(SlipKind kind, const std::array<bool, 4>& varies,
                                        int version);

/// A row of one or two numbers at a solution: slopes by the unknowns, a column each, and what the
/// loss leaves of its weight.
struct CostAt {
  Eigen::MatrixXd slopes;
  double weight = 1.0;
};
CostAt cost_at(const TyreCost& cost, const std::vector<double>& p);

/// Robust sizes of what is left of measured values. `least`: a noiseless table must not be infinite
/// weight.
TyreResiduals residuals_of(const std::vector<double>& measured, const std::vector<double>& left,
                           double least);

/// Appends coefficients at p and their covariance, which is in spreads; beside what is there
/// already they count as independent.
void append_coefficients(TyreFit& fit, const Unknowns& unknowns, const std::vector<double>& p,
                         const Eigen::MatrixXd& covariance);

/// Fits what turns the fitted forces into the measured aligning moments, and appends stage,
/// coefficients and residuals to the fit. The forces stay: what they are off by is not in the
/// intervals of these coefficients.
void fit_aligning(const TyreSamples& rows, const vehicle::TyreCoefficients& reference,
                  const TyreFitOptions& options, TyreFit& fit);

}  // namespace identify
