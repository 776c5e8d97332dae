// From what is asked of the car to what it gets: actuators and gearbox, which move between steps.
#pragma once

#include <array>
#include <cstdint>

#include "vehicle/car.h"
#include "vehicle/laws/actuator.h"
#include "vehicle/laws/actuator_friction.h"
#include "vehicle/laws/ledge.h"
#include "vehicle/laws/steering.h"

namespace vehicle {

/// What a driver, a log or a script asks of the car.
template <class T>
struct Controls {
  T steer_command_rad = T(0);  ///< mean road wheel angle times steering.ratio, or by its map
  T throttle_command = T(0);   ///< 0 to 1
  std::array<T, kWheels> brake_command_pa{};
  int gear_command = 1;     ///< 1 to kMostGears, 0 neutral, -1 reverse
  T clutch_command = T(0);  ///< see Inputs
  T hold_n = T(0);          ///< see Inputs
  bool opponent = false;
  T wake_x_m = T(0), wake_y_m = T(0);  ///< the opponent in this car's body frame
};

/// What changes only between steps.
template <class T>
struct Discrete {
  laws::Actuator<T> steer, throttle;
  std::array<laws::Actuator<T>, kWheels> brake;
  T stuck_steer_rad = T(0);    ///< where friction holds the steering
  T last_steer_rad = T(0);     ///< of the step before
  laws::Stick<T> steer_stick;  ///< the same with a break-away
  T played_steer_rad = T(0);   ///< where backlash leaves the road wheels
  std::array<laws::Stick<T>, kWheels> brake_stick;
  laws::Stick<T> throttle_stick;
  int gear = 1, gear_wanted = 1;
  double shift_left_s = 0.0;
  std::array<laws::Ledge<T>, kWheels> ledge;
  laws::LedgeTotal ledges;
  std::int64_t step = 0;  ///< steps taken; also the place in every ring
};

/// What friction leaves of the pressures and of the throttle.
template <class T>
void hold_back(const Car<T>& car, Discrete<T>& d, Inputs<T>& in) {
  using P = Parameter;
  const Parameters<T>& p = car.parameters;
  if (!is_exactly_zero(car.terms[Term::throttle_friction]) &&
      (!is_exactly_zero(p[P::throttle_friction]) || !is_exactly_zero(p[P::throttle_breakaway]))) {
    laws::stick(in.throttle, T(car.terms[Term::throttle_friction] * p[P::throttle_friction]),
                T(car.terms[Term::throttle_friction] * p[P::throttle_breakaway]), d.throttle_stick);
    in.throttle = d.throttle_stick.output;
  }
  const bool sticks =
      !is_exactly_zero(car.terms[Term::brake_friction]) &&
      (!is_exactly_zero(p[P::brake_friction_pa]) || !is_exactly_zero(p[P::brake_breakaway_pa]));
  for (std::size_t i = 0; i < kWheels && sticks; ++i) {
    laws::stick(in.brake_pa[i], T(car.terms[Term::brake_friction] * p[P::brake_friction_pa]),
                T(car.terms[Term::brake_friction] * p[P::brake_breakaway_pa]), d.brake_stick[i]);
    in.brake_pa[i] = d.brake_stick[i].output;
  }
}

/// How a car's actuators answer, for steps of one length.
template <class T>
struct Responses {
  laws::Response<T> steer, throttle, brake;
};
template <class T>
Responses<T> actuator_responses(const Car<T>& car, double step_s) {
  using P = Parameter;
  // The four parameters of an actuator follow one another in the list.
  const auto response = [&](Term term, P dead_time) {
    if (is_exactly_zero(car.terms[term])) return laws::Response<T>{};
    const T* const own = &car.parameters[dead_time];  // dead time, lag, damping, lead
    return laws::actuator_response(own[0], own[1], own[2], own[3], step_s);
  };
  return {response(Term::steering_actuator, P::steering_dead_time_s),
          response(Term::throttle_actuator, P::throttle_dead_time_s),
          response(Term::brake_actuator, P::brake_dead_time_s)};
}

/// Moves actuators and gearbox on by one step and returns what the car gets during it.
template <class T>
Inputs<T> actuate(const Car<T>& car, Discrete<T>& d, const Controls<T>& controls, double step_s,
                  const Responses<T>& responses) {
  using P = Parameter;
  const Parameters<T>& p = car.parameters;
  const auto through = [&](laws::Actuator<T>& actuator, Term term, const T& command,
                           const laws::Response<T>& by) {
    if (is_exactly_zero(car.terms[term])) return command;
    const T moved = laws::move(actuator, d.step, command, by);
    return T(command + car.terms[term] * (moved - command));
  };
  Inputs<T> in;
  in.steer_rad = through(
      d.steer, Term::steering_actuator,
      laws::road_wheel_angle(car.files->steering, p[P::steering_ratio], controls.steer_command_rad),
      responses.steer);
  if (!is_exactly_zero(car.terms[Term::steering_friction])) {
    // The wheels stay where they are until the actuator is ahead of them by the friction width.
    const T width = car.terms[Term::steering_friction] * p[P::steering_friction_rad];
    if (is_exactly_zero(p[P::steering_breakaway_rad])) {
      laws::play(in.steer_rad, width, d.stuck_steer_rad);
      in.steer_rad = d.stuck_steer_rad;
    } else {
      laws::stick(in.steer_rad, width,
                  T(car.terms[Term::steering_friction] * p[P::steering_breakaway_rad]),
                  d.steer_stick);
      in.steer_rad = d.steer_stick.output;
    }
  }
  if (!is_exactly_zero(car.terms[Term::steering_backlash]) &&
      !is_exactly_zero(p[P::steering_backlash_rad])) {
    laws::play(in.steer_rad,
               T(0.5 * car.terms[Term::steering_backlash] * p[P::steering_backlash_rad]),
               d.played_steer_rad);
    in.steer_rad = d.played_steer_rad;
  }
  in.steer_rate_radps = d.step == 0 ? T(0) : T((in.steer_rad - d.last_steer_rad) / step_s);
  d.last_steer_rad = in.steer_rad;
  in.throttle = through(d.throttle, Term::throttle_actuator,
                        T(p[P::throttle_gain] * controls.throttle_command), responses.throttle);
  for (std::size_t i = 0; i < kWheels; ++i)
    in.brake_pa[i] = through(d.brake[i], Term::brake_actuator,
                             T(p[P::brake_gain] * controls.brake_command_pa[i]), responses.brake);
  hold_back(car, d, in);
  in.clutch = controls.clutch_command;
  in.hold_n = controls.hold_n;
  for (std::size_t i = 0; i < kWheels; ++i) in.sunk_m[i] = d.ledge[i].sunk_m;
  in.opponent = controls.opponent;
  in.wake_x_m = controls.wake_x_m;
  in.wake_y_m = controls.wake_y_m;

  if (controls.gear_command != d.gear_wanted) {
    d.gear_wanted = controls.gear_command;
    d.shift_left_s = value_of(p[P::gearbox_shift_s]);
  }
  // Half a step of tolerance, so that a shift takes the same number of steps on every machine.
  if (d.shift_left_s > 0.5 * step_s) {
    d.gear = 0;
    d.shift_left_s -= step_s;
  } else {
    d.gear = d.gear_wanted;
  }
  in.gear = d.gear;
  in.next_gear = d.gear == 0 ? d.gear_wanted : 0;
  ++d.step;
  return in;
}
template <class T>
Inputs<T> actuate(const Car<T>& car, Discrete<T>& d, const Controls<T>& controls, double step_s) {
  return actuate(car, d, controls, step_s, actuator_responses(car, step_s));
}

}  // namespace vehicle
