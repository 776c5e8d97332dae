// Tells the road from its verge before anything is estimated.
#pragma once

#include "sections.h"

namespace cloud {

/// Grass scatters, asphalt does not. What the road under the wheels scatters, at each angle at
/// which the sensor looks at it, is the measure: per 10 m of road and 0.5 m across, cells that
/// scatter more (about a plane of their own, so that an error of the base is no scatter) are grass.
/// A narrow run of such cells with calm ones on both sides, or where the base itself bends, is a
/// kerb. Cells on grass go; those beyond it stay with `beyond` set: they say where the surface is,
/// and nothing about the trajectory. Without a trajectory the calmest quarter of the columns, or
/// the middle of the road, is the measure. `drifting`: the trajectory is as it came, so that
/// asphalt seems to scatter, too. Columns with few cells are judged with those of 50 m before and
/// behind. Grass too low to be told column by column stays, `beyond` and with the excess_m2 of the
/// verge as a whole. Columns up to `edge_m` to both sides of the line are none. Returns how many
/// points lay on grass.
std::size_t leave_out_verge(Sections& sections, const RoadFrame& frame, bool drifting,
                            double edge_m);

}  // namespace cloud
