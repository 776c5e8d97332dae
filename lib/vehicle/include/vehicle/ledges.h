// No energy from a ledge: a road that stands still does no work.
#pragma once

#include <array>
#include <cmath>
#include <string>

#include "vehicle/dynamics.h"
#include "vehicle/laws/ledge.h"

namespace vehicle {

namespace ledges {

/// Answer of the car to a push at a wheel: accelerations of the origin, about it, of the travel.
template <class T>
struct Answer {
  Vec3<T> acceleration, angular;
  T travel;

  /// Acceleration of a point at `r` that moves by `path` with the wheel's travel.
  Vec3<T> at(const Vec3<T>& r, const Vec3<T>& path) const {
    return acceleration + cross(angular, r) + travel * path;
  }
};

/// `force` on wheel `i` at `r`, a point that moves by `path` with the travel; body frame.
template <class T>
Answer<T> push(const Car<T>& car, const Detail<T>& detail, std::size_t i, const Vec3<T>& force,
               const Vec3<T>& r, const Vec3<T>& path) {
  const WheelDetail<T>& w = detail.wheel[i];
  const T slide2 = dot(w.slide, w.slide);
  const T along = dot(force, path);
  const Vec3<T> carried = (along / slide2) * w.slide;
  const Vec3<T> moment = cross(r, force) - cross(w.centre, carried);
  const Vec3<T> rest = force - carried;
  std::array<T, 6> x{rest.x, rest.y, rest.z, moment.x, moment.y, moment.z};
  dynamics::solve6(detail.inertia, x);
  Answer<T> out{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}, T(0)};
  const Vec3<T> a = out.acceleration + cross(out.angular, w.centre);
  const T& mass = car.parameters.axle(axle_of(i), Parameter::front_unsprung_mass_kg);
  out.travel = (along / mass - dot(a, w.slide)) / slide2;
  // Wheels elsewhere follow the body.
  return out;
}

/// Adds `share` of an answer to the rates and to what the accelerometer feels.
template <class T>
void add(const Answer<T>& answer, const T& share, std::size_t i, State<T>& rate,
         Detail<T>& detail) {
  const Vec3<T> a = share * answer.acceleration, b = share * answer.angular;
  rate[kVx] += a.x;
  rate[kVy] += a.y;
  rate[kVz] += a.z;
  rate[kRollRate] += b.x;
  rate[kPitchRate] += b.y;
  rate[kYawRate] += b.z;
  detail.specific_force_mps2 += a;
  for (std::size_t k = 0; k < kWheels; ++k) {
    const WheelDetail<T>& w = detail.wheel[k];
    if (k == i)
      rate[kTravelRate + k] += share * answer.travel;
    else
      rate[kTravelRate + k] -= dot(a + cross(b, w.centre), w.slide) / dot(w.slide, w.slide);
  }
}

/// Direction of the hub's motion along the ground, body frame, and its speed at the step's end.
template <class T>
struct Heading {
  Vec3<T> along;
  T speed_mps;
};

template <class T>
Heading<T> heading_of(const State<T>& s, const State<T>& rate, double h, const WheelDetail<T>& w,
                      std::size_t i, const Rotation<T>& R) {
  const auto hub = [&](double share) {
    const auto moved = [&](std::size_t k) { return T(s[k] + share * h * rate[k]); };
    const Vec3<T> omega{moved(kRollRate), moved(kPitchRate), moved(kYawRate)};
    return Vec3<T>{moved(kVx), moved(kVy), moved(kVz)} + cross(omega, w.centre) +
           moved(kTravelRate + i) * w.slide;
  };
  Vec3<T> ground = R.apply(hub(0.0));
  ground.z = T(0);
  const T speed = norm(ground);
  if (!(speed > T(1e-3))) return {{}, T(0)};
  const Vec3<T> along = R.undo((1.0 / speed) * ground);
  return {along, dot(along, hub(1.0))};
}

/// What the motion of a hub along the ground can pay with.
template <class T>
struct Purse {
  Heading<T> way;
  Answer<T> answer;  ///< to a unit push along the way
  T per_mass_1pkg, there_j;
};

template <class T>
Purse<T> purse_of(const Car<T>& car, const State<T>& s, double h, std::size_t i,
                  const State<T>& rate, const Detail<T>& detail) {
  const WheelDetail<T>& w = detail.wheel[i];
  Purse<T> out{heading_of(s, rate, h, w, i, detail.to_map), {}, T(0), T(0)};
  if (!(out.way.speed_mps > T(0))) return out;
  out.answer = push(car, detail, i, out.way.along, w.centre, w.slide);
  out.per_mass_1pkg = dot(out.way.along, out.answer.at(w.centre, w.slide));
  out.there_j = 0.5 * out.way.speed_mps * out.way.speed_mps / out.per_mass_1pkg;
  return out;
}

/// Takes `work_j` out of the motion, which has it; below 0: gives it.
template <class T>
void take(const Purse<T>& purse, const T& work_j, double h, std::size_t i, laws::Ledge<T>& ledge,
          State<T>& rate, Detail<T>& detail) {
  if (!(purse.there_j > T(0))) return;
  const T impulse = laws::impulse_for(work_j, purse.way.speed_mps, purse.per_mass_1pkg);
  add(purse.answer, T(-impulse / h), i, rate, detail);
  detail.power.ledge -= work_j / h;
  ledge.lent_j += work_j;
}

/// Gives wheel `i` the load of the deflection `to_m` in place of the one it has.
template <class T>
void press(const Car<T>& car, std::size_t i, const T& to_m, State<T>& rate, Detail<T>& detail) {
  WheelDetail<T>& w = detail.wheel[i];
  const std::size_t a = axle_of(i);
  const T& pressure = car.parameters.axle(a, Parameter::front_tyre_pressure_pa);
  const auto load = [&](const T& at_m) {
    return tyre_load(car.files->tyre[a], at_m, w.spin_radps, pressure);
  };
  T more = load(to_m) - load(w.deflection_m);
  if (more < -w.fz_n) more = -w.fz_n;
  add(push(car, detail, i, more * w.normal, w.contact_m, w.swing), T(1), i, rate, detail);
  w.fz_n += more;
  w.deflection_m = to_m;
}

/// A plane that loads the spring of wheel `i` from `from_m` to `to_m`.
template <class T>
void climb(const Car<T>& car, const State<T>& s, double h, std::size_t i, const T& from_m,
           const T& to_m, const T& work_j, laws::Ledge<T>& ledge, State<T>& rate,
           Detail<T>& detail) {
  Purse<T> purse = purse_of(car, s, h, i, rate, detail);
  if (dot(purse.way.along, detail.wheel[i].normal) > T(laws::kFallsAway)) {
    ledge.sunk_m = to_m - from_m;
    press(car, i, from_m, rate, detail);
    return;
  }
  if (!(work_j > T(0))) return;
  ledge.lent_at_m = ledge.hub_m;
  if (work_j <= purse.there_j) {
    take(purse, work_j, h, i, ledge, rate, detail);
    return;
  }
  // The new plane presses as far as the motion without its load can pay: the spring's energy is
  // convex in the deflection, so a share of the way costs at most that share of the work.
  press(car, i, from_m, rate, detail);
  purse = purse_of(car, s, h, i, rate, detail);
  const T paid = purse.there_j < work_j ? purse.there_j : work_j;
  take(purse, paid, h, i, ledge, rate, detail);
  ledge.sunk_m = (1.0 - paid / work_j) * (to_m - from_m);
  press(car, i, T(to_m - ledge.sunk_m), rate, detail);
}

/// A plane that unloads it: gives back what it took within a tyre's radius.
template <class T>
void descend(const Car<T>& car, const State<T>& s, double h, std::size_t i, const T& work_j,
             laws::Ledge<T>& ledge, State<T>& rate, Detail<T>& detail) {
  const Vec3<double> gone = ledge.hub_m - ledge.lent_at_m;
  const double reach_m = car.files->tyre[axle_of(i)].unloaded_radius_m;
  if (dot(gone, gone) > reach_m * reach_m) ledge.lent_j = T(0);
  if (work_j > T(0)) return;
  const T back = -work_j < ledge.lent_j ? work_j : T(-ledge.lent_j);
  if (back < T(0)) take(purse_of(car, s, h, i, rate, detail), back, h, i, ledge, rate, detail);
}

/// Remembers where the hub of wheel `i` is and what plane presses it.
template <class T>
void remember(const Rotation<Real<T>>& R, const Vec3<Real<T>>& origin, const WheelDetail<T>& w,
              laws::Ledge<T>& ledge) {
  ledge.hub_m = origin + R.apply(value_of(w.centre));
  ledge.normal = R.apply(value_of(w.normal));
  ledge.radius_m = -dot(value_of(w.arm), value_of(w.normal));
  ledge.pressed_m = select(w.deflection_m > T(0), w.deflection_m, T(0));
  ledge.known = true;
}

/// By how much more the plane of `now` presses the wheel than that of `last` would where it is.
template <class T>
Real<T> jump_m(const laws::Ledge<T>& last, const laws::Ledge<T>& now) {
  return dot(last.normal, now.hub_m - last.hub_m) + last.radius_m - now.radius_m;
}

/// Whether a plane that jumps so is one to settle.
template <class T>
Flag<T> turns(const laws::Ledge<T>& last, const Real<T>& jump) {
  using std::abs;
  return last.known && (abs(jump) > laws::kLedge_m || last.sunk_m > T(0));
}

/// Whether the car was put elsewhere between two steps: then it met no ledge.
template <class T>
bool was_put(const laws::Ledge<T>& last, const laws::Ledge<T>& now, double speed_mps, double h) {
  constexpr double kOfHub_mps = 10.0;  // faster than the car, by springs and turning
  const Vec3<double> gone = now.hub_m - last.hub_m;
  const double far_m = 2.0 * h * (speed_mps + kOfHub_mps);
  return !(dot(gone, gone) <= far_m * far_m);
}

/// Wheel `i` under a plane that presses it by `jump_m` more than the last one would here.
template <class T>
void meet(const Car<T>& car, const State<T>& s, double h, std::size_t i, double jump_m,
          const laws::Ledge<T>& last, laws::Ledge<T>& ledge, laws::LedgeTotal& total,
          State<T>& rate, Detail<T>& detail) {
  WheelDetail<T>& w = detail.wheel[i];
  const std::size_t a = axle_of(i);
  const TyreCoefficients& tyre = car.files->tyre[a];
  const T& pressure = car.parameters.axle(a, Parameter::front_tyre_pressure_pa);
  const T full = w.deflection_m + last.sunk_m;
  const T moved = full - jump_m - last.sunk_m;  // by the last plane; below 0: above it
  const T to = full > T(0) ? full : T(0), from = moved > T(0) ? moved : T(0);
  // What the spring gains, less what the last step's load did on the way.
  const T work = laws::spring_work(tyre, last.pressed_m, to, w.spin_radps, pressure) -
                 tyre_load(tyre, last.pressed_m, w.spin_radps, pressure) * (moved - last.pressed_m);
  if (to > from)
    climb(car, s, h, i, from, to, work, ledge, rate, detail);
  else if (to < from)
    descend(car, s, h, i, work, ledge, rate, detail);
  ledge.pressed_m = w.deflection_m > T(0) ? w.deflection_m : T(0);
  if (jump_m > laws::kLedge_m) laws::count(total, value_of(work), w.road.u_m, w.road.v_m);
}

}  // namespace ledges

/// Makes roads do no work. A wheel is pressed by the plane that touches the road below it. Where
/// that plane turns from one step to the next, the deflection d jumps by more than the wheel moved
/// against the plane: the spring's energy U(d) grows without anything having pushed. The road
/// stands still, so U is a potential of the car's place, and what it gained is the work of the
/// force that the plane leaves out, along the way between both steps: the discrete gradient of U
/// (O. Gonzalez, Time integration and discrete Hamiltonian systems, J. Nonlinear Science 6, 1996).
/// That work W is taken as an impulse at the hub, against its motion along the ground, which ends
/// with exactly W less kinetic energy. Three bounds keep it passive (B. Hannaford and J.-H. Ryu,
/// Time-domain passivity control of haptic interfaces, IEEE Trans. Robotics and Automation 18,
/// 2002): a motion that has less than W pays what it has, and the deflection that is not paid for
/// does not press; a plane that turns back returns at most what was taken within a tyre's radius;
/// a plane that falls away under the wheel presses no more than the one before it.
/// Turns of less than kLedge_m in a step are left alone. Strips envelop ledges and need none of it.
/// `s`: the state that `rate` and `detail` belong to, frictions settled.
template <class T>
void settle_ledges(const Car<T>& car, double h, const State<T>& s,
                   std::array<laws::Ledge<T>, kWheels>& all, laws::LedgeTotal& total,
                   State<T>& rate, Detail<T>& detail) {
  if (car.contact == Contact::kStrip) return;
  const Rotation<double> R = value_of(detail.to_map);
  const Vec3<double> origin = value_of(Vec3<T>{s[kX], s[kY], s[kZ]});
  for (std::size_t i = 0; i < kWheels; ++i) {
    laws::Ledge<T>& ledge = all[i];
    const laws::Ledge<T> last = ledge;
    ledges::remember(R, origin, detail.wheel[i], ledge);
    ledge.sunk_m = T(0);
    const double jump = ledges::jump_m(last, ledge);
    if (!ledges::turns(last, jump)) continue;
    const Vec3<T> velocity{s[kVx], s[kVy], s[kVz]};
    if (ledges::was_put(last, ledge, norm(value_of(velocity)), h)) continue;
    ledges::meet(car, s, h, i, jump, last, ledge, total, rate, detail);
  }
}

/// Empty where no ledge is worth saying, else one sentence: where, how much, what to do.
std::string ledge_warning(const laws::LedgeTotal& total);

}  // namespace vehicle
