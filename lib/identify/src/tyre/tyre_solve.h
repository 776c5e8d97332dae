// What the fit of a tyre minimises, term by term, for Ceres; from starts to the best solution, and
// how far its rows are from it.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "identify/tyre_fit.h"
#include "one_thread.h"
#include "vehicle/magic_formula.h"

namespace identify {

/// Coefficients as the optimiser sees them: distances to the reference in spreads.
struct Unknowns {
  std::vector<const TyreUnknown*> list;
  std::vector<double> spread, centre;
  vehicle::TyreCoefficients rest;  ///< values of all others

  std::size_t size() const { return list.size(); }
  double value(std::size_t i, double p) const { return centre[i] + spread[i] * p; }
  vehicle::TyreCoefficients at(const double* p) const {
    vehicle::TyreCoefficients out = rest;
    for (std::size_t i = 0; i < size(); ++i) out.*(list[i]->member) = value(i, p[i]);
    return out;
  }
  double low(std::size_t i) const {
    return (std::min(list[i]->low, centre[i]) - centre[i]) / spread[i];
  }
  double high(std::size_t i) const {
    return (std::max(list[i]->high, centre[i]) - centre[i]) / spread[i];
  }
};

/// The unknowns of a fit about the reference; `rest` has the values of all others.
Unknowns unknowns_of(const std::vector<const TyreUnknown*>& list,
                     const vehicle::TyreCoefficients& reference,
                     const vehicle::TyreCoefficients& rest);

/// Standard deviations of measured forces.
struct Noise {
  double fx_n, fy_n;
};

/// One row: up to four numbers that a tyre leaves, with their slopes by central differences. The
/// unknowns must outlive it.
class TyreCost : public ceres::CostFunction {
 public:
  using Read = std::function<void(const vehicle::TyreCoefficients& tyre, double* left)>;
  TyreCost(const Unknowns& unknowns, std::size_t count, Read read);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Unknowns& unknowns_;
  std::size_t count_;
  Read read_;
};

/// Forces over their noise; a NaN force is not measured.
TyreCost force_cost(const Unknowns& unknowns, const vehicle::TyreInput<double>& condition,
                    double fx_n, double fy_n, const Noise& noise,
                    const vehicle::TyreOptions& options);

/// An aligning moment over its noise.
TyreCost moment_cost(const Unknowns& unknowns, const vehicle::TyreInput<double>& condition,
                     double mz_nm, double noise_nm, const vehicle::TyreOptions& options);

/// Friction and stiffness at one load and camber, as far as they are below what must be left of the
/// reference's at its nominal load.
TyreCost guard_cost(const Unknowns& unknowns, const vehicle::TyreCoefficients& reference,
                    const vehicle::TyreInput<double>& condition);

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
