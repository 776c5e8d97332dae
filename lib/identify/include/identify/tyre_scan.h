// Whether the curves of a tyre are such as a tyre can have, found by looking at them.
#pragma once

#include <string>
#include <vector>

#include "vehicle/magic_formula.h"

namespace identify {

/// Where a tyre is looked at.
struct TyreRange {
  double fz_low_n = 0.0, fz_high_n = 0.0;
  double gamma_low_rad = 0.0, gamma_high_rad = 0.0;
  double kappa_most = 1.0, tan_alpha_most = 0.6;
};

struct TyreFault {
  std::string what;  ///< in words
  double fz_n = 0.0, gamma_rad = 0.0;
};

/// Pure slip, both directions, at nine loads and three cambers: friction and stiffness are there,
/// the force rises to one peak, falls or stays behind it (a rise of 0.2 % of the peak is let
/// through) and does not turn its sign there. One fault for each load and camber at most, loads
/// ascending; empty: none found. The lower loads are not those below a tenth of the nominal load.
std::vector<TyreFault> scan_tyre(
    const vehicle::TyreCoefficients& tyre, const TyreRange& range,
    vehicle::AlphaConvention alpha = vehicle::AlphaConvention::kTangent);

/// Slip (tangent of the angle, or kappa) of the largest force of the upright tyre, both directions
/// together. kMostSlip: the force still rises there, and no peak is known.
inline constexpr double kMostSlip = 1.0;
double peak_slip(const vehicle::TyreCoefficients& tyre, vehicle::AlphaConvention alpha, double fz_n,
                 bool lateral);

}  // namespace identify
