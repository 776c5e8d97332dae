// The reference tyre as large, as stiff and as grippy as another.
#pragma once

#include <string>

#include "vehicle/data_sheet.h"

namespace vehicle {

/// What a tyre is scaled to.
struct TyreScale {
  std::string name;  ///< as the sheet has it
  TyreSize size;
  double nominal_n = 0.0;  ///< load at which its coefficients hold
  double static_n = 0.0;   ///< of the standing car
  double grip = 1.0;       ///< peak side friction at that load
  double stiffness = 1.0;  ///< cornering and slip stiffness over load, of the reference's
  double mass_kg = 10.0;
  std::string grip_source;  ///< where the grip is from
};

/// vehicles/open_wheel/front.tir with other values: the text of a tyre file.
std::string scaled_tyre(const TyreScale& scale);

/// That file, as it was when this was built.
const char* reference_tyre_text();

}  // namespace vehicle
