// Finds the road of a mesh without names. Private to clean.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mesh_topology.h"
#include "road/clean.h"

namespace road {

/// The flat triangles of a mesh (shared vertices, faces up) and the walls on their edges.
struct FlatSurface {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<Triangle> triangles;
  /// Lower vertex in the upper half, higher vertex in the lower half; sorted. A steep face stands
  /// or drops there, so that nothing drives across.
  std::vector<std::uint64_t> walls;
};

/// Road, run-off or scenery for each triangle of `flat`; all scenery when there is no strip.
///
/// A simulator's road is lofted: cross sections follow each other, and the vertices at one lateral
/// offset form a smooth chain of edges along the track. The road is the longest run of such chains
/// that keep their distance, 4.5-45 m in all; columns of one width belong together. Of strips side
/// by side the widest is taken. Run-off is what hangs on its sides up to a wall, as far as it is
/// built of cross sections too.
struct ShapeClasses {
  std::vector<SurfaceClass> class_of_triangle;
  double road_length_m = 0.0;
  double road_width_m = 0.0;
  /// Of a strip beside the road that may be the road itself; 0 where there is none. A road has
  /// strips on both its sides, or on none, or a narrow one: what has another on one side only may
  /// be the verge of that.
  double rival_width_m = 0.0;
  bool is_told = false;  ///< by the place: then there is no rival
};
/// With a place: the strip on which it lies, where it lies on one.
ShapeClasses classify_by_shape(const FlatSurface& flat,
                               const std::optional<Eigen::Vector2d>& place_m = {});

/// A place on each strip about as long as the longest, the likeliest road first: even ones before
/// uneven ones, those with ground on both sides before those at a rim, wide ones before narrow
/// ones.
std::vector<Eigen::Vector2d> places_by_shape(const FlatSurface& flat);

}  // namespace road
