// The car's energy: what the account of powers is checked against.
#pragma once

#include "vehicle/car.h"
#include "vehicle/laws/suspension.h"

namespace vehicle {

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
    const laws::WheelMotion<T> motion =
        laws::wheel_motion(p, car.files->wheel_path[a], car.terms[Term::suspension_kinematics], a,
                           is_left(i) ? 1.0 : -1.0, travel);
    const Vec3<T>& slide = motion.slide;
    const Vec3<T> centre =
        car.wheel_m[i] + (motion.curved ? motion.away_m : Vec3<T>(travel * slide));
    const Vec3<T> v = V + cross(omega, centre) + s[kTravelRate + i] * slide;
    const T& m = p.axle(a, P::front_unsprung_mass_kg);
    total += m * (0.5 * dot(v, v) + g * height(centre));
    total += 0.5 * p.axle(a, P::front_wheel_inertia_kgm2) * s[kSpin + i] * s[kSpin + i];
    const laws::CornerSpring<T> own = laws::corner_spring(p, a, is_left(i) ? 1.0 : -1.0);
    total += (car.static_load_n[a] - m * g + own.preload_n) * travel +
             0.5 * own.rate_npm * travel * travel;
    if (is_left(i)) {
      const T twist = travel - s[kTravel + i + 1];
      total +=
          0.5 * car.terms[Term::anti_roll_bar] * p.axle(a, P::front_anti_roll_npm) * twist * twist;
    }
    const T stop = car.terms[Term::bump_stop] * p.axle(a, P::front_bump_stop_npm2) / 3.0;
    const laws::StopCompression<T> into = laws::stop_compression(p, a, travel);
    if (into.bump_m > T(0)) total += stop * into.bump_m * into.bump_m * into.bump_m;
    if (into.droop_m > T(0)) total += stop * into.droop_m * into.droop_m * into.droop_m;
  }
  if (car.files->turbo == Turbo::kFull)
    total += 0.5 * p[P::turbo_inertia_kgm2] * s[kTurbo] * s[kTurbo];
  return total + 0.5 * p[P::engine_inertia_kgm2] * s[kEngine] * s[kEngine];
}

}  // namespace vehicle
