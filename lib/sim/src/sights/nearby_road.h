// The surface of a road as rays see it, however long the road is. Private to lib/sim.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "crg/surface.h"
#include "mesh/ray_surface.h"

namespace sim {

/// Triangles of the road, made a stretch at a time where rays go, and forgotten where they no
/// longer do. A hit on a triangle is moved along its ray onto z(u, v) of the road itself, where it
/// can be found there; so what is between the nodes counts too. Holes, and what is beside the
/// grid, are seen through.
class NearbyRoad {
 public:
  explicit NearbyRoad(std::shared_ptr<const crg::Surface> surface);

  /// Chooses the stretches of the road that lie within `reach_m` of a place, and makes those that
  /// are missing.
  void look_around(const Eigen::Vector3d& from_m, double reach_m);
  /// The first hit of a ray on the stretches of the last look_around().
  std::optional<road::RayHit> first_hit(const road::Ray& ray, double nearest_m, double reach_m);

  std::size_t stretches_held() const;

 private:
  struct Stretch {
    std::size_t first_row = 0, last_row = 0;
    double low_x_m, high_x_m, low_y_m, high_y_m;
    std::unique_ptr<const road::RaySurface> surface;
    std::uint64_t used = 0;  ///< look_around() that needed it last
  };

  void make(Stretch& stretch) const;
  void forget_the_oldest();
  road::RayHit onto_the_road(const road::Ray& ray, const road::RayHit& hit);

  std::shared_ptr<const crg::Surface> surface_;
  std::vector<double> v_m_;  ///< of the columns that become triangles
  std::size_t stride_ = 1;   ///< rows from one to the next that do
  std::vector<Stretch> stretches_;
  std::vector<const Stretch*> near_;
  crg::Cursor cursor_;
  std::uint64_t looks_ = 0;
};

}  // namespace sim
