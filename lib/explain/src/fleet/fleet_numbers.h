// Every number of its own that decides in a fleet what counts and whose it is; those that it shares
// with the search of one car stand in selection.h.
#pragma once

#include "fleet_joint.h"

namespace explain::fleet_numbers {

/// Sizes that are tried, in steps of the kind.
inline constexpr double kSizes[] = {0.03, 0.1, 0.3, 1.0, 3.0, 10.0};

/// Sizes are chosen on so many cars, evenly taken.
inline constexpr std::size_t kCarsForSizes = 12;

/// Cars are left out one by one, or in so many groups.
inline constexpr std::size_t kGroups = 40;

/// Standard deviations of what the simulation gets wrong in all cars alike, where forces alone show
/// a kind, and where an accelerometer feels it; and what then counts at least. From: banking by
/// forces, eight cars of one kind with nothing missing; the others: judgement. Shown by: Summary.
inline constexpr Sizes kFormOfForces{0.006, 0.003, 0.0002, 0.1},
    kFormFelt{0.002, 0.0015, 0.00007, 0.1};
inline constexpr Sizes kLeastByForces{0.015, 0.01, 0.0005, 0.15};

/// Mechanisms and parameters at most, beside three a car.
inline constexpr std::size_t kMostNamed = 12;

/// Deviations (of that and of its own) from which one knot of the road is more than what the
/// simulation gets wrong. From: eight cars with nothing missing reached 3. Shown by: FleetScale.
inline constexpr double kLargest = 4.0;

}  // namespace explain::fleet_numbers
