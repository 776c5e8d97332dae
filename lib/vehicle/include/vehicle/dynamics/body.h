// The rigid body with its sliding wheels: kinematics, inertia, accelerations.
#pragma once

#include <array>
#include <cmath>

#include "vehicle/dynamics/evaluation.h"
#include "vehicle/laws/tyre_warm_up.h"

namespace vehicle::dynamics {

template <class T>
using Matrix6 = std::array<std::array<T, 6>, 6>;

/// Factors a symmetric positive definite 6 x 6 matrix in place (LDL^T, lower triangle).
template <class T>
void factor6(Matrix6<T>& a) {
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
void solve6(const Matrix6<T>& a, std::array<T, 6>& b) {
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
  for (std::size_t i = 0; i < 6; ++i) b[i] /= a[i][i];
  for (std::size_t i = 6; i-- > 0;)
    for (std::size_t k = i + 1; k < 6; ++k) b[i] -= a[k][i] * b[k];
}

/// Adds a point mass at r that is free to slide along d to the 6 x 6 inertia, lower triangle: what
/// the body feels of it, mass times J^T (1 - d d^T / d^2) J with J = (1, -[r]x) from (acceleration
/// of the origin, angular acceleration) to that at r. d = 0: the whole mass.
template <class T>
void add_point_mass(Matrix6<T>& m, const T& mass, const Vec3<T>& r, const Vec3<T>& d, const T& d2) {
  const std::array<T, 6> along{
      d.x, d.y, d.z, r.y * d.z - r.z * d.y, r.z * d.x - r.x * d.z, r.x * d.y - r.y * d.x};
  const T scale = mass / d2;
  const auto slid = [&](std::size_t i, std::size_t j) { return scale * along[i] * along[j]; };
  for (std::size_t i = 0; i < 3; ++i) {
    m[i][i] += mass - slid(i, i);
    for (std::size_t j = 0; j < i; ++j) m[i][j] -= slid(i, j);
    m[3 + i][i] -= slid(3 + i, i);
  }
  m[3][1] += -mass * r.z - slid(3, 1);
  m[3][2] += mass * r.y - slid(3, 2);
  m[4][0] += mass * r.z - slid(4, 0);
  m[4][2] += -mass * r.x - slid(4, 2);
  m[5][0] += -mass * r.y - slid(5, 0);
  m[5][1] += mass * r.x - slid(5, 1);
  m[3][3] += mass * (r.z * r.z + r.y * r.y) - slid(3, 3);
  m[4][4] += mass * (r.z * r.z + r.x * r.x) - slid(4, 4);
  m[5][5] += mass * (r.y * r.y + r.x * r.x) - slid(5, 5);
  m[4][3] += -mass * (r.x * r.y) - slid(4, 3);
  m[5][3] += -mass * (r.x * r.z) - slid(5, 3);
  m[5][4] += -mass * (r.y * r.z) - slid(5, 4);
}

/// Rates of place and attitude.
template <class T, TermSet Built>
void move_body(Evaluation<T, Built>& e) {
  const Vec3<T> velocity = e.R.apply(e.V);
  e.out[kX] = velocity.x;
  e.out[kY] = velocity.y;
  e.out[kZ] = velocity.z;
  const Attitude<T>& a = e.leaning;
  const T yaw_part = (e.omega.y * a.sin_roll + e.omega.z * a.cos_roll) / a.cos_pitch;
  e.out[kRoll] = e.omega.x + yaw_part * a.sin_pitch;
  e.out[kPitch] = e.omega.y * a.cos_roll - e.omega.z * a.sin_roll;
  e.out[kYaw] = yaw_part;
}

/// Rotors: their accelerations, and the reaction that the body feels.
template <class T, TermSet Built>
void turn_rotors(Evaluation<T, Built>& e) {
  for (std::size_t i = 0; i < kWheels; ++i) {
    const T& inertia = e.p.axle(axle_of(i), Parameter::front_wheel_inertia_kgm2);
    e.out[kSpin + i] = e.spin_torque[i] / inertia;
    const T felt = e.amount(Term::wheel_reaction);
    e.moment -= (felt * e.spin_torque[i]) * e.axis[i];
    e.detail.power.unfelt += (1.0 - felt) * e.spin_torque[i] * dot(e.axis[i], e.omega);
    if (e.active(Term::gyroscopic))
      e.moment -=
          e.amplitude(Term::gyroscopic) * (inertia * e.s[kSpin + i]) * cross(e.omega, e.axis[i]);
  }
  e.out[kEngine] = e.engine_torque / e.p[Parameter::engine_inertia_kgm2];
}

/// Inertia of body and fuel about the origin, lower triangle.
template <class T, TermSet Built>
void weigh_body(Evaluation<T, Built>& e) {
  const Car<T>& car = e.car;
  Matrix6<T>& inertia = e.detail.inertia;
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
  const T& fuel = e.s[kFuel];
  const auto fuelled = fuel > T(0);
  if (all(fuelled)) {
    add_point_mass(inertia, fuel, car.tank_m, none, T(1));
  } else if (any(fuelled)) {
    const Matrix6<T> dry = inertia;
    add_point_mass(inertia, fuel, car.tank_m, none, T(1));
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j <= i; ++j)
        inertia[i][j] = select(fuelled, inertia[i][j], dry[i][j]);
  }
}

/// Gravity and centrifugal forces of body and fuel.
template <class T, TermSet Built>
void swing_body(Evaluation<T, Built>& e) {
  const Car<T>& car = e.car;
  const Vec3<T>& omega = e.omega;
  const T ms = car.sprung_mass_kg;
  const T& fuel = e.s[kFuel];
  const T fuel_mass = select(fuel > T(0), fuel, T(0));
  const Vec3<T> first_moment = ms * car.sprung_cog_m + fuel_mass * car.tank_m;
  e.force += (ms + fuel_mass) * e.gravity - cross(omega, cross(omega, first_moment));
  e.moment += cross(first_moment, e.gravity);
  const Vec3<T> spin_momentum{
      car.sprung_inertia_kgm2.x * omega.x + car.sprung_inertia_xz_kgm2 * omega.z,
      car.sprung_inertia_kgm2.y * omega.y,
      car.sprung_inertia_xz_kgm2 * omega.x + car.sprung_inertia_kgm2.z * omega.z};
  e.moment -= cross(omega, spin_momentum);
  e.moment -= fuel_mass * cross(car.tank_m, cross(omega, cross(omega, car.tank_m)));
}

/// The accelerations of body and wheels under all that was added up.
template <class T, TermSet Built>
void accelerate(Evaluation<T, Built>& e) {
  const Vec3<T>& omega = e.omega;
  weigh_body(e);
  swing_body(e);
  Matrix6<T>& inertia = e.detail.inertia;
  std::array<Vec3<T>, kWheels> bias;  // of the wheel centres' accelerations
  for (std::size_t i = 0; i < kWheels; ++i) {
    const T& m = e.p.axle(axle_of(i), Parameter::front_unsprung_mass_kg);
    const T& rate = e.s[kTravelRate + i];
    const Vec3<T>&centre = e.centre[i], &slide = e.slide[i];
    bias[i] = cross(omega, cross(omega, centre)) + (2.0 * rate) * cross(omega, slide);
    if (e.files.wheel_path[axle_of(i)].given()) bias[i] += (rate * rate) * e.bend[i];
    add_point_mass(inertia, m, centre, slide, e.slide2[i]);
    const Vec3<T> carried = bias[i] - (dot(bias[i], slide) / e.slide2[i]) * slide;
    const Vec3<T> reaction = (e.travel_force[i] / e.slide2[i]) * slide + m * carried;
    e.force += m * e.gravity - reaction;
    e.moment += cross(centre, m * e.gravity - reaction);
  }
  std::array<T, 6> x{e.force.x, e.force.y, e.force.z, e.moment.x, e.moment.y, e.moment.z};
  factor6(inertia);
  solve6(inertia, x);
  const Vec3<T> acceleration{x[0], x[1], x[2]};  // of the origin, body axes
  const Vec3<T> angular{x[3], x[4], x[5]};
  const Vec3<T> rate = acceleration - cross(omega, e.V);
  e.out[kVx] = rate.x;
  e.out[kVy] = rate.y;
  e.out[kVz] = rate.z;
  e.out[kRollRate] = angular.x;
  e.out[kPitchRate] = angular.y;
  e.out[kYawRate] = angular.z;
  e.detail.specific_force_mps2 = acceleration - e.gravity;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const T& m = e.p.axle(axle_of(i), Parameter::front_unsprung_mass_kg);
    const Vec3<T> a = acceleration + cross(angular, e.centre[i]) + bias[i];
    e.out[kTravel + i] = e.s[kTravelRate + i];
    e.out[kTravelRate + i] = (e.travel_force[i] / m - dot(a, e.slide[i])) / e.slide2[i];
  }
}

/// Rate of the warmth of all tyres, by the specific force across the car.
template <class T, TermSet Built>
void warm_tyres(Evaluation<T, Built>& e) {
  e.out[kTyreWarmth] = T(0);
  if (e.active(Term::tyre_warm_up))
    e.out[kTyreWarmth] = laws::warm_up_rate(e.s[kTyreWarmth], e.p[Parameter::tyre_warm_up_s],
                                            e.detail.specific_force_mps2.y);
}

}  // namespace vehicle::dynamics
