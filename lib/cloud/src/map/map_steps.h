// A map step by step: the scans are read for one purpose, then everything is done that needs no
// points, until they have to be read again. One process may do it all, or several may read parts
// of the scans and one joins what they say.
#pragma once

#include <functional>
#include <optional>

#include "changed_ground.h"
#include "cloud/map.h"
#include "drift.h"
#include "fuse.h"
#include "height_cells.h"

namespace cloud {

/// What the scans are read for, in this order.
enum class MapStep : std::uint8_t { look, look_again, look_turned_back, heights, done };

/// What does not change from step to step.
struct MapInputs {
  const RoadFrame& frame;
  const crg::Grid& base;
  const RoadTrajectory* placed;  ///< as it was given; null: points are in the map frame
  const MapOptions& options;
  bool visits_known = false;  ///< the scans are a part of all (look_at)
};

/// Where a map stands before a step.
struct MapState {
  MapStep step = MapStep::look;
  bool due = true;       ///< false: the scans need not be read in this step
  RoadTrajectory poses;  ///< with the drift taken out that is known so far
  std::vector<Correction> taken_out;
  std::optional<double> base_tilt;
  // Since the drift is known:
  Sections sections;  ///< what was last looked at
  Drift drift;        ///< what is left of it in `poses`, before the last was taken out
  ChangedGround changed;
  HeightCells surface;
  std::optional<HeightCells> older;  ///< before the ground changed; none where that is not kept
  MapReport report;
};

/// What reading the scans, or a part of them, gives in a step.
struct Reading {
  std::optional<Look> look;
  std::optional<RoadSums> sums, older;
};

MapState first_state(const MapInputs& inputs);

/// Reads for the step that `state` is before; nothing where that is not due. `times` is told what
/// it took.
Reading read_for(const MapState& state, const CloudSource& scans, const MapInputs& inputs,
                 MapReport& times);

/// Adds what another part of the scans gave in the same step.
void join(Reading& all, Reading&& part);

/// From what all scans gave to the state before the next step; after the heights to the result.
/// Throws Error as map_clouds(), Misfit where scans and base do not fit.
void advance(MapState& state, Reading&& reading, const MapInputs& inputs, MapResult& result);

/// Does `work`, which answers with a result or, between steps, with an empty one. Where scans and
/// base do not fit, or the road must not be used, says what may be wrong as well.
MapResult with_causes(const CloudSource& scans, const RoadFrame& frame,
                      const Trajectory* trajectory, const MapOptions& options,
                      const std::function<MapResult()>& work);

}  // namespace cloud
