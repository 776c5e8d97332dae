// Refines the grid of a road from LiDAR: drift along the road corrected, heights per node estimated
// and fused with the base by variance.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cloud/map_options.h"
#include "cloud/read_cloud.h"
#include "cloud/road_frame.h"
#include "cloud/trajectory.h"
#include "crg/file.h"

namespace cloud {

/// What a node of the refined grid rests on.
/// blended: the base, moved by what the nearest node with points differs from it, less and less
/// over MapOptions::blend_m.
enum class NodeSource : std::uint8_t { hole, base, lidar, interpolated, blended };

/// Grids as those of MapResult: where the ground changed between passes, that before the change.
struct OlderRoad {
  crg::Grid grid, stddev, source;
};

struct MapResult {
  crg::Grid grid;    ///< refined heights; nodes without points keep the base's bits
  crg::Grid stddev;  ///< m, same shape; NaN on holes
  crg::Grid source;  ///< NodeSource as a number, same shape
  std::vector<Trajectory> corrected;  ///< the trajectory after correction; empty without one
  MapReport report;
  /// With MapOptions::keep_older, where the ground changed.
  std::optional<OlderRoad> older = std::nullopt;
};

/// The whole way. `base`: the road to refine; `trajectory` null: points are in the map frame, else
/// in the sensor's with a time each. Memory depends on the road and the distance driven, not on the
/// number of points. Throws Error: no time per point, clock or frame of the trajectory does
/// not fit, no overlap with the base (and what it looks like), crg::Error.
MapResult map_clouds(const CloudSource& scans, const crg::Crg& base, const Trajectory* trajectory,
                     const MapOptions& options = {});

/// The report as JSON, keys in a fixed order (docs/formats.md): the same bytes for the same inputs;
/// the seconds, which differ from run to run, in a text of their own.
std::string map_summary_json(const MapReport& report);
std::string map_timing_json(const MapReport& report);

}  // namespace cloud
