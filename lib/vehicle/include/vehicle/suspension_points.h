// Suspensions given by the points of their links: where the wheel goes when it travels.
#pragma once

#include <array>

#include "vehicle/laws/wheel_path.h"
#include "vehicle/vec3.h"

namespace vehicle {

/// Five rigid links between body and upright of a left wheel, ball joints at their ends: a
/// five-link suspension. A double wishbone is one too: each arm is two links that share their outer
/// end, the fifth is the tie or track rod. Any frame parallel to the body's (x forward, y left, z
/// up), m.
struct SuspensionPoints {
  struct Link {
    Vec3<double> inner_m, outer_m;
  };
  std::array<Link, 5> link;
  Vec3<double> wheel_m;   ///< wheel centre at design travel
  double range_m = 0.08;  ///< travel either way that the links allow and the polynomials cover
};

/// Where the upright is.
struct UprightPose {
  Vec3<double> wheel_m;                   ///< wheel centre
  std::array<Vec3<double>, 3> direction;  ///< of the upright's x, y, z axes; y is the wheel's axis
  double camber_rad, toe_rad;  ///< change from design: top outward, and front inward, positive
};

/// The pose at a travel of the wheel centre, and with the inner end of link 5 moved `rack_m` to the
/// left. Newton
/// iterations from design in small steps; lengths of all links within 1e-12 m. Throws Error where
/// the links do not reach or do not hold the upright (a singular position).
UprightPose solve_suspension(const SuspensionPoints& points, double travel_m, double rack_m = 0.0);

/// The path over the whole range as polynomials, rack at its centre. Throws Error also where the
/// polynomials are more than 20 micrometres or 20 microradians off the solution (range too wide).
WheelPath make_wheel_path(const SuspensionPoints& points);

}  // namespace vehicle
