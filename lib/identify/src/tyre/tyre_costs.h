// What the fit of a tyre minimises, term by term, for Ceres.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "identify/tyre_unknowns.h"
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

/// One row's forces over their noise; a NaN force is not measured. The unknowns must outlive it.
class RowCost : public ceres::CostFunction {
 public:
  RowCost(const Unknowns& unknowns, const vehicle::TyreInput<double>& condition, double fx_n,
          double fy_n, const Noise& noise, const vehicle::TyreOptions& options);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Unknowns& unknowns_;
  vehicle::TyreInput<double> condition_;
  double fx_n_, fy_n_;
  Noise noise_;
  vehicle::TyreOptions options_;
  std::size_t count_;
};

/// One row's aligning moment over its noise. The unknowns must outlive it.
class MomentCost : public ceres::CostFunction {
 public:
  MomentCost(const Unknowns& unknowns, const vehicle::TyreInput<double>& condition, double mz_nm,
             double noise_nm, const vehicle::TyreOptions& options);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Unknowns& unknowns_;
  vehicle::TyreInput<double> condition_;
  double mz_nm_, noise_nm_;
  vehicle::TyreOptions options_;
};

/// Friction and stiffness at one load and camber, as far as they are below what must be left of the
/// reference's at its nominal load. The unknowns must outlive it.
class GuardCost : public ceres::CostFunction {
 public:
  GuardCost(const Unknowns& unknowns, const vehicle::TyreCoefficients& reference,
            const vehicle::TyreInput<double>& condition);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const Unknowns& unknowns_;
  vehicle::TyreInput<double> condition_;
  vehicle::TyreForces<double> wanted_;
  double share_;
};

/// The distance to the reference, in spreads.
class PriorCost : public ceres::CostFunction {
 public:
  explicit PriorCost(std::size_t count);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  std::size_t count_;
};

}  // namespace identify
