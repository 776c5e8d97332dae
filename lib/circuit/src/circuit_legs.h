// Where the legs of a circuit meet: the run-off of each ends at the middle. Private to the circuit.
#pragma once

#include "circuit_surface.h"

namespace road {

/// Tables of the curve and of the middles are this far apart, in metres.
inline constexpr double kMiddleStepM = 0.5;

/// Fills curve, middles and reach. Throws Error where the road itself meets another part of it.
void find_middles(Circuit::Data& data);

}  // namespace road
