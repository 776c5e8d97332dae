// What the stated third car has beyond the second.
#pragma once

#include "random.h"
#include "stated.h"

namespace trials {

/// Posts, motor and one gear, actuators, drag's height and tyres: `share` off at most, dampers and
/// roll inertia five times that.
void state_electric(StatedCar& car, const TruthCar& truth, Random& dice, double share);

/// The Magic Formula of a tyre of the third car, fitted as that of the second.
const TyreFit& electric_fit(TyreLaw law);

}  // namespace trials
