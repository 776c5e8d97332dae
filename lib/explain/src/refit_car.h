// The whole simulated car refitted to recordings, with or without what was found.
#pragma once

#include <functional>
#include <vector>

#include "explain/simulate.h"

namespace explain {

/// Errors of a candidate on the laps that train, not scaled, channel by channel in turn; NaN where
/// a window has none. Always of the same length.
using TrainingErrors = std::function<std::vector<double>(const vehicle::CarFiles&,
                                                         const vehicle::Parameters<double>&)>;

/// The engine map times one plus a shape over throttle and speed: what no stated map has right. The
/// same four shapes as in the relations.
vehicle::Map2 shaped_engine_map(const vehicle::Map2& stated, const std::array<double, 4>& shape,
                                double limit_radps);

/// What makes the brakes stronger on measured pressures: friction of the pads, or the pistons' area
/// where a map gives the friction.
std::vector<vehicle::Parameter> brake_strength(const vehicle::Vehicle& car);

/// Gauss and Newton from the stated car: torque and shape of the engine map, drag, brakes,
/// cornering stiffness and grip of both axles with their prior widths, duration and engine control
/// of a shift. `worth`: one standard deviation of an error of each channel at least.
RefittedCar refitted(const vehicle::Vehicle& car, const TrainingErrors& errors,
                     const std::vector<double>& worth);

}  // namespace explain
