// Places and heights between the nodes of a map, and cuts across it. Private to the comparison.
#pragma once

#include <cstddef>

#include "crg/reference_line.h"
#include "inspect/compare.h"
#include "inspect/height_map.h"

namespace road {

/// Which row segment and how far in it a u lies.
struct RowPlace {
  std::size_t row;
  double share;
};

RowPlace place_of(const HeightMap& map, double u_m);

/// Positions on one row between nodes: linear in v.
struct RowLine {
  crg::Point2 middle, per_metre;
  crg::Point2 at(double v_m) const {
    return {middle.x_m + v_m * per_metre.x_m, middle.y_m + v_m * per_metre.y_m};
  }
};

RowLine line_of(const HeightMap& map, const RowPlace& place);

/// Between the nodes, linear in u and v; NaN outside the map and where a node has no height.
double height_at(const HeightMap& map, const RowPlace& place, double v_m);

/// Across the road at u_m, from v_low_m to v_high_m as far as the map reaches.
CrossCut cut(const HeightMap& map, const ReferenceHeights& reference, double u_m, double v_m,
             double v_low_m, double v_high_m);

}  // namespace road
