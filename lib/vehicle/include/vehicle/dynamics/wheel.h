// A wheel's place and attitude, and the road that it touches.
#pragma once

#include <cmath>

#include "vehicle/dynamics/evaluation.h"
#include "vehicle/laws/suspension.h"

namespace vehicle::dynamics {

/// Height, slope and friction under a wheel, for any scalar: the road stays double, its height
/// follows the scalar through the gradient (the gradient itself counts as constant).
template <class T>
struct Ground {
  T z_m;
  Real<T> dzdx, dzdy;
};

/// What a car's contact makes of the road's answer at (x, y), `point`.
template <class T>
Ground<T> rest_on(const Road& road, const Car<T>& car, std::size_t wheel, const T& x_m,
                  const T& y_m, double z_near_m, double heading_x, double heading_y,
                  RoadCursors& cursors, RoadPoint& point) {
  const double x = value_of(x_m), y = value_of(y_m);
  if (car.contact == Contact::kFourPoint) {
    const std::size_t a = axle_of(wheel);
    const double half_length_m = car.patch[2 * a], half_width_m = car.patch[2 * a + 1];
    const double length = std::hypot(heading_x, heading_y);
    const double fx = heading_x / length, fy = heading_y / length;
    std::array<crg::Point2, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) {
      const double along = k < 2 ? half_length_m : -half_length_m;
      const double across = k % 2 == 0 ? half_width_m : -half_width_m;
      corners[k] = {x + along * fx - across * fy, y + along * fy + across * fx};
    }
    const std::array<double, 4> z = road.heights_at(corners, z_near_m, wheel, cursors);
    const double slope_along = (z[0] + z[1] - z[2] - z[3]) / (4.0 * half_length_m);
    const double slope_across = (z[0] - z[1] + z[2] - z[3]) / (4.0 * half_width_m);
    point.z_m = (z[0] + z[1] + z[2] + z[3]) / 4.0;
    point.dzdx = slope_along * fx - slope_across * fy;
    point.dzdy = slope_along * fy + slope_across * fx;
  }
  return {point.z_m + point.dzdx * (x_m - x) + point.dzdy * (y_m - y), point.dzdx, point.dzdy};
}

template <class T>
Ground<T> ground_under(const Road& road, const Car<T>& car, std::size_t wheel, const T& x_m,
                       const T& y_m, double z_near_m, double heading_x, double heading_y,
                       RoadCursors& cursors, RoadPoint& point) {
  const double x = value_of(x_m), y = value_of(y_m);
  if (car.contact == Contact::kStrip) {
    point = road.under_strip(x, y, z_near_m, {heading_x, heading_y}, car.strip,
                             car.cams[axle_of(wheel)], wheel, cursors);
  } else {
    point = road.at(x, y, z_near_m, wheel, cursors);
  }
  return rest_on(road, car, wheel, x_m, y_m, z_near_m, heading_x, heading_y, cursors, point);
}

/// Directions of a wheel, body frame: forward and up in the wheel's own plane.
template <class T>
struct WheelPose {
  Vec3<T> forward, up;
};

/// Kinematics of suspension and steering: path, axis and spin of wheel `i`.
template <class T, TermSet Built>
WheelPose<T> place_wheel(Evaluation<T, Built>& e, std::size_t i) {
  const std::size_t a = axle_of(i);
  const double side = is_left(i) ? 1.0 : -1.0;
  const T& travel = e.s[kTravel + i];
  const laws::WheelMotion<T> motion = laws::wheel_motion(
      e.p, e.files.wheel_path[a], e.amount(Term::suspension_kinematics), a, side, travel);
  e.slide[i] = motion.slide;
  e.turn[i] = motion.turn;
  e.bend[i] = motion.bend;
  e.slide2[i] = dot(e.slide[i], e.slide[i]);
  e.centre[i] = e.car.wheel_m[i] + (motion.curved ? motion.away_m : Vec3<T>(travel * e.slide[i]));
  const T lean = -side * motion.camber_rad;  // rotation about x; the top of the wheel leans right
  T steer = -side * motion.toe_rad;
  if (a == 0) steer += laws::ackermann_angle(e.p, side, e.in.steer_rad);
  const auto [steered, leaning] = maths::waves_of(steer, lean);
  const T &cs = steered.cosine, &ss = steered.sine, &cl = leaning.cosine, &sl = leaning.sine;
  e.axis[i] = {-ss * cl, cs * cl, sl};
  e.spin[i] = e.s[kSpin + i] - dot(e.omega, e.axis[i]);
  WheelDetail<T>& w = e.detail.wheel[i];
  w.spin_radps = e.spin[i];
  w.axis = e.axis[i];
  w.centre = e.centre[i];
  w.slide = e.slide[i];
  return {{cs, ss, T(0)}, {ss * sl, -cs * sl, cl}};
}

/// Where a wheel touches: distances of the centre from the tread at rest and from the road, m, and
/// the velocity of the contact point, body frame.
template <class T>
struct Touch {
  T free_radius_m, radius_m;
  Vec3<T> velocity_mps;
};

/// Contact with the plane that touches the road below the wheel, and the load by the deflection.
template <class T, TermSet Built, class Roads, class Cursors>
Touch<T> touch_road(Evaluation<T, Built>& e, std::size_t i, const WheelPose<T>& pose,
                    const Roads& road, Cursors& cursors) {
  using P = Parameter;
  using maths::asin;
  using std::sqrt;
  const std::size_t a = axle_of(i);
  WheelDetail<T>& w = e.detail.wheel[i];
  const TyreCoefficients& tyre = e.files.tyre[a];
  const double r0 = tyre.unloaded_radius_m;
  const Vec3<T> below = e.position + e.R.apply(e.centre[i] - T(r0) * pose.up);
  const Vec3<T> forward_map = e.R.apply(pose.forward);
  const Ground<T> ground =
      ground_under(road, e.car, i, below.x, below.y, value_of(below.z), value_of(forward_map.x),
                   value_of(forward_map.y), cursors, w.road);
  const Real<T> tilt = 1.0 / sqrt(1.0 + ground.dzdx * ground.dzdx + ground.dzdy * ground.dzdy);
  const Vec3<T> n = e.R.undo({T(-ground.dzdx * tilt), T(-ground.dzdy * tilt), T(tilt)});
  w.normal = n;
  w.heading = unit(cross(e.axis[i], n));
  w.left = cross(n, w.heading);
  const Vec3<T> radial = cross(w.heading, e.axis[i]);  // from the contact to the centre
  const T sin_camber = dot(e.axis[i], n);
  w.camber_rad = asin(sin_camber);
  const Vec3<T> to_centre =
      e.position + e.R.apply(e.centre[i]) - Vec3<T>{below.x, below.y, ground.z_m};
  Touch<T> out;
  out.radius_m = dot(e.R.undo(to_centre), n) / dot(radial, n);
  const T speed_ratio = e.spin[i] * r0 / tyre.nominal_speed_mps;
  out.free_radius_m = r0 * (tyre.qre0 + tyre.qv1 * speed_ratio * speed_ratio);
  w.deflection_m = out.free_radius_m - out.radius_m - e.in.sunk_m[i];
  w.contact_m = e.centre[i] - out.radius_m * radial;
  w.arm = w.contact_m - e.centre[i];
  w.swing = e.slide[i] + cross(e.turn[i], w.arm);  // d contact / d travel
  const Vec3<T> v = e.V + cross(e.omega, w.contact_m) + e.s[kTravelRate + i] * w.swing;
  out.velocity_mps = v;
  w.ride_m = dot(e.car.wheel_m[i] - w.contact_m, n) - e.car.static_radius_m[a] +
             e.p.axle(a, P::front_ride_height_m);
  const auto pressed = w.deflection_m > T(0);
  if (any(pressed)) {
    const T& pressure = e.p.axle(a, P::front_tyre_pressure_pa);
    const T load = tyre_load(tyre, w.deflection_m, e.spin[i], pressure) -
                   tyre.vertical_damping_nspm * dot(v, n);
    w.fz_n = select(pressed, select(load < T(0), T(0), load), T(0));
  }
  w.rolling_radius_m = rolling_radius(tyre, w.fz_n, out.free_radius_m, w.deflection_m);
  w.vx_mps = dot(v, w.heading);
  w.slip_x_mps = w.vx_mps - e.spin[i] * w.rolling_radius_m;
  w.slip_y_mps = dot(v, w.left);
  return out;
}

}  // namespace vehicle::dynamics
