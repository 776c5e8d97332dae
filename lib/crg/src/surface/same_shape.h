// A friction map lies on the nodes of its road.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>

#include "crg/error.h"
#include "crg/grid.h"

namespace crg {

/// Throws Error where the map has other rows, columns or places than the road.
inline void want_same_shape(const Grid& road, const Grid& map) {
  bool same = map.rows() == road.rows() && map.columns() == road.columns() &&
              std::abs(map.u_step_m - road.u_step_m) <= 1e-9 * road.u_step_m &&
              std::abs(map.u_begin_m - road.u_begin_m) <= 1e-6;
  for (std::size_t j = 0; same && j < road.columns(); ++j)
    same = std::abs(map.v_m[j] - road.v_m[j]) <= 1e-6;
  if (!same) {
    throw Error("friction map of " + std::to_string(map.rows()) + " x " +
                std::to_string(map.columns()) + " for a road of " + std::to_string(road.rows()) +
                " x " + std::to_string(road.columns()) + ": want the same rows, columns, u and v");
  }
}

}  // namespace crg
