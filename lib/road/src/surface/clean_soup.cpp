#include "clean_soup.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace road {
namespace {

// Where hardly any triangle shares an edge (more components than this share of the triangles) the
// export tore every vertex apart, and there is no step to keep.
constexpr double kTornShare = 0.05;

}  // namespace

Eigen::Vector3d area_vector(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c) {
  return 0.5 * (b - a).cross(c - a);
}

void Soup::merge_vertices(const std::vector<std::uint32_t>& target,
                          std::map<std::string, std::size_t>& dropped) {
  // By the lowest corner first: what is left to sort is small.
  std::vector<std::uint32_t> next(vertices_m.size() + 1, 0);
  for (Triangle& t : triangles) {
    for (std::uint32_t& index : t) index = target[index];
    ++next[1 + *std::min_element(t.begin(), t.end())];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<std::array<std::uint32_t, 4>> sorted(triangles.size());  // corners in order, triangle
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    Triangle key = triangles[i];
    std::sort(key.begin(), key.end());
    sorted[next[key[0]]++] = {key[0], key[1], key[2], i};
  }
  for (auto begin = sorted.begin(); begin != sorted.end();) {
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(next[(*begin)[0]]);
    std::sort(begin, end);
    begin = end;
  }
  std::vector<char> again(triangles.size(), 0);
  for (std::size_t k = 1; k < sorted.size(); ++k)
    again[sorted[k][3]] = std::equal(sorted[k].begin(), sorted[k].end() - 1, sorted[k - 1].begin());
  filter([&](std::size_t i) {
    const Triangle& t = triangles[i];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0] || area_vector_of(i).norm() < kZeroArea_m2) {
      ++dropped["zero area"];
      return false;
    }
    if (again[i]) ++dropped["duplicate"];
    return !again[i];
  });
}

void Soup::compact() {
  std::vector<std::uint32_t> number(vertices_m.size(), kNoIndex);
  std::vector<Eigen::Vector3d> used;
  used.reserve(vertices_m.size());
  for (Triangle& t : triangles) {
    for (std::uint32_t& index : t) {
      if (number[index] == kNoIndex) {
        number[index] = static_cast<std::uint32_t>(used.size());
        used.push_back(vertices_m[index]);
      }
      index = number[index];
    }
  }
  vertices_m = std::move(used);
}

Soup make_soup(const Mesh& mesh, const std::vector<std::uint32_t>& kept,
               const std::vector<SurfaceClass>& class_of_triangle, const CleanOptions& options,
               CleanReport& facts) {
  Soup soup;
  soup.triangles.reserve(kept.size());
  std::vector<std::uint32_t> number(mesh.vertices_m.size(), kNoIndex);
  for (const std::uint32_t i : kept) {
    Triangle t{};
    for (std::size_t c = 0; c < 3; ++c) {
      std::uint32_t& n = number[mesh.triangles[i][c]];
      if (n == kNoIndex) {
        n = static_cast<std::uint32_t>(soup.vertices_m.size());
        soup.vertices_m.push_back(mesh.vertices_m[mesh.triangles[i][c]]);
      }
      t[c] = n;
    }
    soup.triangles.push_back(t);
    soup.source.push_back(i);
    soup.surface_class.push_back(class_of_triangle[i]);
    if (soup.area_vector_of(soup.triangles.size() - 1).z() < 0.0) {
      std::swap(soup.triangles.back()[1], soup.triangles.back()[2]);
      ++facts.faces_turned;
    }
  }
  const std::vector<std::uint32_t> target =
      weld(soup.vertices_m, options.weld_tolerance_m, options.weld_tolerance_m);
  for (std::uint32_t i = 0; i < target.size(); ++i) facts.vertices_welded += target[i] != i ? 1 : 0;
  soup.merge_vertices(target, facts.dropped);
  soup.compact();
  return soup;
}

std::vector<std::uint32_t> snap_borders(Soup& soup, double horizontal_m, double vertical_m,
                                        CleanReport& facts) {
  std::vector<std::uint32_t> border;
  std::vector<char> seen(soup.vertices_m.size(), 0);
  for (const auto& loop : border_loops(soup.triangles, soup.vertices_m)) {
    for (const std::uint32_t vertex : loop) {
      if (seen[vertex]) continue;
      seen[vertex] = 1;
      border.push_back(vertex);
    }
  }
  std::sort(border.begin(), border.end());
  std::vector<Eigen::Vector3d> points;
  points.reserve(border.size());
  for (const std::uint32_t vertex : border) points.push_back(soup.vertices_m[vertex]);
  const std::vector<std::uint32_t> near = weld(points, horizontal_m, vertical_m);
  std::vector<std::uint32_t> target(soup.vertices_m.size());
  std::iota(target.begin(), target.end(), 0u);
  bool any = false;
  for (std::uint32_t i = 0; i < border.size(); ++i) {
    if (near[i] == i) continue;
    target[border[i]] = border[near[i]];
    any = true;
    ++facts.vertices_snapped;
  }
  if (any) soup.merge_vertices(target, facts.dropped);
  return target;
}

bool is_torn(const std::vector<Triangle>& triangles) {
  return components(triangles).count > 1.0 + kTornShare * static_cast<double>(triangles.size());
}

std::vector<Triangle> road_triangles(const Soup& soup) {
  std::vector<Triangle> out;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    if (soup.surface_class[i] == SurfaceClass::road) out.push_back(soup.triangles[i]);
  }
  return out;
}

Mesh surface_of(const Soup& soup) {
  Mesh surface;
  surface.vertices_m = soup.vertices_m;
  surface.triangles = road_triangles(soup);
  return surface;
}

}  // namespace road
