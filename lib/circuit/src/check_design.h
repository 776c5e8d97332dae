// What a design may not say, whatever its plan. Private to the circuit.
#pragma once

#include "circuit/circuit.h"

namespace road {

/// Knots, kerbs, bumps and scenery of a circuit whose curve is `length_m` long. Throws Error naming
/// the value.
void check_design(const CircuitDesign& design, double length_m);

}  // namespace road
