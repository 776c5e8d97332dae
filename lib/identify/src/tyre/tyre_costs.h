// What the fit of a tyre minimises, term by term, for Ceres.
#pragma once

#include <algorithm>
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

}  // namespace identify
