// The integrated reference line: a polyline with equal steps in u that carries the grid.
#pragma once

#include <cstddef>
#include <vector>

namespace crg {

struct Point2 {
  double x_m = 0.0;
  double y_m = 0.0;
};

/// Nodes of the reference line at u = u_begin_m + i * u_step_m, in map coordinates.
/// All vectors have the same length (>= 2 in a valid line), except z_m and banking, which may be
/// empty and then count as zero everywhere.
struct ReferenceLine {
  double u_begin_m = 0.0;
  double u_step_m = 1.0;  ///< > 0
  std::vector<double> x_m;
  std::vector<double> y_m;
  std::vector<double>
      heading_rad;  ///< CCW from +x; [i] belongs to the segment i-1 -> i, [0] is the start heading
  std::vector<double> z_m;      ///< height of the line itself; empty = 0
  std::vector<double> banking;  ///< m/m, rise towards +v; empty = 0
  bool closed = false;          ///< the last node lies on (or within a step of) the first

  std::size_t size() const { return x_m.size(); }
};

/// Map position of grid node (row i, lateral offset v): P[i] + v * mitre normal, where the normal
/// is perpendicular to P[i+1] - P[i-1] (one-sided at the ends). The OpenCRG rule for uv -> xy at
/// nodes.
Point2 node_position(const ReferenceLine& line, std::size_t row, double v_m);

/// Map position of (u, v) between nodes, by the same rule that Surface uses. u is clamped to the
/// line.
Point2 position(const ReferenceLine& line, double u_m, double v_m);

}  // namespace crg
