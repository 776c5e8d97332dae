// Heights over a curvilinear grid: uniform rows along u, columns at ascending v.
#pragma once

#include <cstddef>
#include <vector>

namespace crg {

/// z(u, v) at the nodes of a grid, relative to the reference line's own z and banking.
/// Row i lies at u = u_begin_m + i * u_step_m; column j lies at v = v_m[j] (left of the line is
/// positive). NaN marks a node without road. float32 is what the file formats in use carry.
struct Grid {
  double u_begin_m = 0.0;
  double u_step_m = 1.0;    ///< > 0
  std::vector<double> v_m;  ///< ascending, at least 2 entries in a valid grid; spacing may vary
  std::vector<float> z_m;   ///< rows() * columns() values, row after row

  std::size_t columns() const { return v_m.size(); }
  std::size_t rows() const { return v_m.empty() ? 0 : z_m.size() / v_m.size(); }
  float& at(std::size_t row, std::size_t column) { return z_m[row * v_m.size() + column]; }
  float at(std::size_t row, std::size_t column) const { return z_m[row * v_m.size() + column]; }
  double u_of(std::size_t row) const { return u_begin_m + static_cast<double>(row) * u_step_m; }
};

}  // namespace crg
