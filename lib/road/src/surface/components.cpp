// Connected components of a triangle soup. CGAL stays private to this file.
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <unordered_map>

#include "mesh_topology.h"

namespace road {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;

/// First triangle at each edge where CGAL finds more than two faces; kNoIndex until it is looked
/// for.
using NonManifoldEdges = std::unordered_map<std::uint64_t, std::uint32_t>;

/// Hears from CGAL where it cuts. Cuts where faces cannot be turned to agree (a Moebius strip) part
/// no component: the faces on both sides were reached from each other.
struct Cuts : pmp::Default_orientation_visitor {
  explicit Cuts(NonManifoldEdges& found) : edges(&found) {}
  void non_manifold_edge(std::size_t a, std::size_t b, std::size_t /*faces*/) {
    edges->emplace(undirected(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)),
                   kNoIndex);
  }
  NonManifoldEdges* edges;  // CGAL copies its visitor
};

}  // namespace

Components components(const std::vector<Triangle>& triangles) {
  using Point = CGAL::Simple_cartesian<double>::Point_3;
  using SurfaceMesh = CGAL::Surface_mesh<Point>;

  // Only the connections count: points are placeholders.
  std::size_t vertices = 0;
  for (const Triangle& t : triangles)
    vertices = std::max<std::size_t>(vertices, 1 + *std::max_element(t.begin(), t.end()));
  std::vector<Point> points(vertices, Point(0, 0, 0));
  std::vector<std::array<std::size_t, 3>> polygons;
  polygons.reserve(triangles.size());
  for (const Triangle& t : triangles) polygons.push_back({t[0], t[1], t[2]});
  // Makes the soup a manifold: turns faces to agree, and cuts edges where more than two faces meet.
  NonManifoldEdges non_manifold;
  pmp::orient_polygon_soup(points, polygons, CGAL::parameters::visitor(Cuts(non_manifold)));
  SurfaceMesh mesh;
  pmp::polygon_soup_to_polygon_mesh(points, polygons, mesh);
  const auto component =
      mesh.add_property_map<SurfaceMesh::Face_index, std::size_t>("f:component", 0).first;
  DisjointSets sets(pmp::connected_components(mesh, component));
  const auto of = [&](std::uint32_t t) {
    return static_cast<std::uint32_t>(component[SurfaceMesh::Face_index(t)]);
  };

  // Faces that meet in an edge that was cut are one surface all the same.
  Components out;
  for (std::uint32_t t = 0; t < triangles.size() && !non_manifold.empty(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto edge = non_manifold.find(undirected(triangles[t][c], triangles[t][(c + 1) % 3]));
      if (edge == non_manifold.end()) continue;
      if (edge->second == kNoIndex) {
        edge->second = t;
        out.at_non_manifold_edges.push_back(t);
      } else {
        sets.join(of(t), of(edge->second));
      }
    }
  }
  out.of_triangle.reserve(triangles.size());
  std::vector<std::uint32_t> renumbered(sets.size(), kNoIndex);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    std::uint32_t& name = renumbered[sets.find(of(t))];
    if (name == kNoIndex) name = out.count++;
    out.of_triangle.push_back(name);
  }
  return out;
}

}  // namespace road
