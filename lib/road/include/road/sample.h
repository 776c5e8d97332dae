// Heights over (u, v): rays on the surface along the grid, layer by layer.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "crg/grid.h"
#include "crg/reference_line.h"
#include "mesh/ray_surface.h"
#include "road/centreline.h"
#include "road/crossings.h"
#include "road/road_mesh.h"

namespace road {

/// Where a node's height comes from.
enum class Provenance : std::uint8_t { none, mesh, filled };

struct SampleOptions {
  std::optional<double> v_step_m = {};  ///< absent: automatic_step_m()
  double v_max_m = 15.0;                ///< on both sides of the reference line
  /// A larger jump of z between neighbouring nodes ends the surface. Absent: three automatic steps.
  std::optional<double> max_step_m = {};
  /// Misses up to this wide inside the road are filled and flagged. Absent: three automatic steps.
  std::optional<double> max_gap_m = {};
  unsigned threads = 0;                 ///< 0 = all cores; any number gives the same bytes
  std::size_t max_nodes = 400'000'000;  ///< asked before allocation; 6 bytes each
};

struct URange {
  double u_begin_m, u_end_m;
};

struct SampleReport {
  std::size_t nodes = 0;  ///< rows * columns
  std::size_t nodes_with_z = 0;
  std::size_t filled = 0;
  std::size_t holes = 0;      ///< nodes without z between the outermost nodes with z of their row
  std::vector<URange> folds;  ///< rows trimmed because 1 - curvature * v <= margin
  std::vector<URange> neighbours;  ///< rows trimmed at the middle to another leg of the track
  std::vector<URange> walls;  ///< rows that end at a wall in a gap of the surface: end_at_walls()
  /// Rows whose surface beyond the road's edge is notched: end_where_whole().
  std::vector<URange> cut_left, cut_right;
  std::vector<Crossing> crossings;  ///< where the road passes over, under or through itself
};

/// A grid plus what each node is; same shape for all three.
struct SampledGrid {
  crg::Grid grid;  ///< z in the map frame of the surface
  std::vector<Provenance> provenance;
  std::vector<SurfaceClass>
      surface_class;  ///< of the triangle hit; meaningless where provenance is none
};

SampledGrid sample_grid(const RoadMesh& road, const RaySurface& surface,
                        const crg::ReferenceLine& line, const Centreline& centreline,
                        const SampleOptions& options = {}, SampleReport* report = nullptr);

}  // namespace road
