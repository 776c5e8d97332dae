// A flat road under a drive, for whoever has a log and no road.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "road/edges.h"

namespace road {

/// Where a car was, row by row; NaN: not known.
struct DrivenPlaces {
  std::string name;  ///< for messages
  std::vector<double> x_m, y_m;
};

struct DrivenRoadReport {
  EdgesReport edges;
  double length_m = 0.0;
  double gap_m = 0.0;  ///< across, from the end of the lap to its beginning, before it was closed
  double left_m = 0.0, right_m = 0.0;  ///< to the edges, where no bend is tighter
  std::size_t leaps = 0;               ///< places far from those before and after: left out
  double beside_share = 0.0;           ///< of the places that lie beside the road: pits, run-off
};

/// Height 0, along the lap whose end lies nearest to its beginning (guide_along()), in the
/// direction driven, smoothed over 30 m (a sixtieth of a short lap); an open way where none comes
/// back. As wide as all laps and 3 m more, at least 5 m to each side (less on a lap below 600 m, in
/// proportion). Throws Error naming the drive where it is none.
EdgeRoad road_under(const DrivenPlaces& drive, DrivenRoadReport* report = nullptr);

}  // namespace road
