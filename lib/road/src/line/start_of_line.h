// Where a line begins, and where an open one ends. Private to trace_centreline.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mesh/ray_surface.h"
#include "road/centreline.h"

namespace road {

/// Middle of the longest stretch that turns by less than 3 degrees: a calm place for the seam.
std::size_t middle_of_longest_straight(const std::vector<Eigen::Vector3d>& points);

/// Makes point `first` of a closed line its first one.
void rotate_to(Centreline& line, std::size_t first);

/// Makes the place nearest to `p` station 0; a new station is put in where none lies there.
void start_at(Centreline& line, const Eigen::Vector2d& p);

/// Draws the ends of an open line in, where the surface ends askew, to rows that are whole.
void draw_in_ends(const RaySurface& surface, Centreline& line);

}  // namespace road
