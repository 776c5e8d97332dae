// A road between two surveyed edges: no mesh needed.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "crg/reference_line.h"
#include "road/centreline.h"
#include "road/projection.h"
#include "road/sample.h"

namespace road {

/// One edge of a road as a list of points in driving order, map coordinates, metres.
struct Edge {
  std::string path;                       ///< names the edge in messages
  std::vector<Eigen::Vector3d> points_m;  ///< z = 0 where the file has none
  std::vector<std::size_t> line;          ///< of the file, per point
  bool has_z = false;
  bool keep_open = false;  ///< an open road, although it comes round to its start
};

/// CSV with the columns x_m,y_m and, if wanted, z_m. Throws Error with file:line on a missing
/// column, a cell that is no number, a coordinate that is NaN or beyond 1e8 m, fewer than 4 rows.
Edge read_edge(const std::string& path);

/// Both edges of a road, and how their coordinates belong to the Earth.
struct EdgePlaces {
  Edge left, right;
  Projection projection;
};

/// The edges of two files as read_edge() reads them; or, where these hold latitude and longitude
/// (KML, GPX, GeoJSON, CSV with lat_deg,lon_deg[,h_m]: see read_guide()), in metres about the first
/// position of the left one. Heights count where every position of both has one. Throws Error as
/// those do, and where only one of them holds latitude and longitude.
EdgePlaces read_edges(const std::string& left_path, const std::string& right_path);

/// Left and right edge of a file of racing line programs: x_m,y_m,w_tr_right_m,w_tr_left_m (the
/// header may begin with '#'), a line and the widths to its sides, square to the way from the point
/// before to the one after. No heights. Throws Error as read_edge() does.
std::pair<Edge, Edge> read_edges_of_line(const std::string& path);

struct EdgeOptions {
  double u_step_m = 0.1;  ///< along; a closed line changes it by < 0.1 % to close
  double v_step_m = 0.1;  ///< across; a quarter of it where an edge moves (see edge_gap_m)
  std::size_t max_nodes = 400'000'000;  ///< asked before allocation; 6 bytes each
};

struct EdgesReport {
  std::size_t left_points = 0, right_points = 0;
  std::size_t dropped_points = 0;  ///< repeated, sticking out, or after the edge had come round
  bool closed = false, has_z = false;
  bool right_reversed = false;  ///< the rows of RIGHT run against those of LEFT
  double width_min_m = 0.0, width_median_m = 0.0, width_max_m = 0.0;
  /// Distance in plan of the given points from the edges that the rows of the road have.
  double point_error_p99_m = 0.0, point_error_max_m = 0.0;
  /// How far the outermost node with a height lies inside the edge, per row and side.
  double edge_gap_median_m = 0.0, edge_gap_max_m = 0.0;
  double start_offset_m = 0.0;  ///< along the line, from u = 0 to the first row of LEFT
  std::vector<URange> folds;  ///< rows cut short because the bend is tighter than the road is wide
  std::vector<std::string> remarks;
};

/// Reference line in the middle (where the normals meet both edges at equal distance), heights
/// linear across between the edges, NaN outside of them. Between given points an edge follows a
/// cubic through its neighbours, straight at corners sharper than 30 degrees and where the spacing
/// of points changes threefold. Points of the two edges need not correspond.
struct EdgeRoad {
  crg::ReferenceLine line;
  SampledGrid sampled;
  Centreline centreline;
};

/// u = 0 beside the first row of `left` (5 mm before it when closed, so that no query of that row
/// falls into the gap of 1 mm that closed lines have), u in the direction of its rows. Closed when
/// both edges come round to their start. Throws Error with file:line or the range of u: edges that
/// cross or come nearer than two steps across, one closed and one open, `right` on the left of
/// `left`, an edge that turns back on itself, edges that do not run beside each other.
EdgeRoad road_between_edges(const Edge& left, const Edge& right, const EdgeOptions& options = {},
                            EdgesReport* report = nullptr);

}  // namespace road
