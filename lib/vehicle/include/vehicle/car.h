// A car ready to be simulated: files, parameters, terms, and what follows from them.
#pragma once

#include <array>
#include <cmath>

#include "vehicle/laws/wheel_path.h"
#include "vehicle/magic_formula.h"
#include "vehicle/map.h"
#include "vehicle/parameters.h"
#include "vehicle/state.h"
#include "vehicle/vec3.h"

namespace vehicle {

/// The arm at which the longitudinal force turns a wheel. By force and place it is the loaded
/// radius; many programs take the rolling radius, so that the force at the tread does exactly the
/// work of the torque on the wheel: what differs they leave out as the work of the carcass's
/// deformation.
enum class FxArm { kLoadedRadius, kRollingRadius, kUnstated /* simulated as the loaded one */ };

/// How the engine's torque follows the throttle: by the engine map and a boost of first order, or
/// by the air path of laws/turbocharger.h, which leaves the engine map to the driver's judgement.
enum class Turbo { kFirstOrder, kFull };

/// What a car has in files: two tyres and its maps. An empty map is replaced as stated.
struct CarFiles {
  std::array<TyreCoefficients, 2> tyre;  ///< front, rear
  AlphaConvention alpha = AlphaConvention::kTangent;
  FxArm fx_arm = FxArm::kLoadedRadius;
  Turbo turbo = Turbo::kFirstOrder;
  Map2 compressor_kgps, compressor_efficiency;  ///< over shaft speed rad/s and pressure ratio;
                                                ///< empty: the closed form
  Map2 turbine_flow, turbine_efficiency;        ///< over shaft speed over the root of the
                                                ///< temperature, rad/(s sqrt K), and expansion
                                                ///< ratio; flow in kg sqrt K/(s MPa)
  Map1 compressor_surge_kgps;                   ///< least flow without surge over pressure ratio
  Map1 steering;  ///< mean road wheel angle over the command, rad; empty: steering.ratio alone
  Map2 engine_torque_nm;         ///< over engine speed rad/s and throttle; required
  std::array<Map1, 2> damper_n;  ///< over speed m/s, bump positive; empty: the damping parameters
  Map2 drag_factor;              ///< over front and rear ride height, m; empty: 1
  Map2 front_lift_factor, rear_lift_factor;  ///< the same
  Map1 yaw_drag_factor, yaw_lift_factor;     ///< over |yaw angle of the air|, rad; empty: 1
  Map2 wake_drag_factor, wake_lift_factor;   ///< over the opponent's x and y, m; empty: 1
  std::array<WheelPath, 2> wheel_path;  ///< from hardpoints; not given: camber_gain and its kin
  Map1 tyre_grip;     ///< factor over tread temperature, K; empty: the window of the parameters
  Map2 pad_friction;  ///< over pressure Pa and surface temperature K; empty: constant
};

/// Which samples of the road make the contact of a wheel.
enum class Contact {
  kSinglePoint,  ///< height and gradient under the wheel centre
  kFourPoint,    ///< mean plane through the corners of the contact patch
  kStrip         ///< a strip of samples, enveloped by two tandem elliptical cams
};

/// The strip under a tyre and the cams that roll over it (A. J. C. Schmeitz, tandem model with
/// elliptical cams, as in H. B. Pacejka, Tire and Vehicle Dynamics, 3rd edition, chapter 10).
struct StripShape {
  static constexpr std::size_t kMostSamples = 2048, kMostAlong = 1024;
  std::size_t along = 27, across = 15;  ///< samples in the direction of travel and across it
  double step_m = 0.02;                 ///< between samples
  double cam_order = 1.8;               ///< exponent of the ellipse
  double cam_shift = 0.8;               ///< distance of the cams over the length of the patch
};

/// What one axle's cams do to the samples of one line: how far each may stand above the cam's
/// lowest point before it lifts it. Beyond the cam: a large number.
struct Cams {
  std::array<float, StripShape::kMostAlong> front{}, rear{};
  /// Rows that are looked at first: beyond them both cams rise with the distance.
  std::size_t near_begin = 0, near_end = 0;
  double distance_m = 0.1;
};

/// Everything the equations need. Plain data; `files` must outlive it. Make with make_car, so that
/// the derived quantities fit the parameters.
template <class T>
struct Car {
  const CarFiles* files = nullptr;
  Parameters<T> parameters;
  Amplitudes<T> terms;
  Contact contact = Contact::kSinglePoint;
  StripShape strip;
  TyreOptions tyre_options;

  // Derived; body frame with origin in the design centre of mass.
  T sprung_mass_kg;
  Vec3<T> sprung_cog_m;
  Vec3<T> sprung_inertia_kgm2;  ///< diagonal, about the origin
  T sprung_inertia_xz_kgm2;     ///< product, about the origin
  Vec3<T> tank_m;
  std::array<Vec3<T>, kWheels> wheel_m;  ///< wheel centres at design travel
  std::array<T, 2> static_load_n;        ///< one wheel of the axle, standing level, without fuel
  std::array<T, 2> static_radius_m;      ///< loaded radius at that load
  std::array<double, 4> patch;           ///< half length, half width of the contact patch by axle
  std::array<Cams, 2> cams;              ///< by axle; filled for strip contact
};

/// Works out the derived quantities. Throws Error naming the parameter when a value lies outside
/// its bounds, an amplitude outside [0, 1], the masses or inertias contradict each other, or a map
/// is missing or bad.
template <class T>
Car<T> make_car(const CarFiles& files, const Parameters<T>& parameters, const Amplitudes<T>& terms,
                Contact contact = Contact::kSinglePoint, const StripShape& strip = {});

/// The cams of a tyre whose patch has this length, sampled at the strip's rows. Throws Error when
/// the strip does not fit or its numbers cannot be.
Cams make_cams(const StripShape& strip, double unloaded_radius_m, double patch_length_m);

/// The part of make_car that does not depend on the scalar.
void check_car(const CarFiles& files, const Parameters<double>& parameters,
               const Amplitudes<double>& terms);

/// Deflection at which the standing tyre carries `load_n`: the inverse of tyre_load.
template <class T>
T static_deflection(const TyreCoefficients& t, const T& load_n, const T& pressure_pa) {
  using std::sqrt;
  if (t.load_curve.points > 0)
    return deflection_by_curve(t.load_curve, T(load_n / load_factor(t, T(0), pressure_pa)));
  // tyre_load is quadratic in the deflection; two evaluations give its coefficients.
  const double r0 = t.unloaded_radius_m;
  const T one = tyre_load(t, T(0.01 * r0), T(0), pressure_pa);
  const T two = tyre_load(t, T(0.02 * r0), T(0), pressure_pa);
  const T quadratic = (two - 2.0 * one) / 2e-4;
  const T linear = (one - 1e-4 * quadratic) / 0.01;
  const T root = sqrt(linear * linear + 4.0 * quadratic * load_n);
  return r0 * 2.0 * load_n / (linear + root);
}

/// Rolling radius of the tyre that stands under `load_n`.
template <class T>
T standing_rolling_radius(const TyreCoefficients& t, const T& load_n, const T& pressure_pa) {
  return rolling_radius(t, load_n, T(t.unloaded_radius_m * t.qre0),
                        static_deflection(t, load_n, pressure_pa));
}

template <class T>
Car<T> make_car(const CarFiles& files, const Parameters<T>& p, const Amplitudes<T>& terms,
                Contact contact, const StripShape& strip) {
  using std::sqrt;
  {
    Parameters<double> values;
    for (std::size_t i = 0; i < kParameterCount; ++i) values.value[i] = value_of(p.value[i]);
    Amplitudes<double> amplitudes;
    for (std::size_t i = 0; i < kTermCount; ++i) amplitudes.value[i] = value_of(terms.value[i]);
    check_car(files, values, amplitudes);
  }
  using P = Parameter;
  Car<T> car;
  car.files = &files;
  car.parameters = p;
  car.terms = terms;
  car.contact = contact;
  car.strip = strip;
  car.tyre_options.alpha = files.alpha;

  const T front = p[P::chassis_cog_behind_front_m];
  const T rear = p[P::chassis_wheelbase_m] - front;
  const T weight = p[P::chassis_mass_kg] * p[P::environment_gravity_mps2];
  car.static_load_n[0] = weight * rear / (2.0 * p[P::chassis_wheelbase_m]);
  car.static_load_n[1] = weight * front / (2.0 * p[P::chassis_wheelbase_m]);

  T unsprung = T(0);
  Vec3<T> moment;
  Vec3<T> carried;  // inertia of the wheels about the origin, as point masses
  T carried_xz = T(0);
  for (std::size_t i = 0; i < kWheels; ++i) {
    const std::size_t a = axle_of(i);
    const TyreCoefficients& tyre = files.tyre[a];
    const T deflection =
        static_deflection(tyre, car.static_load_n[a], p.axle(a, P::front_tyre_pressure_pa));
    car.static_radius_m[a] = tyre.unloaded_radius_m * tyre.qre0 - deflection;
    const T half = p.axle(a, P::front_track_m) / 2.0;
    Vec3<T>& r = car.wheel_m[i];
    r.x = a == 0 ? front : T(-rear);
    r.y = is_left(i) ? half : T(-half);
    r.z = car.static_radius_m[a] - p[P::chassis_cog_height_m];
    const T m = p.axle(a, P::front_unsprung_mass_kg);
    unsprung += m;
    moment += m * r;
    carried.x += m * (r.y * r.y + r.z * r.z);
    carried.y += m * (r.x * r.x + r.z * r.z);
    carried.z += m * (r.x * r.x + r.y * r.y);
    carried_xz += m * r.x * r.z;
    // Patch: length from the deflection, width from the load share; used by four-point contact.
    const double length = std::sqrt(2.0 * tyre.unloaded_radius_m * value_of(deflection));
    car.patch[2 * a] = length;
    car.patch[2 * a + 1] = 0.35 * tyre.unloaded_radius_m;
    if (contact == Contact::kStrip && is_left(i))
      car.cams[a] = make_cams(strip, tyre.unloaded_radius_m, 2.0 * length);
  }
  car.sprung_mass_kg = p[P::chassis_mass_kg] - unsprung;
  car.sprung_cog_m = (T(-1) / car.sprung_mass_kg) * moment;
  car.sprung_inertia_kgm2 = {p[P::chassis_roll_inertia_kgm2] - carried.x,
                             p[P::chassis_pitch_inertia_kgm2] - carried.y,
                             p[P::chassis_yaw_inertia_kgm2] - carried.z};
  // The whole car's principal axes are those of the body: the sprung part balances the wheels'.
  car.sprung_inertia_xz_kgm2 = carried_xz;
  car.tank_m = {front - p[P::fuel_tank_behind_front_m], T(0),
                p[P::fuel_tank_height_m] - p[P::chassis_cog_height_m]};
  return car;
}

}  // namespace vehicle
