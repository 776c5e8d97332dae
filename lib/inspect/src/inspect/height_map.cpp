#include "inspect/height_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "mesh/error.h"

namespace road {

HeightMap height_map(const crg::Surface& surface) {
  const crg::Grid& grid = surface.grid();
  HeightMap map;
  map.line = surface.reference_line();
  map.v_m = grid.v_m;
  if (grid.rows() < 2 || grid.columns() < 2 || map.line.size() != grid.rows()) {
    throw Error(
        fmt::format("a grid of {} x {} nodes on a line of {} has no surface; wanted at least 2 x 2",
                    grid.rows(), grid.columns(), map.line.size()));
  }
  const std::size_t columns = grid.columns();
  // The middle of the heights as base: a metre, so that differences of two maps stay readable.
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t i = 0; i < grid.rows(); i += 16) {
    for (std::size_t j = 0; j < columns; j += 4) {
      const double z =
          static_cast<double>(grid.at(i, j)) + (map.line.z_m.empty() ? 0.0 : map.line.z_m[i]);
      if (!std::isfinite(z)) continue;
      low = std::min(low, z);
      high = std::max(high, z);
    }
  }
  map.z_base_m = low <= high ? std::round(0.5 * (low + high)) : 0.0;
  map.z_m.resize(grid.z_m.size());
  base::parallel_for(grid.rows(), 512, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double z = (map.line.z_m.empty() ? 0.0 : map.line.z_m[i]) - map.z_base_m;
      const double banking = map.line.banking.empty() ? 0.0 : map.line.banking[i];
      for (std::size_t j = 0; j < columns; ++j) {
        map.z_m[i * columns + j] = static_cast<float>(
            static_cast<double>(grid.z_m[i * columns + j]) + z + banking * map.v_m[j]);
      }
    }
  });
  return map;
}

std::vector<RowExtent> row_extents(const HeightMap& map) {
  std::vector<RowExtent> extents(map.rows());
  for (std::size_t i = 0; i < map.rows(); ++i) {
    RowExtent& extent = extents[i];
    for (std::size_t j = 0; j < map.columns(); ++j) {
      if (std::isnan(map.at(i, j))) continue;
      if (extent.count++ == 0) extent.first = j;
      extent.last = j;
    }
  }
  return extents;
}

std::vector<double> long_section(const HeightMap& map, double v_m) {
  std::vector<double> section(map.rows(), std::numeric_limits<double>::quiet_NaN());
  if (v_m < map.v_m.front() || v_m > map.v_m.back()) return section;
  const auto above =
      std::upper_bound(map.v_m.begin() + 1, map.v_m.end() - 1, v_m) - map.v_m.begin();
  const auto j = static_cast<std::size_t>(above);
  const double t = (v_m - map.v_m[j - 1]) / (map.v_m[j] - map.v_m[j - 1]);
  for (std::size_t i = 0; i < map.rows(); ++i) {
    // On a column only that column counts: its neighbour may be missing.
    if (t == 0.0)
      section[i] = map.at(i, j - 1);
    else if (t == 1.0)
      section[i] = map.at(i, j);
    else
      section[i] =
          (1.0 - t) * static_cast<double>(map.at(i, j - 1)) + t * static_cast<double>(map.at(i, j));
  }
  return section;
}

}  // namespace road
