// Where strips of triangles end, and which ends belong together. Private to clean.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh_topology.h"

namespace road {

constexpr double kLongestGap_m = 40.0;  ///< between ends that face each other

/// An open end of a strip: the straight piece of a border across it, surface on its left.
struct End {
  std::vector<std::uint32_t> vertices;
  Eigen::Vector3d first, last, middle;
  Eigen::Vector2d outward;
  double width_m = 0.0;
};

/// Ends up to `widest_m` wide of the strips that the triangles form.
std::vector<End> open_ends(const std::vector<Triangle>& triangles,
                           const std::vector<Eigen::Vector3d>& vertices_m, double widest_m);

/// Two ends that face each other.
struct Gap {
  End a, b;
  double length_m = 0.0;
};

/// Pairs of ends that face each other, nearest first; every end once.
std::vector<Gap> facing_ends(const std::vector<End>& ends, double longest_m);

/// A point of an end, and the slope (m/m) of the surface there along the way over the gap.
struct EndPoint {
  Eigen::Vector3d at_m;
  double slope = 0.0;
};

/// Rows of points between the two ends of a gap, without the ends, from a to b: every column goes
/// on from `a` to the point of `b` across as an arc in plan, and in height without a kink. Both
/// ends from the same side, two points or more. Empty for gaps shorter than a few rows.
std::vector<std::vector<Eigen::Vector3d>> rows_over(const Gap& gap, const std::vector<EndPoint>& a,
                                                    const std::vector<EndPoint>& b);

}  // namespace road
