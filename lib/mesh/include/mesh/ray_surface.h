// Vertical rays on the drivable surface. Embree stays private to the source file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "mesh/mesh.h"

namespace road {

/// A hit of a vertical ray, in the map frame of the mesh.
struct SurfaceHit {
  double z_m = std::numeric_limits<double>::quiet_NaN();
  std::uint32_t triangle = 0;
  double upright = 1.0;  ///< 1 on a level triangle, 0 on a vertical one: what of its normal is up
};

/// 16 vertical rays at once. x, y, z are local to RaySurface::origin_m(). Begins as Embree's own
/// packet does, so that nothing is copied; what the comments leave out is Embree's.
struct alignas(64) RayPacket16 {
  template <typename T>
  using Lanes = std::array<T, 16>;
  template <typename T>
  static constexpr Lanes<T> all(T value) {
    Lanes<T> lanes{};
    lanes.fill(value);
    return lanes;
  }

  Lanes<float> x_m{}, y_m{}, z_top_m{};  ///< in: rays go down from z_top
  Lanes<float> from_m{}, direction_x{}, direction_y{}, direction_z = all(-1.0f), time{};
  Lanes<float> depth_m{};  ///< out: from z_top to the hit
  Lanes<std::uint32_t> mask = all(~0u), id{}, flags{};
  Lanes<float> normal_x{}, normal_y{}, normal_z{}, first_weight{}, second_weight{};
  Lanes<std::uint32_t> triangle{};  ///< out; meaningless without hit
  Lanes<std::uint32_t> geometry{}, instance{};

  Lanes<std::int32_t> active{};  ///< in: -1 cast this ray, 0 leave it out
  Lanes<float> z_m{};            ///< out: height of the hit; NaN without hit
  float max_depth_m = 4.0f;      ///< in: how far down a ray looks
};

/// A ray in any direction, in the map frame of the mesh.
struct Ray {
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< of length 1
};

/// A hit of such a ray. `normal` has length 1 and either side.
struct RayHit {
  double range_m = std::numeric_limits<double>::quiet_NaN();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};

/// Acceleration structure over a mesh; immutable after construction, shared by threads.
/// Heights are within 10 um of the float32 triangle for rays that start within 10 m above it.
class RaySurface {
 public:
  explicit RaySurface(const Mesh& mesh);
  ~RaySurface();
  RaySurface(RaySurface&&) noexcept;
  RaySurface& operator=(RaySurface&&) noexcept;

  const Eigen::Vector3d& origin_m() const noexcept;

  /// First hit of each active ray below its z_top, two-sided.
  void cast_down(RayPacket16& packet) const noexcept;

  /// The same without what goes before and after it, for callers that do so 16 lanes at once: all
  /// of depth_m is how far to look and all of geometry -1; without hit, geometry stays -1. Neither
  /// reads max_depth_m nor sets z_m.
  void cast_prepared(RayPacket16& packet) const noexcept;

  /// The first hit from `from_m` to `reach_m` along the ray, two-sided. `range_m` is within a
  /// float's error of the distance from the middle of the mesh.
  std::optional<RayHit> first_hit(const Ray& ray, double from_m, double reach_m) const;

  /// The hit nearest to `z_near_m` within ±reach_m on the vertical line through (x, y) (map frame).
  std::optional<SurfaceHit> nearest_hit(double x_m, double y_m, double z_near_m,
                                        double reach_m) const;

  /// All hits on the vertical line through (x, y), from high to low; hits closer than 1 mm are
  /// merged.
  std::vector<SurfaceHit> all_hits(double x_m, double y_m) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace road
