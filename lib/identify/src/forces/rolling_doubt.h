// Where slip 0 is: what the tyre file says of rolling wheels, and is not told by a log.
#pragma once

#include <array>
#include <vector>

#include "identify/forces.h"

namespace identify {

/// Widens the deviations of slip ratios. Wheel speeds tell the rolling radius of an axle over the
/// whole drive; how it changes from row to row, with load and speed, and by how much rolling
/// resistance makes a wheel slip where it works, is the tyre file's word, which may be off by
/// `share` of either; and warmth changes radii by a twentieth of a per cent. `radius_m`: rolling
/// radii by the tyre file, NaN where a row has no forces.
void add_rolling_doubt(const vehicle::Car<double>& car, double share,
                       const std::array<std::vector<double>, vehicle::kWheels>& radius_m,
                       Forces& out);

}  // namespace identify
