// The written file against the mesh it came from.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mesh/mesh.h"
#include "road/align.h"
#include "road/road_edges.h"

namespace crg {
class Surface;
}

namespace road {

class RaySurface;

struct ValidateOptions {
  std::size_t points = 20000;  ///< random (u, v) between the nodes, not on them
  std::uint64_t seed = 1;
  double named_error_m = 0.015;  ///< places with a larger error are named one by one
  double reach_m = 1.0;          ///< a mesh surface further than this above or below does not count
  RotoTranslation T_global_mesh;  ///< how the file was moved against the mesh
  RoadEdges edges;                ///< of the rows of the file: limits hold between them
  unsigned threads = 0;           ///< 0 = all cores; any number gives the same answer
};

/// A stretch where the file leaves the mesh by more than ValidateOptions::named_error_m, and why.
struct RoughPlace {
  double u_begin_m = 0.0, u_end_m = 0.0, v_min_m = 0.0, v_max_m = 0.0;
  double largest_error_m = 0.0;
  std::string reason;
  double worst_u_m = 0.0, worst_v_m = 0.0;  ///< where the error is the largest
  double worst_error_m = 0.0;               ///< file - mesh there
};

struct ErrorQuantiles {
  double p50 = 0, p95 = 0, p99 = 0, max = 0;
};

struct ValidateReport {
  /// |file - mesh|. Shares of the random points; max is the largest found anywhere, those of
  /// rough_places among it.
  ErrorQuantiles z_error_m;
  double mean_error_m = 0.0;            ///< signed, file - mesh
  std::size_t points = 0;               ///< compared
  std::size_t points_without_mesh = 0;  ///< file has z, mesh has nothing within reach
  /// Of the points between the edges alone: what the limits hold for.
  std::size_t road_points = 0, road_points_without_mesh = 0;
  double road_error_p99_m = 0.0;
  double worst_u_m = 0.0, worst_v_m = 0.0,
         worst_error_m = 0.0;  ///< where max is; file - mesh there
  double seam_z_step_m = 0.0;  ///< closed roads: largest |z(last row) - z(first row)|
  double seam_heading_step_rad = 0.0;
  /// Ascending in u_begin_m. Looked for at every random point, inside the cells of the grid at
  /// whose nodes the heights bend by a third of named_error_m (16 a row), and in the middle of
  /// every cell of the rows 0.5 m apart: what is shorter than that or narrower than a cell, and
  /// touches no node, is found by the random points only.
  std::vector<RoughPlace> rough_places;
  std::vector<std::string>
      doubts;  ///< why the line may not be the road (make/plausible.h); each fails the validation
  std::vector<std::string> remarks;
};

/// Beyond these a file must not be used: validation fails (exit code 3 of crgbuild). They catch a
/// road that is wrong, not one that is coarse: a 20 cm kerb on a 0.1 m grid stays below.
struct ValidateLimits {
  double max_z_error_p99_m = 0.05;
  double max_share_without_mesh = 0.001;  ///< of the points compared
  double max_seam_z_step_m = 0.01;
};

/// Re-reads `crg_path` and compares z with vertical rays on `original` (all of it, before
/// cleaning).
ValidateReport validate(const std::string& crg_path, const Mesh& original,
                        const ValidateOptions& options = {});

/// The same for a road and a mesh that are there already.
ValidateReport validate(const crg::Surface& road, const RaySurface& mesh,
                        const ValidateOptions& options = {});

}  // namespace road
