// Tyres of the third car: a brush whose friction falls with sliding, or a table as from a test rig.
#pragma once

#include "electric.h"

namespace trials {

/// A tyre at its nominal load.
struct ElectricTyre {
  TyreLaw law = TyreLaw::kBrush;
  double load_n = 0, mu = 0, mu_load = 0;  ///< peak across, its loss per relative load
  double along = 0, across = 0;            ///< slip stiffnesses over load
};
struct TyreForce {
  double x, y;
};

/// Over slip and the tangent of the slip angle. The stiffness along grows faster than the load,
/// that across slower, by `sensitivity` of what this tyre does (0: all in proportion to the load).
TyreForce electric_tyre(const ElectricTyre& tyre, double load_n, double sensitivity, double kappa,
                        double tan_alpha);

}  // namespace trials
