// Kinematics of a wheel over its travel; springs, bars, stops and dampers.
#pragma once

#include <cmath>
#include <cstddef>

#include "vehicle/laws/wheel_path.h"
#include "vehicle/maths.h"
#include "vehicle/parameters.h"
#include "vehicle/vec3.h"

namespace vehicle::laws {

/// Where a wheel is at a travel, body frame: camber and toe as the left wheel's (negative: top
/// inwards; positive: toe-in), the centre from its design place, the centre's path and the wheel's
/// rotation per travel, and how the path bends.
template <class T>
struct WheelMotion {
  T camber_rad, toe_rad;
  Vec3<T> away_m;  ///< of the centre; not set by linear kinematics: travel slide
  Vec3<T> slide{T(0), T(0), T(1)}, turn, bend;
  bool curved = false;  ///< away_m is set
};

/// `amount` of suspension_kinematics; axle 0 front, `side` 1 left, -1 right. By `path` where it is
/// given, else linear by the parameters: roll centre and anti slope set the direction of the path
/// (W. F. and D. L. Milliken, Race Car Vehicle Dynamics, SAE 1995: instant centres).
template <class T>
WheelMotion<T> wheel_motion(const Parameters<T>& p, const WheelPath& path, const T& amount,
                            std::size_t axle, double side, const T& travel_m) {
  using P = Parameter;
  WheelMotion<T> out;
  out.camber_rad =
      p.axle(axle, P::front_camber_rad) + side * p.axle(axle, P::front_camber_split_rad);
  out.toe_rad = p.axle(axle, P::front_toe_rad) + side * p.axle(axle, P::front_toe_split_rad);
  if (is_exactly_zero(amount)) return out;
  if (path.given()) {
    const auto at = [&](const WheelPath::Coefficients& c) {
      return along_travel(c, path.range_m, travel_m);
    };
    const AlongTravel<T> ahead = at(path.ahead_m), outward = at(path.outward_m);
    const AlongTravel<T> leans = at(path.camber_rad), turns = at(path.toe_rad);
    out.camber_rad += amount * leans.value;
    out.toe_rad += amount * turns.value;
    out.slide.x = amount * ahead.slope;
    out.slide.y = side * amount * outward.slope;
    out.turn.x = -side * amount * leans.slope;
    out.turn.z = -side * amount * turns.slope;
    out.bend = {amount * ahead.curvature, side * amount * outward.curvature, T(0)};
    out.away_m = {amount * ahead.value, side * amount * outward.value, travel_m};
    out.curved = true;
    return out;
  }
  const T camber_gain = amount * p.axle(axle, P::front_camber_gain_radpm);
  const T toe_gain = amount * p.axle(axle, P::front_toe_gain_radpm);
  out.camber_rad += camber_gain * travel_m;
  out.toe_rad += toe_gain * travel_m;
  out.slide.x = (axle == 0 ? 1.0 : -1.0) * amount * p.axle(axle, P::front_anti_slope);
  out.slide.y =
      side * 2.0 * amount * p.axle(axle, P::front_roll_centre_m) / p.axle(axle, P::front_track_m);
  out.turn.x = -side * camber_gain;
  out.turn.z = -side * toe_gain;
  return out;
}

/// Steering angle of one front wheel, rad, left positive, at a mean angle: Ackermann's difference
/// to the second order, as a share.
template <class T>
T ackermann_angle(const Parameters<T>& p, double side, const T& mean_rad) {
  using P = Parameter;
  return mean_rad + side * p[P::steering_ackermann] * mean_rad * mean_rad *
                        p.axle(0, P::front_track_m) / (2.0 * p[P::chassis_wheelbase_m]);
}

/// How far a travel is pressed into the bump stop and into the droop stop, m; below 0: not.
template <class T>
struct StopCompression {
  T bump_m, droop_m;
};

template <class T>
StopCompression<T> stop_compression(const Parameters<T>& p, std::size_t axle, const T& travel_m) {
  return {travel_m - p.axle(axle, Parameter::front_bump_clearance_m),
          -travel_m - p.axle(axle, Parameter::front_droop_clearance_m)};
}

/// Forces of bar and stops at a wheel, 0 to 1 each.
template <class T>
struct SpringAmounts {
  T bar, stops;
};

/// Rate of a wheel's spring, N/m, and what its perch adds to the preload, N; `side` 1 left,
/// -1 right.
template <class T>
struct CornerSpring {
  T rate_npm, preload_n;
};

template <class T>
CornerSpring<T> corner_spring(const Parameters<T>& p, std::size_t axle, double side) {
  using P = Parameter;
  return {p.axle(axle, P::front_spring_npm) + side * p.axle(axle, P::front_spring_split_npm),
          side * p.axle(axle, P::front_perch_split_n)};
}

/// Force along the travel, N, positive in bump: the spring with the preload that carries
/// `sprung_n` at design travel, the anti-roll bar against the other wheel, and stops whose force
/// grows with the square of their compression.
template <class T>
T spring_force(const Parameters<T>& p, const SpringAmounts<T>& amount, std::size_t axle,
               double side, const T& sprung_n, const T& travel_m, const T& other_travel_m) {
  using P = Parameter;
  const CornerSpring<T> own = corner_spring(p, axle, side);
  T spring = -sprung_n - own.preload_n - own.rate_npm * travel_m;
  if (!is_exactly_zero(amount.bar))
    spring -= amount.bar * p.axle(axle, P::front_anti_roll_npm) * (travel_m - other_travel_m);
  if (!is_exactly_zero(amount.stops)) {
    const StopCompression<T> into = stop_compression(p, axle, travel_m);
    const T k = amount.stops * p.axle(axle, P::front_bump_stop_npm2);
    spring = select(into.bump_m > T(0), T(spring - k * into.bump_m * into.bump_m), spring);
    spring = select(into.droop_m > T(0), T(spring + k * into.droop_m * into.droop_m), spring);
  }
  return spring;
}

/// Digressive damper, N, positive against bump: full damping of slow travel, a share of it beyond
/// the knee (own choice of a smooth curve; a map of the maker's is better where there is one).
template <class T>
T damper_force(const Parameters<T>& p, std::size_t axle, const T& rate_mps) {
  using P = Parameter;
  using maths::tanh;
  const T& knee = p.axle(axle, P::front_damper_knee_mps);
  const T& share = p.axle(axle, P::front_damper_fast_share);
  return select(rate_mps > T(0), p.axle(axle, P::front_bump_damping_nspm),
                p.axle(axle, P::front_rebound_damping_nspm)) *
         (share * rate_mps + (1.0 - share) * knee * tanh(T(rate_mps / knee)));
}

}  // namespace vehicle::laws
