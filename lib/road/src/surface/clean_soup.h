// The drivable part of a mesh while it is being cleaned. Private to cleaning.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "mesh_topology.h"
#include "road/clean.h"

namespace road {

/// A triangle of no more area than this is none.
inline constexpr double kZeroArea_m2 = 1e-8;
// Surfaces that touch within this along their borders belong together (T-junctions).
inline constexpr double kTouch_m = 0.05;

Eigen::Vector3d area_vector(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c);

/// The drivable part of a mesh while it is being cleaned: shared vertices, faces up.
struct Soup {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> source;  ///< triangle of the input mesh it is, or stands beside
  std::vector<SurfaceClass> surface_class;

  Eigen::Vector3d area_vector_of(std::size_t i) const {
    const Triangle& t = triangles[i];
    return area_vector(vertices_m[t[0]], vertices_m[t[1]], vertices_m[t[2]]);
  }

  /// Keeps the triangles for which `keep` says so.
  template <class Keep>
  void filter(Keep keep) {
    std::size_t out = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (!keep(i)) continue;
      triangles[out] = triangles[i];
      source[out] = source[i];
      surface_class[out] = surface_class[i];
      ++out;
    }
    triangles.resize(out);
    source.resize(out);
    surface_class.resize(out);
  }

  /// Applies a vertex map; drops what collapses or repeats.
  void merge_vertices(const std::vector<std::uint32_t>& target,
                      std::map<std::string, std::size_t>& dropped);

  /// Leaves out vertices that no triangle uses, in order of first use.
  void compact();
};

/// The kept triangles of a mesh, vertices welded, faces up; what was done is added to `facts`.
Soup make_soup(const Mesh& mesh, const std::vector<std::uint32_t>& kept,
               const std::vector<SurfaceClass>& class_of_triangle, const CleanOptions& options,
               CleanReport& facts);

/// Border vertices that nearly coincide become one: cracks that the weld tolerance left open.
/// Returns what became of each vertex.
std::vector<std::uint32_t> snap_borders(Soup& soup, double horizontal_m, double vertical_m,
                                        CleanReport& facts);

/// Whether the triangles hardly share edges: every vertex was torn apart on export.
bool is_torn(const std::vector<Triangle>& triangles);

/// The triangles of the road in `soup`.
std::vector<Triangle> road_triangles(const Soup& soup);

/// The same as a mesh in the frame of the vertices.
Mesh surface_of(const Soup& soup);

}  // namespace road
