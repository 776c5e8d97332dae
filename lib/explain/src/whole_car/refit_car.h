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

/// Gauss and Newton from the stated car: torque and shape of the engine map, drag, brakes,
/// cornering stiffness and grip of both axles with their prior widths, duration and engine control
/// of a shift. `worth`: one standard deviation of an error of each channel at least. `errors` is
/// asked from two threads. `alike`: a car whose slopes are taken where they are of as many errors;
/// or null.
RefittedCar refitted(const vehicle::Vehicle& car, const TrainingErrors& errors,
                     const std::vector<double>& worth, const RefittedCar* alike);

}  // namespace explain
