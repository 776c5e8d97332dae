// Connected components of a triangle soup. CGAL stays private to this file.
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>

#include "mesh_topology.h"

namespace road {

namespace pmp = CGAL::Polygon_mesh_processing;

std::vector<std::uint32_t> components(const std::vector<Triangle>& triangles) {
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
  pmp::orient_polygon_soup(points, polygons);
  SurfaceMesh mesh;
  pmp::polygon_soup_to_polygon_mesh(points, polygons, mesh);
  const auto component =
      mesh.add_property_map<SurfaceMesh::Face_index, std::size_t>("f:component", 0).first;
  const std::size_t cut = pmp::connected_components(mesh, component);

  // Faces that meet in such an edge are one surface all the same.
  DisjointSets sets(cut);
  const auto of = [&](std::uint32_t t) {
    return static_cast<std::uint32_t>(component[SurfaceMesh::Face_index(t)]);
  };
  const std::vector<EdgeUse> uses = edge_uses(triangles);
  for (std::size_t i = 1; i < uses.size(); ++i) {
    if (uses[i].key == uses[i - 1].key) sets.join(of(uses[i].t), of(uses[i - 1].t));
  }
  std::vector<std::uint32_t> number(triangles.size()), renumbered(cut, kNoIndex);
  std::uint32_t count = 0;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    std::uint32_t& name = renumbered[sets.find(of(t))];
    if (name == kNoIndex) name = count++;
    number[t] = name;
  }
  return number;
}

}  // namespace road
