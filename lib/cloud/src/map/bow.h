// How a registered cloud bends or tilts against the base as a whole: half a wave over the block.
#pragma once

#include "cloud/map.h"
#include "height_cells.h"

namespace cloud {

/// Of the surface of second order in the plan that lies best in the heights over the base. On a
/// bend a dome is a tilt, so both count; a step of the whole does not.
struct Bow {
  double range_m = 0.0;  ///< from its lowest to its highest place on the road; 0: there is none
  double low_u_m = 0.0, high_u_m = 0.0;
};

/// `cells`: of the cloud as it lies. None where it is short, or where the surface leaves much of
/// the heights: then the road has places of its own.
Bow bow_of(const HeightCells& cells, const RoadFrame& frame);

/// Says it. Cloud and base may both be bent; only a trajectory could tell.
void look_at_bow(const Bow& bow, const MapOptions& options, MapReport& report);

}  // namespace cloud
