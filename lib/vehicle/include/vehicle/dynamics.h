// The equations of motion: the time derivative of the state as a pure function.
//
// Body frame: x forward, y left, z up, origin in the design centre of mass. The body carries four
// point masses that slide along a direction fixed in the body (prismatic joints) and four rotors.
// Their accelerations are eliminated exactly (R. Featherstone, Rigid Body Dynamics Algorithms,
// 2008, chapter 7: articulated-body inertia), which leaves one symmetric 6 x 6 system.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "vehicle/car.h"
#include "vehicle/laws/brake_disc.h"
#include "vehicle/laws/turbocharger.h"
#include "vehicle/road.h"

namespace vehicle {

/// What happens at one wheel; vectors in the body frame.
template <class T>
struct WheelDetail {
  T fz_n = T(0), fx_n = T(0), fy_n = T(0);  ///< along the road's normal, the wheel's heading, left
  T kappa = T(0), tan_alpha = T(0);         ///< slips that the tyre formula was given
  T camber_rad = T(0);                      ///< inclination against the road
  T deflection_m = T(0);
  T slip_x_mps = T(0), slip_y_mps = T(0);    ///< velocity of the tread against the road
  T vx_mps = T(0);                           ///< of the contact point along the wheel's heading
  T brake_nm = T(0), drive_nm = T(0);        ///< torques on the wheel, forward positive
  T ride_m = T(0);                           ///< height of the floor over the road at this wheel
  Vec3<T> contact_m, heading, left, normal;  ///< contact point and axes on the road
  T rolling_radius_m = T(0);
  T decay_x_1ps = T(0), decay_y_1ps = T(0);  ///< of the contact patch's deflections
  T yield_x = T(1), yield_y = T(1);          ///< their rate per sliding speed, less by damping
  T spin_radps = T(0);                       ///< against the body
  T brake_capacity_nm = T(0);                ///< largest brake torque, either way
  Vec3<T> axis, arm, swing;  ///< spin axis; wheel centre to contact; contact per travel
  Vec3<T> centre, slide;     ///< wheel centre, and its path per travel
  Vec3<T> couple;            ///< moment of the tyre on the wheel
  T couple_on_travel = T(0), damper_n = T(0);
  RoadPoint road;
};

/// Powers that enter or leave the car, W; positive feeds the motion.
template <class T>
struct Powers {
  T tyre_normal = T(0);            ///< road on wheels along the normal, with the tyre's own spring
  T tyre_x = T(0), tyre_y = T(0);  ///< tangential forces at the tread
  T tyre_moment = T(0);            ///< rolling resistance, aligning, overturning
  T drag = T(0), downforce = T(0), side = T(0);
  T damper = T(0);
  T brake = T(0);
  T engine = T(0);     ///< torque of the engine on its own shaft
  T driveline = T(0);  ///< lost in clutch, gears and differential
  T clutch = T(0);     ///< the clutch's part of it
  T fuel = T(0);       ///< motion and height of the mass that burns
  T hold = T(0);       ///< the push from outside
  T unfelt = T(0);     ///< by what wheel_reaction below 1 leaves out of the body
  T turbo = T(0);      ///< on the turbocharger's shaft

  T sum() const {
    return tyre_normal + tyre_x + tyre_y + tyre_moment + drag + downforce + side + damper + brake +
           engine + driveline + fuel + hold + unfelt + turbo;
  }
};

/// By-products of one evaluation, for telemetry, integration and checks.
template <class T>
struct Detail {
  Inputs<T> inputs;  ///< what the car was given
  std::array<WheelDetail<T>, kWheels> wheel;
  Powers<T> power;
  Vec3<T> specific_force_mps2;  ///< at the origin, body frame: what an accelerometer there measures
  T engine_nm = T(0), clutch_nm = T(0);
  T gear_ratio = T(0);  ///< engine over mean driven wheel; 0 in neutral, below 0 in reverse
  T drive_efficiency = T(1);
  T clutch_slip_radps = T(0);     ///< engine against gearbox
  T clutch_stiffness_nms = T(0);  ///< fall of the clutch torque per slip speed
  T differential_nm = T(0), differential_slip_radps = T(0), differential_stiffness_nms = T(0);
  T limited_slip_nm = T(0);    ///< the part of limited slip in the first, fully sliding
  T limited_slip_grip = T(0);  ///< share of it that acts, signed
  T drag_n = T(0), front_downforce_n = T(0), rear_downforce_n = T(0);
  T drag_x_n = T(0), drag_y_n = T(0), side_n = T(0);  ///< along the body's axes
  T boost = T(0);  ///< the state; full turbo: charge over wastegate pressure, both above the air
  laws::TurboRates<T> turbo;                  ///< of the full turbocharged engine
  std::array<std::array<T, 6>, 6> inertia{};  ///< of the body with its wheels, LDL^T factors
};

namespace dynamics_detail {

/// x clipped to [low, high]; the derivative is zero outside.
template <class T>
T clip(const T& x, double low, double high) {
  return x < T(low) ? T(low) : (x > T(high) ? T(high) : x);
}

/// Rises from 0 to 1 over [0, 1] without a kink.
template <class T>
T smooth_step(const T& x) {
  const T c = clip(x, 0.0, 1.0);
  return c * c * (3.0 - 2.0 * c);
}

/// Factors a symmetric positive definite 6 x 6 matrix in place (LDL^T, lower triangle).
template <class T>
void factor6(std::array<std::array<T, 6>, 6>& a) {
  for (std::size_t j = 0; j < 6; ++j) {
    for (std::size_t k = 0; k < j; ++k) {
      const T l = a[j][k];
      const T ld = l * a[k][k];
      a[j][j] -= l * ld;
      for (std::size_t i = j + 1; i < 6; ++i) a[i][j] -= a[i][k] * ld;
    }
    const T inverse = T(1) / a[j][j];
    for (std::size_t i = j + 1; i < 6; ++i) a[i][j] *= inverse;
  }
}

/// Solves a x = b in place with the factors of a.
template <class T>
void solve6(const std::array<std::array<T, 6>, 6>& a, std::array<T, 6>& b) {
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
  for (std::size_t i = 0; i < 6; ++i) b[i] /= a[i][i];
  for (std::size_t i = 6; i-- > 0;)
    for (std::size_t k = i + 1; k < 6; ++k) b[i] -= a[k][i] * b[k];
}

/// Adds weight * (projector orthogonal to d) of a point mass at r to the 6 x 6 inertia: the mass
/// that the body feels of something free to move along d. d = 0: the whole mass.
template <class T>
void add_point_mass(std::array<std::array<T, 6>, 6>& m, const T& mass, const Vec3<T>& r,
                    const Vec3<T>& d, const T& d2) {
  // Columns of the map from (acceleration of the origin, angular acceleration) to that at r.
  const std::array<Vec3<T>, 6> column{{{T(1), T(0), T(0)},
                                       {T(0), T(1), T(0)},
                                       {T(0), T(0), T(1)},
                                       {T(0), -r.z, r.y},
                                       {r.z, T(0), -r.x},
                                       {-r.y, r.x, T(0)}}};
  std::array<T, 6> along;
  for (std::size_t i = 0; i < 6; ++i) along[i] = dot(column[i], d);
  const T scale = mass / d2;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j <= i; ++j)
      m[i][j] += mass * dot(column[i], column[j]) - scale * along[i] * along[j];
}

}  // namespace dynamics_detail

/// Friction torque of the limited slip differential, fully sliding, under a torque `driven_nm`.
template <class T>
T limited_slip_torque(const Car<T>& car, const T& driven_nm) {
  using std::abs;
  using P = Parameter;
  const Parameters<T>& p = car.parameters;
  const T& ramp = driven_nm > T(0) ? p[P::differential_drive_ramp] : p[P::differential_coast_ramp];
  return car.terms[Term::limited_slip] * (p[P::differential_preload_nm] + ramp * abs(driven_nm)) *
         0.5;
}

/// The air path's parameters as its law wants them.
template <class T>
laws::TurboParameters<T> turbo_parameters(const Parameters<T>& p) {
  using P = Parameter;
  return {p[P::engine_displacement_m3],
          p[P::engine_compression],
          p[P::engine_filling],
          p[P::engine_indicated],
          p[P::engine_coolant_share],
          p[P::engine_air_fuel],
          p[P::engine_friction_pa],
          p[P::engine_friction_pas],
          p[P::intake_manifold_m3],
          p[P::intake_charge_m3],
          p[P::intake_throttle_m2],
          p[P::intake_leak_m2],
          p[P::intake_cooler],
          p[P::intake_overrun_m2],
          p[P::intake_overrun_pa],
          p[P::intake_overrun_range_pa],
          p[P::compressor_diameter_m],
          p[P::compressor_head],
          p[P::compressor_flow],
          p[P::compressor_efficiency],
          p[P::compressor_best_flow],
          p[P::compressor_narrowness],
          p[P::turbine_diameter_m],
          p[P::turbine_area_m2],
          p[P::turbine_efficiency],
          p[P::turbine_blade_ratio],
          p[P::turbine_exhaust_m3],
          p[P::turbine_wastegate_m2],
          p[P::turbine_wastegate_pa],
          p[P::turbine_wastegate_range_pa],
          p[P::turbo_inertia_kgm2],
          p[P::turbo_bearing_nms],
          p[P::fuel_energy_jpkg],
          T(p[P::aero_density_kgpm3] * laws::kGas * p[P::environment_temperature_k]),
          p[P::environment_temperature_k]};
}

/// Height, slope and friction under a wheel, for any scalar: the road stays double, its height
/// follows the scalar through the gradient (the gradient itself counts as constant).
template <class T>
struct Ground {
  T z_m;
  double dzdx, dzdy;
};

template <class T>
Ground<T> ground_under(const Road& road, const Car<T>& car, std::size_t wheel, const T& x_m,
                       const T& y_m, double z_near_m, double heading_x, double heading_y,
                       RoadCursors& cursors, RoadPoint& point) {
  const double x = value_of(x_m), y = value_of(y_m);
  const std::size_t a = axle_of(wheel);
  if (car.contact == Contact::kStrip) {
    point = road.under_strip(x, y, z_near_m, std::atan2(heading_y, heading_x), car.strip,
                             car.cams[a], wheel, cursors);
  } else {
    point = road.at(x, y, z_near_m, wheel, cursors);
  }
  if (car.contact == Contact::kFourPoint) {
    const double half_length_m = car.patch[2 * a], half_width_m = car.patch[2 * a + 1];
    const double length = std::hypot(heading_x, heading_y);
    const double fx = heading_x / length, fy = heading_y / length;
    std::array<double, 4> z;
    for (std::size_t k = 0; k < 4; ++k) {
      const double along = k < 2 ? half_length_m : -half_length_m;
      const double across = k % 2 == 0 ? half_width_m : -half_width_m;
      z[k] = road.at(x + along * fx - across * fy, y + along * fy + across * fx, z_near_m, wheel,
                     cursors)
                 .z_m;
    }
    const double slope_along = (z[0] + z[1] - z[2] - z[3]) / (4.0 * half_length_m);
    const double slope_across = (z[0] - z[1] + z[2] - z[3]) / (4.0 * half_width_m);
    point.z_m = (z[0] + z[1] + z[2] + z[3]) / 4.0;
    point.dzdx = slope_along * fx - slope_across * fy;
    point.dzdy = slope_along * fy + slope_across * fx;
  }
  return {point.z_m + point.dzdx * (x_m - x) + point.dzdy * (y_m - y), point.dzdx, point.dzdy};
}

/// The time derivative of `s` under `in`. Pure: the same arguments give the same answer; cursors
/// are scratch. `Built` leaves terms out of the compiled equations; the result is bit for bit that
/// of amplitude 0. Units as in State, per second. Numbers that are not finite in the state or the
/// road travel to the result: step() names them.
template <class T, TermSet Built = kAllTerms>
void derivative(const Car<T>& car, const State<T>& s, const Inputs<T>& in, const Road& road,
                RoadCursors& cursors, State<T>& out, Detail<T>& detail) {
  using namespace dynamics_detail;
  using P = Parameter;
  using std::abs;
  using std::asin;
  using std::atan2;
  using std::cos;
  using std::exp;
  using std::pow;
  using std::sin;
  using std::sqrt;
  using std::tanh;
  const Parameters<T>& p = car.parameters;
  const CarFiles& files = *car.files;
  const auto active = [&](Term t) {
    return (Built >> static_cast<std::size_t>(t) & 1) != 0 && !is_exactly_zero(car.terms[t]);
  };
  const auto amplitude = [&](Term t) -> const T& { return car.terms[t]; };
  detail = Detail<T>{};
  detail.inputs = in;

  // 1. Kinematics of the body.
  const Rotation<T> R = rotation(s[kRoll], s[kPitch], s[kYaw]);  // R_map_body
  const Vec3<T> V{s[kVx], s[kVy], s[kVz]};
  const Vec3<T> omega{s[kRollRate], s[kPitchRate], s[kYawRate]};
  const Vec3<T> position{s[kX], s[kY], s[kZ]};
  const Vec3<T> gravity = R.undo({T(0), T(0), -p[P::environment_gravity_mps2]});
  const Vec3<T> velocity = R.apply(V);
  out[kX] = velocity.x;
  out[kY] = velocity.y;
  out[kZ] = velocity.z;
  const T cr = cos(s[kRoll]), sr = sin(s[kRoll]);
  const T yaw_part = (omega.y * sr + omega.z * cr) / cos(s[kPitch]);
  out[kRoll] = omega.x + yaw_part * sin(s[kPitch]);
  out[kPitch] = omega.y * cr - omega.z * sr;
  out[kYaw] = yaw_part;

  // Accumulators: what every term adds to.
  Vec3<T> force, moment;                  // on the whole system, about the origin
  std::array<T, kWheels> travel_force{};  // along each wheel's travel
  std::array<T, kWheels> spin_torque{};   // on each wheel about its axis
  T engine_torque = T(0);
  Powers<T>& power = detail.power;

  std::array<Vec3<T>, kWheels> bend;                       // d slide / d travel
  std::array<Vec3<T>, kWheels> centre, slide, axis, turn;  // wheel centre, d centre / d travel, ...
  std::array<T, kWheels> slide2, spin;                     // spin relative to the body

  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = axle_of(i);
    const double side = is_left(i) ? 1.0 : -1.0;
    WheelDetail<T>& w = detail.wheel[i];
    const T& travel = s[kTravel + i];
    const T& travel_rate = s[kTravelRate + i];

    // 2. Suspension kinematics: path of the wheel centre, camber and toe against travel.
    T camber = p.axle(a, P::front_camber_rad);
    T toe = p.axle(a, P::front_toe_rad);
    slide[i] = {T(0), T(0), T(1)};
    turn[i] = {};
    bend[i] = {};
    if (active(Term::suspension_kinematics) && files.wheel_path[a].given()) {
      const T& k = amplitude(Term::suspension_kinematics);
      const WheelPath& path = files.wheel_path[a];
      const auto at = [&](const WheelPath::Coefficients& c) {
        return along_travel(c, path.range_m, travel);
      };
      const AlongTravel<T> ahead = at(path.ahead_m), outward = at(path.outward_m);
      const AlongTravel<T> leans = at(path.camber_rad), turns = at(path.toe_rad);
      camber += k * leans.value;
      toe += k * turns.value;
      slide[i].x = k * ahead.slope;
      slide[i].y = side * k * outward.slope;
      turn[i].x = -side * k * leans.slope;
      turn[i].z = -side * k * turns.slope;
      bend[i] = {k * ahead.curvature, side * k * outward.curvature, T(0)};
      centre[i] = car.wheel_m[i] + Vec3<T>{k * ahead.value, side * k * outward.value, travel};
    } else if (active(Term::suspension_kinematics)) {
      const T& k = amplitude(Term::suspension_kinematics);
      const T camber_gain = k * p.axle(a, P::front_camber_gain_radpm);
      const T toe_gain = k * p.axle(a, P::front_toe_gain_radpm);
      camber += camber_gain * travel;
      toe += toe_gain * travel;
      slide[i].x = (a == 0 ? 1.0 : -1.0) * k * p.axle(a, P::front_anti_slope);
      slide[i].y = side * 2.0 * k * p.axle(a, P::front_roll_centre_m) / p.axle(a, P::front_track_m);
      turn[i].x = -side * camber_gain;
      turn[i].z = -side * toe_gain;
    }
    slide2[i] = dot(slide[i], slide[i]);
    if (!files.wheel_path[a].given() || !active(Term::suspension_kinematics))
      centre[i] = car.wheel_m[i] + travel * slide[i];
    const T lean = -side * camber;  // rotation about x; the top of the wheel leans right
    T steer = -side * toe;
    if (a == 0)
      steer += in.steer_rad + side * p[P::steering_ackermann] * in.steer_rad * in.steer_rad *
                                  p.axle(0, P::front_track_m) / (2.0 * p[P::chassis_wheelbase_m]);
    const T cs = cos(steer), ss = sin(steer), cl = cos(lean), sl = sin(lean);
    axis[i] = {-ss * cl, cs * cl, sl};
    const Vec3<T> up{ss * sl, -cs * sl, cl};
    spin[i] = s[kSpin + i] - dot(omega, axis[i]);
    w.spin_radps = spin[i];

    // 3. Contact: the plane that touches the road below the wheel.
    const TyreCoefficients& tyre = files.tyre[a];
    const double r0 = tyre.unloaded_radius_m;
    const Vec3<T> below = position + R.apply(centre[i] - T(r0) * up);
    const Vec3<T> forward_map = R.apply({cs, ss, T(0)});
    const Ground<T> ground =
        ground_under(road, car, i, below.x, below.y, value_of(below.z), value_of(forward_map.x),
                     value_of(forward_map.y), cursors, w.road);
    const double tilt =
        1.0 / std::sqrt(1.0 + ground.dzdx * ground.dzdx + ground.dzdy * ground.dzdy);
    const Vec3<T> n = R.undo({T(-ground.dzdx * tilt), T(-ground.dzdy * tilt), T(tilt)});
    w.normal = n;
    w.heading = unit(cross(axis[i], n));
    w.left = cross(n, w.heading);
    const Vec3<T> radial = cross(w.heading, axis[i]);  // from the contact to the centre
    const T sin_camber = dot(axis[i], n);
    w.camber_rad = asin(sin_camber);
    const Vec3<T> to_centre = position + R.apply(centre[i]) - Vec3<T>{below.x, below.y, ground.z_m};
    const T radius = dot(R.undo(to_centre), n) / dot(radial, n);
    const T speed_ratio = spin[i] * r0 / tyre.nominal_speed_mps;
    const T free_radius = r0 * (tyre.qre0 + tyre.qv1 * speed_ratio * speed_ratio);
    w.deflection_m = free_radius - radius;
    w.contact_m = centre[i] - radius * radial;
    const Vec3<T> arm = w.contact_m - centre[i];
    const Vec3<T> swing = slide[i] + cross(turn[i], arm);  // d contact / d travel
    const Vec3<T> v = V + cross(omega, w.contact_m) + travel_rate * swing;
    w.ride_m = dot(car.wheel_m[i] - w.contact_m, n) - car.static_radius_m[a] +
               p.axle(a, P::front_ride_height_m);

    if (w.deflection_m > T(0)) {
      const T& pressure = p.axle(a, P::front_tyre_pressure_pa);
      w.fz_n = tyre_load(tyre, w.deflection_m, spin[i], pressure) -
               tyre.vertical_damping_nspm * dot(v, n);
      if (w.fz_n < T(0)) w.fz_n = T(0);
    }

    // 4. Slip and tyre forces.
    w.rolling_radius_m = rolling_radius(tyre, w.fz_n, free_radius, w.deflection_m);
    w.vx_mps = dot(v, w.heading);
    const T vy = dot(v, w.left);
    w.slip_x_mps = w.vx_mps - spin[i] * w.rolling_radius_m;
    w.slip_y_mps = vy;
    const T low = p[P::tyre_low_speed_mps];
    const T forward = abs(w.vx_mps);

    TyreFactors<T> factors;
    factors.grip_x = p.axle(a, P::front_tyre_grip);
    factors.grip_y = p.axle(a, P::front_tyre_grip);
    factors.stiffness_x = p.axle(a, P::front_tyre_slip_stiffness);
    factors.stiffness_y = p.axle(a, P::front_tyre_cornering_stiffness);
    factors.combined_slip =
        active(Term::tyre_combined_slip) ? amplitude(Term::tyre_combined_slip) : T(0);
    factors.load_sensitivity =
        active(Term::tyre_load_sensitivity) ? amplitude(Term::tyre_load_sensitivity) : T(0);
    factors.camber = active(Term::tyre_camber) ? amplitude(Term::tyre_camber) : T(0);
    if (active(Term::road_friction)) {
      const T road_grip = 1.0 + amplitude(Term::road_friction) *
                                    (p[P::environment_road_grip] * w.road.friction - 1.0);
      factors.grip_x *= road_grip;
      factors.grip_y *= road_grip;
    }
    if (active(Term::tyre_thermal)) {
      const T& k = amplitude(Term::tyre_thermal);
      const T& temperature = s[kTyre + i];
      const T cold = (p[P::tyre_window_begin_k] - temperature) / p[P::tyre_cold_width_k];
      const T hot = (temperature - p[P::tyre_window_end_k]) / p[P::tyre_hot_width_k];
      T grip = T(1);
      if (cold > T(0)) grip -= p[P::tyre_cold_loss] * cold * cold / (1.0 + cold * cold);
      if (hot > T(0)) grip -= p[P::tyre_hot_loss] * hot * hot / (1.0 + hot * hot);
      const T soft =
          exp(-p[P::tyre_stiffness_slope_1pk] * (temperature - p[P::tyre_window_begin_k]));
      const T grip_factor = 1.0 + k * (grip - 1.0);
      const T soft_factor = 1.0 + k * (soft - 1.0);
      factors.grip_x *= grip_factor;
      factors.grip_y *= grip_factor;
      factors.stiffness_x *= soft_factor;
      factors.stiffness_y *= soft_factor;
    }

    if (active(Term::tyre_warm_up)) {
      const T missing = amplitude(Term::tyre_warm_up) * p[P::tyre_warm_up_loss] *
                        (1.0 - clip(s[kTyreWarmth], 0.0, 1.0));
      factors.grip_x *= 1.0 - missing;
      factors.grip_y *= 1.0 - missing;
      factors.stiffness_y *= 1.0 - 0.5 * missing;
    }

    // The patch is carried through at the speed of travel, but its deflection never exceeds what a
    // slip of kLargestSlip gives: below a certain speed it is the sliding that renews it.
    constexpr double kLargestSlip = 1.5;
    constexpr double kSlowSliding_mps = 3.0, kUnwinding_s = 0.005;
    const T transport_x = std::max(forward, T(abs(w.slip_x_mps) / kLargestSlip));
    const T transport_y = std::max(forward, T(abs(w.slip_y_mps) / kLargestSlip));
    w.kappa = -w.slip_x_mps / std::max(transport_x, low);
    w.tan_alpha = w.slip_y_mps / std::max(transport_y, low);
    out[kSlipX + i] = T(0);
    out[kSlipY + i] = T(0);
    const bool relaxes = active(Term::tyre_relaxation);
    if (relaxes) {
      const T& k = amplitude(Term::tyre_relaxation);
      const Stiffness<T> origin =
          tyre_stiffness(tyre, w.fz_n, p.axle(a, P::front_tyre_pressure_pa), factors);
      const Relaxation<T> sigma = relaxation_lengths(
          tyre, w.fz_n, origin.slip_n, origin.cornering_npr, T(w.camber_rad * factors.camber),
          p.axle(a, P::front_tyre_pressure_pa));
      w.decay_x_1ps = transport_x / sigma.longitudinal_m;
      w.decay_y_1ps = transport_y / sigma.lateral_m;
      // Carcass: spring and damper side by side, in series with the patch, which slides by what the
      // rim moves and the carcass does not take up: rate = sliding - transport (u + tau rate) /
      // sigma. Steady slip is as without; the stiff modes of a slow wheel and the fast decay of a
      // fast one are damped.
      const bool damped = active(Term::tyre_carcass_damping);
      const T tau =
          damped ? T(amplitude(Term::tyre_carcass_damping) * p[P::tyre_carcass_damping_s]) : T(0);
      if (damped) {
        w.yield_x = 1.0 / (1.0 + tau * w.decay_x_1ps);
        w.yield_y = 1.0 / (1.0 + tau * w.decay_y_1ps);
        w.decay_x_1ps *= w.yield_x;
        w.decay_y_1ps *= w.yield_y;
      }
      out[kSlipX + i] = -w.yield_x * w.slip_x_mps - w.decay_x_1ps * s[kSlipX + i];
      out[kSlipY + i] = w.yield_y * w.slip_y_mps - w.decay_y_1ps * s[kSlipY + i];
      T along = s[kSlipX + i], across = s[kSlipY + i];
      if (damped) {
        along += tau * out[kSlipX + i];
        across += tau * out[kSlipY + i];
      }
      // A carcass holds no more than friction over its stiffness; what fast sliding adds to the
      // deflection is no spring and must not push on once the sliding ends. So the most that a
      // slowly sliding patch keeps shrinks to the carcass's own with the speed.
      const T pace_x = std::max(forward, T(abs(w.slip_x_mps)));
      const T pace_y = std::max(forward, T(abs(w.slip_y_mps)));
      if (w.fz_n > T(0) && (pace_x < T(kSlowSliding_mps) || pace_y < T(kSlowSliding_mps))) {
        const Friction<T> peak =
            peak_friction(tyre, w.fz_n, p.axle(a, P::front_tyre_pressure_pa), factors);
        const auto excess_1ps = [&](const T& pace, const T& friction, const T& stiffness_n,
                                    const T& sigma_m, const T& deflection_m) {
          const T held = std::min(T(kLargestSlip), T(abs(friction * w.fz_n / stiffness_n)));
          const T most =
              (held + (kLargestSlip - held) * smooth_step(T(pace / kSlowSliding_mps))) * sigma_m;
          const T size = abs(deflection_m);
          return size > most ? T((1.0 - most / size) / kUnwinding_s) : T(0);
        };
        const T excess_x =
            excess_1ps(pace_x, peak.x, origin.slip_n, sigma.longitudinal_m, s[kSlipX + i]);
        const T excess_y =
            excess_1ps(pace_y, peak.y, origin.cornering_npr, sigma.lateral_m, s[kSlipY + i]);
        out[kSlipX + i] -= excess_x * s[kSlipX + i];
        out[kSlipY + i] -= excess_y * s[kSlipY + i];
        w.decay_x_1ps += excess_x;
        w.decay_y_1ps += excess_y;
      }
      const T kappa = along / sigma.longitudinal_m, tan_alpha = across / sigma.lateral_m;
      w.kappa += k * (kappa - w.kappa);
      w.tan_alpha += k * (tan_alpha - w.tan_alpha);
    }
    w.kappa = clip(w.kappa, -kLargestSlip, kLargestSlip);
    w.tan_alpha = clip(w.tan_alpha, -kLargestSlip, kLargestSlip);

    TyreInput<T> slip;
    slip.fz_n = w.fz_n;
    slip.kappa = w.kappa;
    slip.tan_alpha = w.tan_alpha;
    slip.gamma_rad = w.camber_rad;
    slip.vx_mps = w.vx_mps;
    slip.pressure_pa = p.axle(a, P::front_tyre_pressure_pa);
    TyreOptions options = car.tyre_options;
    options.mirrored = is_left(i) != tyre.left_side;
    options.moments = active(Term::tyre_moments) || active(Term::rolling_resistance);
    TyreForces<T> f;
    if (has_turn_slip(tyre) && active(Term::tyre_turn_slip)) {
      const T turning = dot(omega, n) + (a == 0 ? in.steer_rate_radps : T(0));
      slip.turn_1pm = turning / std::max(forward, p[P::tyre_turn_speed_mps]);
      f = tyre_forces(tyre, slip, factors, options);
      const T& k = amplitude(Term::tyre_turn_slip);
      if (!is_exactly_zero(T(1.0 - k))) {
        slip.turn_1pm = T(0);
        const TyreForces<T> rolling = tyre_forces(tyre, slip, factors, options);
        f.fx_n = rolling.fx_n + k * (f.fx_n - rolling.fx_n);
        f.fy_n = rolling.fy_n + k * (f.fy_n - rolling.fy_n);
        f.mx_nm = rolling.mx_nm + k * (f.mx_nm - rolling.mx_nm);
        f.my_nm = rolling.my_nm + k * (f.my_nm - rolling.my_nm);
        f.mz_nm = rolling.mz_nm + k * (f.mz_nm - rolling.mz_nm);
      }
    } else {
      f = tyre_forces(tyre, slip, factors, options);
    }
    w.fx_n = f.fx_n;
    w.fy_n = f.fy_n;

    Vec3<T> couple;  // on the wheel, at the contact point
    if (active(Term::tyre_moments)) {
      couple += (amplitude(Term::tyre_moments) * f.mx_nm) * w.heading;
      couple += (amplitude(Term::tyre_moments) * f.mz_nm) * n;
    }
    if (active(Term::rolling_resistance))
      couple += (amplitude(Term::rolling_resistance) * f.my_nm) * w.left;

    if (files.fx_arm == FxArm::kRollingRadius)
      couple -= (w.fx_n * (w.rolling_radius_m - radius)) * axis[i];

    const Vec3<T> tangential = w.fx_n * w.heading + w.fy_n * w.left;
    const Vec3<T> contact_force = w.fz_n * n + tangential;
    force += contact_force;
    moment += cross(w.contact_m, contact_force) + couple;
    travel_force[i] += dot(contact_force, swing) + dot(couple, turn[i]);
    const T wheel_moment = dot(cross(arm, contact_force) + couple, axis[i]);
    spin_torque[i] += wheel_moment;
    w.axis = axis[i];
    w.arm = arm;
    w.swing = swing;
    w.centre = centre[i];
    w.slide = slide[i];
    w.couple = couple;
    w.couple_on_travel = dot(couple, turn[i]);
    const Vec3<T> tread = v + spin[i] * cross(axis[i], arm);
    power.tyre_normal += w.fz_n * dot(n, tread);
    power.tyre_x += w.fx_n * dot(w.heading, tread);
    power.tyre_y += w.fy_n * dot(w.left, tread);
    power.tyre_moment +=
        dot(couple, omega) + dot(couple, turn[i]) * travel_rate + dot(couple, axis[i]) * spin[i];

    // Tread temperature.
    out[kTyre + i] = T(0);
    if (active(Term::tyre_thermal)) {
      T heat = -(w.fx_n * w.slip_x_mps + w.fy_n * w.slip_y_mps);
      heat = heat > T(0) ? T(p[P::tyre_slip_share] * heat) : T(0);
      T cooling = (p[P::tyre_cooling_still_wpk] + p[P::tyre_cooling_speed_jpkm] * norm(V)) *
                  (s[kTyre + i] - p[P::environment_temperature_k]);
      if (w.fz_n > T(0))
        cooling +=
            p[P::tyre_road_cooling_wpk] * (s[kTyre + i] - p[P::environment_track_temperature_k]);
      out[kTyre + i] = (heat - cooling) / p.axle(a, P::front_tyre_heat_capacity_jpk);
    }
  }

  // 5. Springs, dampers, bars, stops: forces along the travel.
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = axle_of(i);
    const T& travel = s[kTravel + i];
    const T& rate = s[kTravelRate + i];
    // The preload carries the sprung weight at design travel.
    T spring = -(car.static_load_n[a] -
                 p.axle(a, P::front_unsprung_mass_kg) * p[P::environment_gravity_mps2]) -
               p.axle(a, P::front_spring_npm) * travel;
    if (active(Term::anti_roll_bar))
      spring -= amplitude(Term::anti_roll_bar) * p.axle(a, P::front_anti_roll_npm) *
                (travel - s[kTravel + (i ^ 1u)]);
    if (active(Term::bump_stop)) {
      const T into = travel - p.axle(a, P::front_bump_clearance_m);
      const T out_of = -travel - p.axle(a, P::front_droop_clearance_m);
      const T k = amplitude(Term::bump_stop) * p.axle(a, P::front_bump_stop_npm2);
      if (into > T(0)) spring -= k * into * into;
      if (out_of > T(0)) spring += k * out_of * out_of;
    }
    T damper;
    if (files.damper_n[a].empty()) {
      // Digressive: full damping of slow travel, a share of it beyond the knee.
      const T& knee = p.axle(a, P::front_damper_knee_mps);
      const T& share = p.axle(a, P::front_damper_fast_share);
      damper = (rate > T(0) ? p.axle(a, P::front_bump_damping_nspm)
                            : p.axle(a, P::front_rebound_damping_nspm)) *
               (share * rate + (1.0 - share) * knee * tanh(rate / knee));
    } else {
      damper = evaluate(files.damper_n[a], rate);
    }
    detail.wheel[i].damper_n = damper;
    power.damper -= damper * rate;
    travel_force[i] +=
        spring - damper + p.axle(a, P::front_unsprung_mass_kg) * dot(gravity, slide[i]);
  }

  // 6. Aerodynamics.
  Vec3<T> air = V;
  if (active(Term::wind)) {
    const T w = amplitude(Term::wind) * p[P::environment_wind_mps];
    air -= R.undo({w * cos(p[P::environment_wind_heading_rad]),
                   w * sin(p[P::environment_wind_heading_rad]), T(0)});
  }
  const T air_speed2 = air.x * air.x + air.y * air.y;
  if (air_speed2 > T(1e-12)) {
    const T air_speed = sqrt(air_speed2);
    const T half_density = 0.5 * p[P::aero_density_kgpm3];
    T drag = half_density * p[P::aero_drag_area_m2] * air_speed;  // over the air speed
    T front = half_density * p[P::front_lift_area_m2] * air_speed2;
    T rear = half_density * p[P::rear_lift_area_m2] * air_speed2;
    if (active(Term::aero_ride_height)) {
      const T& k = amplitude(Term::aero_ride_height);
      const T ride_front = 0.5 * (detail.wheel[0].ride_m + detail.wheel[1].ride_m);
      const T ride_rear = 0.5 * (detail.wheel[2].ride_m + detail.wheel[3].ride_m);
      const auto factor = [&](const Map2& map) {
        return map.empty() ? T(1) : T(1.0 + k * (evaluate(map, ride_front, ride_rear) - 1.0));
      };
      drag *= factor(files.drag_factor);
      front *= factor(files.front_lift_factor);
      rear *= factor(files.rear_lift_factor);
    }
    if (active(Term::aero_yaw)) {
      const T& k = amplitude(Term::aero_yaw);
      const T yaw = abs(atan2(air.y, air.x));
      const auto factor = [&](const Map1& map) {
        return map.empty() ? T(1) : T(1.0 + k * (evaluate(map, yaw) - 1.0));
      };
      drag *= factor(files.yaw_drag_factor);
      const T lift = factor(files.yaw_lift_factor);
      front *= lift;
      rear *= lift;
    }
    if (active(Term::aero_slipstream) && in.opponent) {
      const T& k = amplitude(Term::aero_slipstream);
      const auto factor = [&](const Map2& map) {
        return map.empty() ? T(1) : T(1.0 + k * (evaluate(map, in.wake_x_m, in.wake_y_m) - 1.0));
      };
      drag *= factor(files.wake_drag_factor);
      const T lift = factor(files.wake_lift_factor);
      front *= lift;
      rear *= lift;
    }
    const auto push = [&](const Vec3<T>& f, const Vec3<T>& at, T& account) {
      force += f;
      const Vec3<T> m = cross(at, f);
      moment += m;
      account += dot(f, V) + dot(m, omega);
    };
    if (active(Term::aero_drag)) {
      const T& k = amplitude(Term::aero_drag);
      const T height = p[P::aero_drag_height_m] - p[P::chassis_cog_height_m];
      detail.drag_n = k * drag * air_speed;
      detail.drag_x_n = -k * drag * air.x;
      detail.drag_y_n = -k * drag * air.y;
      push({detail.drag_x_n, detail.drag_y_n, T(0)}, {T(0), T(0), height}, power.drag);
      detail.side_n = -k * half_density * p[P::aero_side_area_m2] * air_speed * air.y;
      push({T(0), detail.side_n, T(0)}, {-p[P::aero_side_behind_cog_m], T(0), height}, power.side);
    }
    if (active(Term::aero_downforce)) {
      const T& k = amplitude(Term::aero_downforce);
      detail.front_downforce_n = k * front;
      detail.rear_downforce_n = k * rear;
      push({T(0), T(0), -k * front}, {car.wheel_m[0].x, T(0), T(0)}, power.downforce);
      push({T(0), T(0), -k * rear}, {car.wheel_m[2].x, T(0), T(0)}, power.downforce);
    }
  }

  if (!is_exactly_zero(in.hold_n)) {
    force.x += in.hold_n;
    power.hold = in.hold_n * V.x;
  }

  // 7. Engine, turbo, clutch, differential.
  const T& engine_speed = s[kEngine];
  const T throttle = clip(in.throttle, 0.0, 1.0);
  const T above = (engine_speed - p[P::engine_limit_radps]) / (0.02 * p[P::engine_limit_radps]);
  const T fuelled = 1.0 - clip(above, 0.0, 1.0);
  const bool full_turbo = files.turbo == Turbo::kFull;
  T map_torque = T(0);
  detail.boost = s[kBoost];
  out[kBoost] = out[kManifold] = out[kCharge] = out[kExhaust] = out[kTurbo] = T(0);
  if (full_turbo) {
    const auto amount = [&](Term t) { return active(t) ? amplitude(t) : T(0); };
    const laws::TurboParameters<T> of_path = turbo_parameters(p);
    detail.turbo = laws::turbocharged<T>(of_path,
                                         {amount(Term::compressor_map), amount(Term::wastegate),
                                          amount(Term::overrun_valve), amount(Term::intercooler)},
                                         {s[kManifold], s[kCharge], s[kExhaust], s[kTurbo]},
                                         engine_speed, throttle, fuelled, files.compressor_kgps,
                                         files.compressor_efficiency);
    map_torque = p[P::engine_torque] * detail.turbo.engine_nm;
    detail.boost = (s[kCharge] - of_path.air_pa) / of_path.wastegate_pa;
    out[kManifold] = detail.turbo.manifold_paps;
    out[kCharge] = detail.turbo.charge_paps;
    out[kExhaust] = detail.turbo.exhaust_paps;
    out[kTurbo] = detail.turbo.shaft_radps2;
    power.turbo = detail.turbo.shaft_nm * s[kTurbo];
  } else {
    map_torque = p[P::engine_torque] * evaluate(files.engine_torque_nm, engine_speed, throttle);
    if (map_torque > T(0)) map_torque *= fuelled;
  }
  if (!full_turbo && active(Term::turbo_lag)) {
    // Boost chases the throttle as fast as the exhaust drives the turbine; torque misses what boost
    // misses.
    const T lacking = throttle - s[kBoost];
    const T flow = clip(T(engine_speed / p[P::turbo_reference_radps]), 0.02, 10.0) *
                   (p[P::turbo_idle_flow] + (1.0 - p[P::turbo_idle_flow]) * throttle);
    out[kBoost] =
        lacking > T(0) ? T(lacking * flow / p[P::turbo_rise_s]) : T(lacking / p[P::turbo_fall_s]);
    if (lacking > T(0) && map_torque > T(0))
      map_torque *= 1.0 - amplitude(Term::turbo_lag) * p[P::turbo_share] * lacking;
  }
  T idle = p[P::engine_idle_gain_nms] * (p[P::engine_idle_radps] - engine_speed);
  if (idle < T(0)) idle = T(0);
  detail.engine_nm = map_torque + idle;
  if (in.next_gear != 0 && !is_exactly_zero(p[P::gearbox_rev_match]) &&
      p[P::gearbox_shift_s] > T(0)) {
    // Engine control between two gears: of the speed difference this share is gone after the shift.
    using std::log;
    const T ratio = overall_ratio(p, in.next_gear);
    const T& share = p[P::gearbox_rev_match];
    const T rate_1ps = -log(T(1.0 - 0.99 * share)) / p[P::gearbox_shift_s];
    if (ratio != T(0))
      detail.engine_nm =
          (1.0 - share) * detail.engine_nm +
          p[P::engine_inertia_kgm2] * rate_1ps * (ratio * 0.5 * (spin[2] + spin[3]) - engine_speed);
  }
  engine_torque += detail.engine_nm;
  power.engine += detail.engine_nm * engine_speed;

  T driven = T(0);  // torque into the differential
  if (in.gear != 0) {
    const T ratio = overall_ratio(p, in.gear);
    if (ratio != T(0)) {
      T capacity = p[P::clutch_torque_nm];
      if (active(Term::centrifugal_clutch)) {
        const T engaged = smooth_step(T((engine_speed - p[P::clutch_begin_radps]) /
                                        (p[P::clutch_full_radps] - p[P::clutch_begin_radps])));
        capacity *= 1.0 + amplitude(Term::centrifugal_clutch) * (engaged - 1.0);
      }
      const T slip = engine_speed - ratio * 0.5 * (spin[2] + spin[3]);
      const T grip = tanh(slip / p[P::clutch_stick_radps]);
      detail.clutch_slip_radps = slip;
      detail.clutch_nm = capacity * grip;
      detail.clutch_stiffness_nms = capacity * (1.0 - grip * grip) / p[P::clutch_stick_radps];
      detail.gear_ratio = ratio;
      detail.drive_efficiency =
          detail.clutch_nm > T(0) ? p[P::gearbox_efficiency] : T(1.0 / p[P::gearbox_efficiency]);
      driven = detail.clutch_nm * ratio * detail.drive_efficiency;
      engine_torque -= detail.clutch_nm;
      power.clutch = -detail.clutch_nm * slip;
      power.driveline -= detail.clutch_nm * engine_speed - driven * 0.5 * (spin[2] + spin[3]);
    }
  }
  const T difference = spin[2] - spin[3];
  detail.differential_slip_radps = difference;
  if (active(Term::limited_slip)) {
    const T friction = limited_slip_torque(car, driven);
    const T grip = tanh(difference / p[P::differential_stick_radps]);
    detail.limited_slip_nm = friction;
    detail.limited_slip_grip = grip;
    detail.differential_nm += friction * grip;
    detail.differential_stiffness_nms +=
        friction * (1.0 - grip * grip) / p[P::differential_stick_radps];
  }
  if (active(Term::locked_differential)) {
    const T lock = amplitude(Term::locked_differential) * p[P::differential_lock_nms];
    detail.differential_nm += lock * difference;
    detail.differential_stiffness_nms += lock;
  }
  power.driveline -= detail.differential_nm * difference;
  detail.wheel[2].drive_nm = 0.5 * driven - detail.differential_nm;
  detail.wheel[3].drive_nm = 0.5 * driven + detail.differential_nm;

  // 8. Brakes: pads, and the two-node discs.
  const T air_k = p[P::environment_temperature_k];
  const T speed = norm(V);
  T car_cooling = T(0);
  const bool cooled = active(Term::brake_convection);
  using laws::kAirConductivity, laws::kAirViscosity;
  const bool vanes = cooled && active(Term::brake_vanes);
  const bool simple = cooled && (!vanes || !is_exactly_zero(T(1.0 - amplitude(Term::brake_vanes))));
  T bite = T(1);  // what fade leaves of the friction
  if (active(Term::brake_fade))
    bite -= amplitude(Term::brake_fade) *
            clip(T(1e-6 * p[P::brake_fade_1pmj] * s[kPadHeat]), -1.0, 0.95);
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = axle_of(i);
    WheelDetail<T>& w = detail.wheel[i];
    const T& surface = s[kDiscSurface + i];
    const T& core = s[kDiscCore + i];
    const T pressure = in.brake_pa[i] > T(0) ? in.brake_pa[i] : T(0);
    T friction = p.axle(a, P::front_brake_friction);
    if (active(Term::brake_friction_temperature) && !files.pad_friction.empty())
      friction += amplitude(Term::brake_friction_temperature) *
                  (evaluate(files.pad_friction, pressure, surface) - friction);
    friction *= bite;
    const T capacity = 2.0 * friction * pressure * p.axle(a, P::front_brake_area_m2) *
                       p.axle(a, P::front_brake_radius_m);
    const T grip = tanh(spin[i] / p[P::brake_stop_radps]);
    w.brake_nm = -capacity * grip;
    w.brake_capacity_nm = capacity;
    const T torque = w.brake_nm + w.drive_nm;
    spin_torque[i] += torque;
    power.brake += w.brake_nm * spin[i];

    T into_surface = T(0), into_core = T(0);
    if (active(Term::brake_heating))
      into_surface -=
          amplitude(Term::brake_heating) * p[P::brake_disc_share] * w.brake_nm * spin[i];
    if (active(Term::brake_conduction)) {
      T flow = amplitude(Term::brake_conduction) * p.axle(a, P::front_disc_conductance_wpk) *
               (surface - core);
      flow *= clip(T(1.0 + p[P::brake_conductance_slope_1pk] * (0.5 * (surface + core) - 500.0)),
                   0.05, 100.0);
      into_surface -= flow;
      into_core += flow;
    }
    if (vanes) {
      const T& d = p.axle(a, P::front_disc_diameter_m);
      const T& inner = p.axle(a, P::front_disc_inner_m);
      const T& gap = p.axle(a, P::front_vane_diameter_m);
      const T turning = abs(spin[i]);
      const T k = amplitude(Term::brake_convection) * amplitude(Term::brake_vanes);
      into_surface -= k *
                      laws::disc_face_nusselt(d, turning, T(p[P::brake_air_share] * speed),
                                              p[P::brake_nusselt_still]) *
                      kAirConductivity / d * p.axle(a, P::front_disc_area_m2) * (surface - air_k);
      into_core -=
          k * laws::vane_nusselt(gap, T(0.5 * (d - inner)), laws::vane_air_mps(d, inner, turning)) *
          kAirConductivity / gap * p.axle(a, P::front_vane_area_m2) * (core - air_k);
    }
    if (simple) {
      const T& d = p.axle(a, P::front_disc_diameter_m);
      if (i == 0 || i == 2)  // both wheels of an axle see the same car speed
        car_cooling = p[P::brake_nusselt_car] * pow(T(speed * d / kAirViscosity + 1e-9), 0.8);
      const T disc_speed = abs(spin[i]) * d * 0.5;
      const T nusselt =
          p[P::brake_nusselt_still] + car_cooling +
          p[P::brake_nusselt_disc] * pow(T(disc_speed * d / kAirViscosity + 1e-9), 0.8);
      const T out_w = amplitude(Term::brake_convection) * nusselt * kAirConductivity / d *
                      p.axle(a, P::front_disc_area_m2) * (surface - air_k);
      into_surface -= vanes ? T((1.0 - amplitude(Term::brake_vanes)) * out_w) : out_w;
    }
    if (active(Term::brake_radiation)) {
      constexpr double kStefanBoltzmann = 5.670374419e-8;
      const T s2 = surface * surface, a2 = air_k * air_k;
      into_surface -= amplitude(Term::brake_radiation) * kStefanBoltzmann * p[P::brake_emissivity] *
                      p.axle(a, P::front_disc_area_m2) * (s2 * s2 - a2 * a2);
    }
    T capacity_surface = p.axle(a, P::front_disc_surface_capacity_jpk);
    T capacity_core = p.axle(a, P::front_disc_core_capacity_jpk);
    if (active(Term::brake_heat_capacity)) {
      const T slope = amplitude(Term::brake_heat_capacity) * p[P::brake_capacity_slope_1pk];
      capacity_surface *= 1.0 + slope * (surface - 300.0);
      capacity_core *= 1.0 + slope * (core - 300.0);
    }
    out[kDiscSurface + i] = into_surface / capacity_surface;
    out[kDiscCore + i] = into_core / capacity_core;
  }

  out[kPadHeat] = T(0);
  if (active(Term::brake_fade)) out[kPadHeat] = -power.brake - s[kPadHeat] / p[P::brake_fade_s];

  // 9. Fuel.
  out[kFuel] = T(0);
  const T& fuel = s[kFuel];
  const Vec3<T> tank_v = V + cross(omega, car.tank_m);
  if (active(Term::fuel_burn) && fuel > T(0)) {
    if (full_turbo) {
      out[kFuel] = -amplitude(Term::fuel_burn) * detail.turbo.fuel_kgps;
    } else {
      const T useful = map_torque > T(0) ? T(map_torque * engine_speed) : T(0);
      out[kFuel] =
          -amplitude(Term::fuel_burn) *
          (p[P::fuel_idle_kgps] + useful / (p[P::fuel_efficiency] * p[P::fuel_energy_jpkg]));
    }
    power.fuel =
        out[kFuel] * (0.5 * dot(tank_v, tank_v) +
                      p[P::environment_gravity_mps2] * (position.z + R.apply(car.tank_m).z));
  }

  // 10. Accelerations. Rotors first: the body feels their reaction.
  for (std::size_t i = 0; i < kWheels; ++i) {
    const T& inertia = p.axle(axle_of(i), P::front_wheel_inertia_kgm2);
    out[kSpin + i] = spin_torque[i] / inertia;
    const T felt = active(Term::wheel_reaction) ? T(amplitude(Term::wheel_reaction)) : T(0);
    moment -= (felt * spin_torque[i]) * axis[i];
    power.unfelt += (1.0 - felt) * spin_torque[i] * dot(axis[i], omega);
    if (active(Term::gyroscopic))
      moment -= amplitude(Term::gyroscopic) * (inertia * s[kSpin + i]) * cross(omega, axis[i]);
  }
  out[kEngine] = engine_torque / p[P::engine_inertia_kgm2];

  std::array<std::array<T, 6>, 6>& inertia = detail.inertia;
  const Vec3<T> none;
  const T ms = car.sprung_mass_kg;
  const Vec3<T> cs = car.sprung_cog_m;
  inertia[0][0] = inertia[1][1] = inertia[2][2] = ms;
  inertia[3][1] = -ms * cs.z;
  inertia[3][2] = ms * cs.y;
  inertia[4][0] = ms * cs.z;
  inertia[4][2] = -ms * cs.x;
  inertia[5][0] = -ms * cs.y;
  inertia[5][1] = ms * cs.x;
  inertia[3][3] = car.sprung_inertia_kgm2.x;
  inertia[4][4] = car.sprung_inertia_kgm2.y;
  inertia[5][5] = car.sprung_inertia_kgm2.z;
  inertia[5][3] = car.sprung_inertia_xz_kgm2;
  if (fuel > T(0)) add_point_mass(inertia, fuel, car.tank_m, none, T(1));

  const T fuel_mass = fuel > T(0) ? fuel : T(0);
  const Vec3<T> first_moment = ms * cs + fuel_mass * car.tank_m;
  // Gravity and centrifugal parts of the rigid part.
  force += (ms + fuel_mass) * gravity - cross(omega, cross(omega, first_moment));
  moment += cross(first_moment, gravity);
  const Vec3<T> spin_momentum{
      car.sprung_inertia_kgm2.x * omega.x + car.sprung_inertia_xz_kgm2 * omega.z,
      car.sprung_inertia_kgm2.y * omega.y,
      car.sprung_inertia_xz_kgm2 * omega.x + car.sprung_inertia_kgm2.z * omega.z};
  moment -= cross(omega, spin_momentum);
  moment -= fuel_mass * cross(car.tank_m, cross(omega, cross(omega, car.tank_m)));

  std::array<Vec3<T>, kWheels> bias;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const T& m = p.axle(axle_of(i), P::front_unsprung_mass_kg);
    const T& rate = s[kTravelRate + i];
    bias[i] = cross(omega, cross(omega, centre[i])) + (2.0 * rate) * cross(omega, slide[i]);
    if (files.wheel_path[axle_of(i)].given()) bias[i] += (rate * rate) * bend[i];
    add_point_mass(inertia, m, centre[i], slide[i], slide2[i]);
    const Vec3<T> carried = bias[i] - (dot(bias[i], slide[i]) / slide2[i]) * slide[i];
    const Vec3<T> reaction = (travel_force[i] / slide2[i]) * slide[i] + m * carried;
    force += m * gravity - reaction;
    moment += cross(centre[i], m * gravity - reaction);
  }
  std::array<T, 6> x{force.x, force.y, force.z, moment.x, moment.y, moment.z};
  factor6(inertia);
  solve6(inertia, x);
  const Vec3<T> acceleration{x[0], x[1], x[2]};  // of the origin, body axes
  const Vec3<T> angular{x[3], x[4], x[5]};
  const Vec3<T> rate = acceleration - cross(omega, V);
  out[kVx] = rate.x;
  out[kVy] = rate.y;
  out[kVz] = rate.z;
  out[kRollRate] = angular.x;
  out[kPitchRate] = angular.y;
  out[kYawRate] = angular.z;
  detail.specific_force_mps2 = acceleration - gravity;
  out[kTyreWarmth] = T(0);
  if (active(Term::tyre_warm_up))
    out[kTyreWarmth] = (1.0 - s[kTyreWarmth]) / p[P::tyre_warm_up_s] *
                       clip(T(0.2 + abs(detail.specific_force_mps2.y) / 8.0), 0.0, 3.0);
  for (std::size_t i = 0; i < kWheels; ++i) {
    const T& m = p.axle(axle_of(i), P::front_unsprung_mass_kg);
    const Vec3<T> a = acceleration + cross(angular, centre[i]) + bias[i];
    out[kTravel + i] = s[kTravelRate + i];
    out[kTravelRate + i] = (travel_force[i] / m - dot(a, slide[i])) / slide2[i];
  }
}

/// Kinetic energy of all masses and rotors (the turbocharger's too), their height, and what
/// springs, bars and stops hold, J. What changes it is exactly Powers (times, for one wheel
/// spinning about a turning axis, nothing: gyroscopic moments do no work).
template <class T>
T energy(const Car<T>& car, const State<T>& s) {
  using P = Parameter;
  const Parameters<T>& p = car.parameters;
  const Rotation<T> R = rotation(s[kRoll], s[kPitch], s[kYaw]);
  const Vec3<T> V{s[kVx], s[kVy], s[kVz]};
  const Vec3<T> omega{s[kRollRate], s[kPitchRate], s[kYawRate]};
  const auto height = [&](const Vec3<T>& at) { return s[kZ] + R.apply(at).z; };
  const T g = p[P::environment_gravity_mps2];
  const Vec3<T> v_s = cross(omega, car.sprung_cog_m);
  T total = car.sprung_mass_kg * (0.5 * dot(V, V) + dot(V, v_s) + g * height(car.sprung_cog_m));
  total += 0.5 * (car.sprung_inertia_kgm2.x * omega.x * omega.x +
                  car.sprung_inertia_kgm2.y * omega.y * omega.y +
                  car.sprung_inertia_kgm2.z * omega.z * omega.z) +
           car.sprung_inertia_xz_kgm2 * omega.x * omega.z;
  const Vec3<T> v_f = V + cross(omega, car.tank_m);
  if (s[kFuel] > T(0)) total += s[kFuel] * (0.5 * dot(v_f, v_f) + g * height(car.tank_m));
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = axle_of(i);
    const T& travel = s[kTravel + i];
    const T& k = car.terms[Term::suspension_kinematics];
    const double side = is_left(i) ? 1.0 : -1.0;
    Vec3<T> slide{(a == 0 ? 1.0 : -1.0) * k * p.axle(a, P::front_anti_slope),
                  side * 2.0 * k * p.axle(a, P::front_roll_centre_m) / p.axle(a, P::front_track_m),
                  T(1)};
    Vec3<T> centre = car.wheel_m[i] + travel * slide;
    if (const WheelPath& path = car.files->wheel_path[a]; path.given()) {
      const AlongTravel<T> ahead = along_travel(path.ahead_m, path.range_m, travel);
      const AlongTravel<T> outward = along_travel(path.outward_m, path.range_m, travel);
      slide = {k * ahead.slope, side * k * outward.slope, T(1)};
      centre = car.wheel_m[i] + Vec3<T>{k * ahead.value, side * k * outward.value, travel};
    }
    const Vec3<T> v = V + cross(omega, centre) + s[kTravelRate + i] * slide;
    const T& m = p.axle(a, P::front_unsprung_mass_kg);
    total += m * (0.5 * dot(v, v) + g * height(centre));
    total += 0.5 * p.axle(a, P::front_wheel_inertia_kgm2) * s[kSpin + i] * s[kSpin + i];
    total += (car.static_load_n[a] - m * g) * travel +
             0.5 * p.axle(a, P::front_spring_npm) * travel * travel;
    if (is_left(i)) {
      const T twist = travel - s[kTravel + i + 1];
      total +=
          0.5 * car.terms[Term::anti_roll_bar] * p.axle(a, P::front_anti_roll_npm) * twist * twist;
    }
    const T stop = car.terms[Term::bump_stop] * p.axle(a, P::front_bump_stop_npm2) / 3.0;
    const T into = travel - p.axle(a, P::front_bump_clearance_m);
    const T out_of = -travel - p.axle(a, P::front_droop_clearance_m);
    if (into > T(0)) total += stop * into * into * into;
    if (out_of > T(0)) total += stop * out_of * out_of * out_of;
  }
  if (car.files->turbo == Turbo::kFull)
    total += 0.5 * p[P::turbo_inertia_kgm2] * s[kTurbo] * s[kTurbo];
  return total + 0.5 * p[P::engine_inertia_kgm2] * s[kEngine] * s[kEngine];
}

}  // namespace vehicle
