// The ground under a wheel: a CRG surface or a plane, and its friction.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "crg/surface.h"
#include "vehicle/car.h"

namespace vehicle {

/// Where the last queries of a car were found; scratch, never changes an answer.
struct RoadCursors {
  std::array<crg::Cursor, 4> wheel;
  std::array<std::array<crg::Cursor, 4>, 4> corner;  ///< of the wheels' patches; first: of a strip
};

/// One answer about the ground, map frame; T is double or a pack of them.
template <class T>
struct RoadPointOf {
  T z_m = 0.0;
  T dzdx = 0.0, dzdy = 0.0;
  T friction = 1.0;  ///< factor on the tyre's grip
  T u_m = 0.0, v_m = 0.0;
  Flag<T> on_road =
      true;  ///< false: beside the grid or over a hole; z_m is the nearest valid height
};
using RoadPoint = RoadPointOf<double>;

/// The ground. Refers to the surface, which must outlive it. Without a surface it is the plane
/// z = slope_x * x + slope_y * y, u = x, v = y. Immutable, may be shared between threads.
class Road {
 public:
  explicit Road(double slope_x = 0.0, double slope_y = 0.0)
      : slope_x_(slope_x), slope_y_(slope_y) {}
  explicit Road(const crg::Surface& surface) : surface_(&surface) {}

  /// The ground at (x, y) under wheel `wheel`. Where legs of the road cross at different heights,
  /// the leg nearest to z_near_m (NaN: the leg the surface answers with) counts. Over a hole or
  /// beside the grid: the nearest valid height along v, found in steps of a column (friction 1),
  /// level, of the leg nearest to z_near_m; where there is none within the road's width, z_m is
  /// NaN.
  RoadPoint at(double x_m, double y_m, double z_near_m, std::size_t wheel,
               RoadCursors& cursors) const noexcept;

  /// at() for one wheel of each of four cars in the usual case, see crg::Surface::ground_of_four;
  /// else false: ask at() one by one.
  bool at_four(const std::array<crg::Point2, 4>& places, const std::array<double, 4>& z_near_m,
               std::size_t wheel, const std::array<RoadCursors*, 4>& cursors,
               std::array<RoadPoint*, 4> out) const noexcept;

  /// z_m of at() at the four corners of a wheel's patch, in less time.
  std::array<double, 4> heights_at(const std::array<crg::Point2, 4>& corners, double z_near_m,
                                   std::size_t wheel, RoadCursors& cursors) const noexcept;

  /// at() for a wheel that looks at a strip of samples along `heading`, of any length: the plane
  /// that its two cams touch, averaged over the lines of the strip. Falls back to at() on the
  /// plane, where the strip sees no road, and on the other level of a bridge.
  RoadPoint under_strip(double x_m, double y_m, double z_near_m, crg::Point2 heading,
                        const StripShape& strip, const Cams& cams, std::size_t wheel,
                        RoadCursors& cursors) const noexcept;

  const crg::Surface* surface() const { return surface_; }

 private:
  crg::Ground other_leg(double x_m, double y_m, double z_near_m,
                        const crg::Ground& first) const noexcept;
  crg::Ground over_seam(const crg::Ground& gap) const noexcept;
  RoadPoint nearest_valid(const crg::UV& hole) const noexcept;
  RoadPoint beside_level(double x_m, double y_m, double z_near_m, RoadPoint best) const noexcept;

  const crg::Surface* surface_ = nullptr;
  double slope_x_ = 0.0, slope_y_ = 0.0;
};

/// Where a drive is along a road, place after place. Where legs of the road cross, a point lies on
/// several: the drive stays on the leg that it came along; without a place before, or far from it,
/// the leg nearest to `z_near_m` counts, where that is NaN the one that crg::Surface answers with.
class RoadTracker {
 public:
  explicit RoadTracker(const crg::Surface& surface) : surface_(&surface) {}

  /// NaN only for points that are not finite; these are no part of the drive.
  crg::UV at(double x_m, double y_m, double z_near_m = std::numeric_limits<double>::quiet_NaN());

  /// The place before, all that a later answer depends on: a tracker of the same road that gets it
  /// goes on as this one would.
  struct Place {
    double u_m = std::numeric_limits<double>::quiet_NaN(), v_m = 0.0;  ///< u NaN: none yet
    double x_m = 0.0, y_m = 0.0;
  };
  Place place() const { return last_; }
  void go_on_from(const Place& place) { last_ = place; }

 private:
  const crg::Surface* surface_;
  crg::Cursor cursor_;
  Place last_;
};

}  // namespace vehicle
