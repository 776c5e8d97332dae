#include "support/mutate_mesh.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

namespace support {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using road::Mesh;

/// mt19937_64 gives the same numbers everywhere; std::uniform_real_distribution need not.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double share() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  double within(double amplitude) { return amplitude * (2 * share() - 1); }

 private:
  std::mt19937_64 engine_;
};

std::uint32_t object_of(const Mesh& mesh, std::size_t t) {
  return mesh.object_of_triangle.empty() ? 0 : mesh.object_of_triangle[t];
}

/// Calls pick(t) -> how many copies of triangle t to keep.
template <class Pick>
Mesh keep(Mesh mesh, Pick pick) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> objects;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int copies = pick(t); copies > 0; --copies) {
      triangles.push_back(mesh.triangles[t]);
      objects.push_back(object_of(mesh, t));
    }
  }
  mesh.triangles = std::move(triangles);
  mesh.object_of_triangle = std::move(objects);
  return mesh;
}

}  // namespace

Mesh jitter(Mesh mesh, double amplitude_m, std::uint64_t seed, bool tear) {
  Random random(seed);
  std::map<std::array<double, 3>, Vector3d> offset_at;
  for (Vector3d& vertex : mesh.vertices_m) {
    const Vector3d offset(random.within(amplitude_m), random.within(amplitude_m),
                          random.within(amplitude_m));
    if (tear) {
      vertex += offset;
    } else {
      vertex += offset_at.try_emplace({vertex.x(), vertex.y(), vertex.z()}, offset).first->second;
    }
  }
  return mesh;
}

Mesh delete_triangles(Mesh mesh, double share, std::uint64_t seed) {
  Random random(seed);
  return keep(std::move(mesh), [&](std::size_t) { return random.share() < share ? 0 : 1; });
}

Mesh duplicate_triangles(Mesh mesh, double share, std::uint64_t seed) {
  Random random(seed);
  return keep(std::move(mesh), [&](std::size_t) { return random.share() < share ? 2 : 1; });
}

Mesh flip_triangles(Mesh mesh, double share, std::uint64_t seed) {
  Random random(seed);
  for (auto& triangle : mesh.triangles) {
    if (random.share() < share) std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

Mesh strip_names(Mesh mesh) {
  mesh.objects.assign(1, {});
  mesh.object_of_triangle.assign(mesh.triangles.size(), 0);
  return mesh;
}

Mesh move_rigidly(Mesh mesh, double yaw_rad, const Vector3d& translation_m) {
  const Eigen::AngleAxisd turn(yaw_rad, Vector3d::UnitZ());
  for (Vector3d& vertex : mesh.vertices_m) vertex = turn * vertex;
  mesh.origin_m = turn * mesh.origin_m + translation_m;
  return mesh;
}

Mesh scale(Mesh mesh, double factor) {
  for (Vector3d& vertex : mesh.vertices_m) vertex *= factor;
  mesh.origin_m *= factor;
  return mesh;
}

Mesh lift_tile(Mesh mesh, const Vector2d& low_m, const Vector2d& high_m, double step_m) {
  for (Vector3d& vertex : mesh.vertices_m) {
    const Vector2d p = (mesh.origin_m + vertex).head<2>();
    if ((p.array() >= low_m.array()).all() && (p.array() < high_m.array()).all())
      vertex.z() += step_m;
  }
  return mesh;
}

Mesh punch_hole(Mesh mesh, const Vector2d& centre_m, double radius_m, double z_m) {
  const Vector2d centre = centre_m - mesh.origin_m.head<2>();
  const auto distance = [&](const Vector3d& p) { return (p.head<2>() - centre).norm(); };
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> objects;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t object = object_of(mesh, t);
    const auto keep_triangle = [&](const std::array<std::uint32_t, 3>& triangle) {
      triangles.push_back(triangle);
      objects.push_back(object);
    };
    const double height =
        (mesh.vertex(t, 0).z() + mesh.vertex(t, 1).z() + mesh.vertex(t, 2).z()) / 3;
    if (std::abs(height + mesh.origin_m.z() - z_m) > 1.0) {
      keep_triangle(mesh.triangles[t]);
      continue;
    }
    // Halve the longest edge of pieces near the rim until they are small; a piece with its centre
    // inside goes. New vertices lie on old edges, so the surface that stays is the old one.
    std::vector<std::array<std::uint32_t, 3>> open = {mesh.triangles[t]};
    bool split = false;
    std::vector<std::array<std::uint32_t, 3>> kept;
    while (!open.empty()) {
      const auto piece = open.back();
      open.pop_back();
      const Vector3d corner[3] = {mesh.vertices_m[piece[0]], mesh.vertices_m[piece[1]],
                                  mesh.vertices_m[piece[2]]};
      const Vector3d middle = (corner[0] + corner[1] + corner[2]) / 3;
      std::size_t longest = 0;
      double length = 0.0;
      double reach = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double edge = (corner[(k + 1) % 3] - corner[k]).head<2>().norm();
        if (edge > length) length = edge, longest = k;
        reach = std::max(reach, (corner[k] - middle).head<2>().norm());
      }
      const double away = distance(middle);
      if (away > radius_m + reach) {
        kept.push_back(piece);
      } else if (length <= 0.2 * radius_m || away + reach < radius_m) {
        split = true;
        if (away > radius_m) kept.push_back(piece);
      } else {
        split = true;
        const std::size_t a = longest;
        const std::size_t b = (longest + 1) % 3;
        const std::size_t c = (longest + 2) % 3;
        mesh.vertices_m.push_back(0.5 * (corner[a] + corner[b]));
        const auto m = static_cast<std::uint32_t>(mesh.vertices_m.size() - 1);
        open.push_back({piece[a], m, piece[c]});
        open.push_back({m, piece[b], piece[c]});
      }
    }
    if (split) {
      for (const auto& piece : kept) keep_triangle(piece);
    } else {
      keep_triangle(mesh.triangles[t]);
    }
  }
  mesh.triangles = std::move(triangles);
  mesh.object_of_triangle = std::move(objects);
  return mesh;
}

Mesh crack(Mesh mesh, double x_m, double gap_m) {
  const double line = x_m - mesh.origin_m.x();
  std::map<std::uint32_t, std::uint32_t> moved;
  for (auto& triangle : mesh.triangles) {
    double middle = 0.0;
    for (const std::uint32_t v : triangle) middle += mesh.vertices_m[v].x() / 3;
    if (middle <= line) continue;
    for (std::uint32_t& v : triangle) {
      const auto [entry, added] =
          moved.try_emplace(v, static_cast<std::uint32_t>(mesh.vertices_m.size()));
      if (added) mesh.vertices_m.push_back(mesh.vertices_m[v] + Vector3d(gap_m, 0, 0));
      v = entry->second;
    }
  }
  return mesh;
}

}  // namespace support
