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
  /// Of all columns that lie in one plane with the road, where only their widths differ from its
  /// own and it is narrower than circuits are; 0 where it ends at a fold or at uneven ground.
  double in_one_plane_m = 0.0;
  std::optional<Eigen::Vector2d> twin_m;  ///< on another strip as long and wide, not beside it
  bool is_told = false;                   ///< by the place: then there is no rival
};

/// A place on a strip; with a width, of those there the one about as wide.
struct StripPlace {
  Eigen::Vector2d at_m;
  std::optional<double> width_m;
};

/// With a place: the strip on which it lies, where it lies on one.
ShapeClasses classify_by_shape(const FlatSurface& flat,
                               const std::optional<StripPlace>& place = {});

/// A place on each strip about as long as the longest, the likeliest road first: even ones before
/// uneven ones, those with ground on both sides before those at a rim, wide ones before narrow
/// ones. Before or after it the same place with the width of all columns in one plane there.
std::vector<StripPlace> places_by_shape(const FlatSurface& flat);

}  // namespace road
