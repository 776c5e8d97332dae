// Where satellites saw the car, in the plane of a road.
#pragma once

#include "recording/recording.h"
#include "recording/table.h"

namespace recording {

/// Where the mapping takes columns for latitude_rad and longitude_rad and none for x_m and y_m:
/// adds "east of origin" and "north of origin" [m] to the table, and maps them in place of the two.
/// They lie in the plane that touches the WGS84 ellipsoid at the mapping's origin, x east, y north
/// (exact: by way of Earth-centred coordinates, heights taken as 0; 300 m of true height stretch it
/// by 5e-5), turned by `place_turn_rad` about the origin and then shifted by `place_x_m`,
/// `place_y_m`. Throws Error when the mapping states no origin.
void put_on_plane(Table& log, Mapping& mapping, const std::string& name);

}  // namespace recording
