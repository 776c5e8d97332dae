// The coefficients of the Magic Formula that a fit of forces and aligning moments may change.
#pragma once

#include <span>

#include "vehicle/tyre_file.h"

namespace identify {

/// Which slips a coefficient belongs to; of the aligning moment: to any, or to the arm of the
/// longitudinal force, which shows in combined slip.
enum class SlipKind { kLateral, kLongitudinal, kCombined, kAligning, kAligningArm };

/// What has to vary in the data, beside the slip, for a coefficient to be found.
enum class Needs { kSlip, kLoad, kCamber, kPressure };

struct TyreUnknown {
  const char* keyword;  ///< in the .tir file
  double vehicle::TyreCoefficients::*member;
  SlipKind kind;
  Needs needs;
  /// Standard deviation of what is believed before the data about the distance to the reference
  /// tyre; that of a coefficient with a large value is half the value.
  double spread;
  double low, high;   ///< bounds; a reference outside moves them
  bool in_52, in_6x;  ///< versions of the formula that have it
};

/// All of them, in the order of their kinds.
std::span<const TyreUnknown> tyre_unknowns();

}  // namespace identify
