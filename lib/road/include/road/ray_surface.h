// Vertical rays on the drivable surface. Embree stays private to the source file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "road/mesh.h"

struct RTCRayHit16;  // Embree's

namespace road {

/// A hit of a vertical ray, in the map frame of the mesh.
struct SurfaceHit {
  double z_m = std::numeric_limits<double>::quiet_NaN();
  std::uint32_t triangle = 0;
};

/// 16 vertical rays at once. x, y, z are local to RaySurface::origin_m(). Faster when used again than when made anew.
struct RayPacket16 {
  alignas(64) std::array<float, 16> x_m, y_m, z_top_m;  ///< rays go down from z_top
  alignas(64) std::array<std::int32_t, 16> active;      ///< -1 cast this ray, 0 leave it out
  alignas(64) std::array<float, 16> z_m;                ///< out: height of the hit; NaN without hit
  alignas(64) std::array<std::uint32_t, 16> triangle;   ///< out; meaningless without hit
  float max_depth_m = 4.0f;                             ///< in: how far down a ray looks

 private:
  friend class RaySurface;
  bool ready_ = false;
  alignas(64) std::array<std::byte, 1408> embree_;
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

  /// The hit nearest to `z_near_m` within ±reach_m on the vertical line through (x, y) (map frame).
  std::optional<SurfaceHit> nearest_hit(double x_m, double y_m, double z_near_m, double reach_m) const;

  /// All hits on the vertical line through (x, y), from high to low; hits closer than 1 mm are merged.
  std::vector<SurfaceHit> all_hits(double x_m, double y_m) const;

 private:
  static RTCRayHit16& embree_packet(RayPacket16& packet);

  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace road
