#include "scenery.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloud {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kIntoLeaves_m = 0.3;

/// Where a ray enters and leaves a round body; enter > leave where it passes by.
struct Crossing {
  double enter = 0.0, leave = kNever;
};

Crossing crossing_of(const Round& round, const Eigen::Vector3d& from,
                     const Eigen::Vector3d& along) {
  const Eigen::Vector3d d = from - round.foot_m;
  const double a = along.head<2>().squaredNorm(), b = d.head<2>().dot(along.head<2>()),
               c = d.head<2>().squaredNorm() - round.radius_m * round.radius_m;
  const double root2 = b * b - a * c;
  if (!(a > 1e-12 && root2 > 0.0)) return {kNever, 0.0};
  const double root = std::sqrt(root2);
  Crossing out{(-b - root) / a, (-b + root) / a};
  if (std::abs(along.z()) < 1e-12)
    return d.z() > 0.0 && d.z() < round.height_m ? out : Crossing{kNever, 0.0};
  const double low = -d.z() / along.z(), high = (round.height_m - d.z()) / along.z();
  out.enter = std::max(out.enter, std::min(low, high)),
  out.leave = std::min(out.leave, std::max(low, high));
  return out;
}

}  // namespace

double distance_to(const Box& box, const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
  const Eigen::Vector3d d = from - box.middle_m;
  const auto turned = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(p.x() * box.heading.x() + p.y() * box.heading.y(),
                           p.y() * box.heading.x() - p.x() * box.heading.y(), p.z());
  };
  const Eigen::Vector3d p = turned(d), a = turned(along);
  double near = 0.0, far = kNever;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(a[k]) < 1e-12) {
      if (std::abs(p[k]) > box.half_m[k]) return kNever;
      continue;
    }
    const double t1 = (-box.half_m[k] - p[k]) / a[k], t2 = (box.half_m[k] - p[k]) / a[k];
    near = std::max(near, std::min(t1, t2)), far = std::min(far, std::max(t1, t2));
  }
  return near <= far && near > 0.0 ? near : kNever;
}

Scenery scenery_along(const RoadFrame& frame, double every_m, double from_m, std::uint64_t seed) {
  Scenery scenery;
  if (!(every_m > 0.0)) return scenery;
  base::Random random(seed * 0xD1B54A32D192ED03ULL + 1);
  const auto count = static_cast<std::size_t>(frame.length_m() / every_m);
  for (std::size_t n = 0; n < count; ++n)
    for (const double side : {-1.0, 1.0}) {
      const double along = (static_cast<double>(n) + random.uniform()) * every_m,
                   v_m = side * (from_m + 1.0 + 2.5 * random.uniform()), kind = random.uniform(),
                   size = random.uniform();
      const GridPlace place{
          std::min(along / frame.u_step_m(), static_cast<double>(frame.rows() - 1)), v_m};
      const double ground = frame.height(place);
      if (!std::isfinite(ground)) continue;
      const Eigen::Vector2d spot =
          frame.node_position(static_cast<std::size_t>(place.row), place.v_m);
      const Eigen::Vector3d foot(spot.x(), spot.y(), ground + frame.z_origin_m() - 0.1);
      if (kind < 0.35) {  // a pole
        scenery.rounds.push_back({foot, 0.05 + 0.1 * size, 4.0, false});
      } else if (kind < 0.75) {  // a tree
        scenery.rounds.push_back({foot, 0.1 + 0.2 * size, 3.0, false});
        scenery.rounds.push_back(
            {foot + Eigen::Vector3d(0.0, 0.0, 0.8 + size), 0.8 + 0.7 * size, 4.0, true});
      } else {  // a wall along the road
        const double heading = frame.heading_rad(place.row), high = 0.7 + 0.6 * size;
        scenery.walls.push_back({foot + Eigen::Vector3d(0.0, 0.0, 0.5 * high),
                                 {std::cos(heading), std::sin(heading)},
                                 {1.5 + 2.0 * size, 0.15, 0.5 * high}});
      }
    }
  return scenery;
}

Scenery near_of(const Scenery& all, const Eigen::Vector3d& place_m, double range_m) {
  Scenery near;
  const auto reaches = [&](const Eigen::Vector3d& at, double size_m) {
    return (at - place_m).head<2>().norm() < range_m + size_m;
  };
  for (const Round& round : all.rounds)
    if (reaches(round.foot_m, round.radius_m)) near.rounds.push_back(round);
  for (const Box& wall : all.walls)
    if (reaches(wall.middle_m, wall.half_m.norm())) near.walls.push_back(wall);
  return near;
}

double distance_to(const Scenery& scenery, const Eigen::Vector3d& from,
                   const Eigen::Vector3d& along, base::Random& random) {
  double nearest = kNever;
  for (const Box& wall : scenery.walls) nearest = std::min(nearest, distance_to(wall, from, along));
  for (const Round& round : scenery.rounds) {
    auto [enter, leave] = crossing_of(round, from, along);
    if (!(enter > 0.0 && enter < leave)) continue;
    if (round.leaves) enter -= kIntoLeaves_m * std::log(1.0 - random.uniform());
    if (enter < leave) nearest = std::min(nearest, enter);
  }
  return nearest;
}

}  // namespace cloud
