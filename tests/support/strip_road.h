// Small roads whose geometry is known by construction, as triangle strips.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "road/clean.h"

namespace support {

/// A place on a plan curve.
struct PlanPoint {
  double x_m, y_m, heading_rad;
};

/// Plan curves by arc length.
inline PlanPoint circle(double s_m, double radius_m) {
  const double angle = s_m / radius_m;
  return {radius_m * std::cos(angle), radius_m * std::sin(angle), angle + M_PI / 2};
}
inline PlanPoint straight(double s_m) { return {s_m, 0.0, 0.0}; }

/// A strip along `plan` from 0 to length_m with rings every step_m and vertices at the offsets v_m
/// (ascending). z(s, v) gives the height, kind(v_middle) the class of the band between two offsets.
inline road::RoadMesh make_strip(
    const std::function<PlanPoint(double)>& plan, double length_m, double step_m, bool closed,
    const std::vector<double>& v_m, const std::function<double(double, double)>& z,
    const std::function<road::SurfaceClass(double)>& kind = [](double) {
      return road::SurfaceClass::road;
    }) {
  road::RoadMesh result;
  road::Mesh& mesh = result.mesh;
  mesh.objects = {{"road", "asphalt", ""}};
  const auto rings = static_cast<std::size_t>(std::lround(length_m / step_m)) + (closed ? 0 : 1);
  for (std::size_t i = 0; i < rings; ++i) {
    const double s =
        length_m * static_cast<double>(i) / static_cast<double>(closed ? rings : rings - 1);
    const PlanPoint p = plan(s);
    for (const double v : v_m) {
      mesh.vertices_m.emplace_back(p.x_m - v * std::sin(p.heading_rad),
                                   p.y_m + v * std::cos(p.heading_rad), z(s, v));
    }
  }
  const auto columns = static_cast<std::uint32_t>(v_m.size());
  for (std::size_t i = 0; i + (closed ? 0 : 1) < rings; ++i) {
    for (std::uint32_t j = 0; j + 1 < columns; ++j) {
      const auto a = static_cast<std::uint32_t>(i) * columns + j;
      const auto b = static_cast<std::uint32_t>((i + 1) % rings) * columns + j;
      const auto surface_class = kind(0.5 * (v_m[j] + v_m[j + 1]));
      for (const std::array<std::uint32_t, 3>& triangle :
           {std::array<std::uint32_t, 3>{a, b, a + 1}, {a + 1, b, b + 1}}) {
        mesh.triangles.push_back(triangle);
        mesh.object_of_triangle.push_back(0);
        result.class_of_triangle.push_back(surface_class);
      }
    }
  }
  return result;
}

inline double flat(double, double) { return 0.0; }

}  // namespace support
