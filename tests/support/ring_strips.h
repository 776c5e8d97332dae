// Roads round a circle of 100 m, put together from named strips.
#pragma once

#include <cmath>
#include <string>

#include "mesh/mesh.h"

namespace support {

constexpr double kRing_m = 100.0;
constexpr double kRingLength_m = 2.0 * M_PI * kRing_m;

/// Where s along the circle (counter-clockwise, from +x) and `left` of it lies.
inline Eigen::Vector3d on_ring(double s_m, double left_m, double z_m) {
  return {(kRing_m - left_m) * std::cos(s_m / kRing_m),
          (kRing_m - left_m) * std::sin(s_m / kRing_m), z_m};
}

/// An object from `right_m` to `left_m` (level across when z_right_m is z_left_m) and from
/// s_begin_m to s_end_m, in quads of 1 m.
inline void add_ring_strip(road::Mesh& mesh, const std::string& name, double right_m, double left_m,
                           double z_right_m, double z_left_m, double s_begin_m = 0.0,
                           double s_end_m = kRingLength_m) {
  const auto object = static_cast<std::uint32_t>(mesh.objects.size());
  mesh.objects.push_back({});
  mesh.objects.back().name = name;
  const auto quads = static_cast<std::uint32_t>(std::ceil(s_end_m - s_begin_m));
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (std::uint32_t i = 0; i <= quads; ++i) {
    const double s_m = s_begin_m + (s_end_m - s_begin_m) * i / quads;
    mesh.vertices_m.push_back(on_ring(s_m, right_m, z_right_m));
    mesh.vertices_m.push_back(on_ring(s_m, left_m, z_left_m));
  }
  for (std::uint32_t i = 0; i < quads; ++i) {
    const std::uint32_t a = first + 2 * i;
    mesh.triangles.push_back({a, a + 2, a + 1});
    mesh.triangles.push_back({a + 2, a + 3, a + 1});
    mesh.object_of_triangle.insert(mesh.object_of_triangle.end(), 2, object);
  }
}

}  // namespace support
