// Every road of a mesh, not only the one that is taken. Private.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "road/clean.h"
#include "road/road_graph.h"

namespace road {

struct Roads {
  RoadGraph graph;
  Mesh surface;
};

/// What names call road, or colour plainly shows where they call nothing so, and what looks like
/// road by its shape, as far as the options let names count; those without any road left out.
std::vector<Roads> roads_of(const Mesh& mesh, const CleanOptions& options);

/// A place on a strip, and the width that tells all columns in one plane there from it.
struct PlaceOfRoad {
  Eigen::Vector2d near_m;
  std::optional<double> width_m;
};

/// A place on each strip that shape alone shows and that is about as long as the longest, the
/// likeliest road first. With it as near_m and guide_width_m of the options the strip is the road.
std::vector<PlaceOfRoad> places_that_may_be_road(const Mesh& mesh, const CleanOptions& options);

}  // namespace road
