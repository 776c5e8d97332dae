// A road as one sheet of heights: what reports, findings and comparisons look at.
#pragma once

#include <cstddef>
#include <vector>

#include "crg/reference_line.h"
#include "crg/surface.h"

namespace road {

/// Heights in the map frame at the nodes of a grid, reference line and banking included.
/// z = z_base_m + z_m[row * columns + column]; NaN: no road. Rows and columns as in crg::Grid.
struct HeightMap {
  crg::ReferenceLine line;  ///< one node per row; u of row i is line.u_begin_m + i * line.u_step_m
  std::vector<double> v_m;  ///< ascending, left positive
  double z_base_m = 0.0;    ///< keeps z_m small, so that float32 resolves 1 um within 16 m of it
  std::vector<float> z_m;

  std::size_t rows() const { return line.size(); }
  std::size_t columns() const { return v_m.size(); }
  float at(std::size_t row, std::size_t column) const { return z_m[row * v_m.size() + column]; }
  float& at(std::size_t row, std::size_t column) { return z_m[row * v_m.size() + column]; }
  double u_of(std::size_t row) const {
    return line.u_begin_m + static_cast<double>(row) * line.u_step_m;
  }
  double u_end_m() const { return u_of(rows() - 1); }
};

/// The sheet of a file after its modifiers. Throws Error when the grid has fewer than 2 x 2 nodes.
HeightMap height_map(const crg::Surface& surface);

/// First and last column with a height, per row; first > last where a row has none.
struct RowExtent {
  std::size_t first = 1, last = 0, count = 0;
  bool empty() const { return count == 0; }
};
std::vector<RowExtent> row_extents(const HeightMap& map);

/// Heights (over z_base_m) along constant v, linear between columns; NaN where either neighbour is.
std::vector<double> long_section(const HeightMap& map, double v_m);

}  // namespace road
