// What the measurements of a tyre reach: which conditions are filled, which peaks were passed, and
// what should be measured next.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "identify/tyre_fit.h"
#include "identify/tyre_scan.h"

namespace identify {

// Edges of the cells; the last of each is open.
inline constexpr std::array<double, 5> kLoadEdges{0.0, 0.5, 0.85, 1.2,
                                                  1.6};  ///< of the nominal load
inline constexpr std::array<double, 5> kCamberEdges_deg{-90.0, -3.0, -1.0, 1.0, 3.0};
/// Slip over that of the fitted peak at that load, upright; combined: root of the sum of squares.
inline constexpr std::array<double, 4> kSlipEdges{0.0, 0.35, 0.75, 1.05};

/// Rows in each cell; slip of kinds kLateral, kLongitudinal and kCombined, a tenth of the other
/// direction's peak being the limit of purity.
struct ConditionCell {
  SlipKind kind = SlipKind::kLateral;
  std::size_t load = 0, camber = 0, slip = 0;  ///< indices of the lower edges
  std::size_t rows = 0;
  double fx_left_n = NAN, fy_left_n = NAN;  ///< root mean square of measured less fitted force
};

/// A peak of a fitted curve of pure slip, and whether the rows went past it.
struct PeakReach {
  SlipKind kind = SlipKind::kLateral;
  std::size_t load = 0;
  double peak_slip =
      0.0;  ///< tan alpha or kappa, of the upright tyre in the middle of the load cell
  double measured_slip = 0.0;  ///< the largest, 99 % of the rows below
  double peak_n = 0.0, sd_n = 0.0;
  /// False: the force is known up to the measured slip, and the fitted peak is no more than a bound
  /// with what the reference tyre says. A peak_slip of kMostSlip: the fitted force only rises.
  bool reached = false;
};

/// The condition at which a row more would tell most, of loads, cambers and slips within the range.
struct NextMeasurement {
  SlipKind kind = SlipKind::kLateral;
  vehicle::TyreInput<double> condition;
  double force_n = 0.0, sd_n = 0.0;  ///< of the fitted force with the larger standard deviation
};

struct TyreConditions {
  TyreRange measured;                ///< loads and cambers of the rows
  std::vector<ConditionCell> cells;  ///< every one, in the order of kind, load, camber, slip
  std::vector<PeakReach> peaks;      ///< load cells with rows of a kind that was fitted
  NextMeasurement next;
};

TyreConditions tyre_conditions(const TyreFit& fit, const TyreSamples& samples);

}  // namespace identify
