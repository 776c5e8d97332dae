// Sizes of a line and of a grid, and where its ends lie on the Earth.
#pragma once

#include <cstddef>
#include <optional>

#include "crg/file.h"
#include "road/centreline.h"

namespace road {

struct CentrelineReport {
  std::size_t stations = 0;
  double length_m = 0.0;
  bool closed = false;
  double width_min_m = 0.0, width_median_m = 0.0, width_max_m = 0.0;  ///< full width, both sides
};

CentrelineReport describe(const Centreline& centreline);

struct GridReport {
  std::size_t rows = 0, columns = 0;
  std::size_t nodes = 0;  ///< rows * columns
  std::size_t nodes_with_z = 0;
  std::size_t holes = 0;  ///< without z between the outermost nodes with z of their row
  double u_begin_m = 0.0, u_end_m = 0.0, u_step_m = 0.0;
  double v_min_m = 0.0, v_max_m = 0.0;
  double v_step_min_m = 0.0, v_step_max_m = 0.0;
  double z_min_m = 0.0,
         z_max_m =
             0.0;  ///< of the surface: grid, height and banking of the line; NaN when no node has z
  /// From the outermost node with z on one side to that on the other, kerbs and run-off among them;
  /// rows without any z left out. NaN when no node has z.
  double width_min_m = 0.0, width_median_m = 0.0, width_max_m = 0.0;
};

/// `line`: of the same file; one node per row.
GridReport describe(const crg::Grid& grid, const crg::ReferenceLine& line);

/// Where an end of the reference line lies on the Earth (WGS84), as the header says it.
struct GeoPoint {
  double latitude_deg = 0.0, longitude_deg = 0.0;
  std::optional<double> height_m;
};

/// Start and end; nothing where the header has no latitude and longitude of that end.
struct GeoEnds {
  std::optional<GeoPoint> start, end;
};
GeoEnds geo_ends(const crg::Crg& file);

}  // namespace road
