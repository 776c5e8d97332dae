#include "raw_mesh.h"

namespace road {

std::size_t triangulate(const std::vector<Eigen::Vector3d>& vertices,
                        std::vector<std::uint32_t>& polygon,
                        std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::size_t ear_tests = 0;
  // Polygons with many corners are terrain borders; beyond this the quadratic search is no use.
  constexpr std::size_t kMostEars = 2000;
  if (polygon.size() > 3 && polygon.size() <= kMostEars) {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // Newell's
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      normal += (vertices[polygon[i]] - vertices[polygon[0]])
                    .cross(vertices[polygon[(i + 1) % polygon.size()]] - vertices[polygon[0]]);
    }
    const auto left = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      return normal.dot((vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]));
    };
    for (std::size_t i = 0, refused = 0; polygon.size() > 3 && refused < polygon.size();) {
      const std::size_t n = polygon.size();
      const std::uint32_t a = polygon[(i + n - 1) % n], b = polygon[i % n],
                          c = polygon[(i + 1) % n];
      bool ear = left(a, b, c) > 0.0;
      for (std::size_t k = 0; k < n && ear; ++k) {
        const std::uint32_t p = polygon[k];
        ++ear_tests;
        if (p == a || p == b || p == c) continue;
        ear = !(left(a, b, p) >= 0.0 && left(b, c, p) >= 0.0 && left(c, a, p) >= 0.0);
      }
      if (ear) {
        triangles.push_back({a, b, c});
        polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(i % n));
        refused = 0;
      } else {
        ++refused;
        ++i;
      }
      i %= polygon.size();
    }
  }
  // The last ear, or what no ear could be cut from (folded polygons): a fan.
  for (std::size_t k = 2; k < polygon.size(); ++k)
    triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
  return ear_tests;
}

}  // namespace road
