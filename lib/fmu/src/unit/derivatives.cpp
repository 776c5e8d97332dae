// Rates of the states, and derivatives along a direction of states and inputs: by numbers that
// carry their derivative through the equations (Jet of Ceres), exact but for the road, which counts
// as the plane that touches it under each wheel.
#include <ceres/jet.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "base/error.h"
#include "fmu/instance.h"
#include "vehicle/opponent.h"

namespace fmu {
namespace {

using Jet = ceres::Jet<double, 1>;
using vehicle::kWheels;

Jet jet(double value, double along = 0.0) {
  Jet out(value);
  out.v[0] = along;
  return out;
}

template <std::size_t N>
std::array<Jet, N> jets(const std::array<double, N>& values, const std::array<double, N>& along) {
  std::array<Jet, N> out;
  for (std::size_t i = 0; i < N; ++i) out[i] = jet(values[i], along[i]);
  return out;
}

vehicle::laws::Stick<Jet> jets(const vehicle::laws::Stick<double>& s) {
  return {jet(s.output), jet(s.drive), s.moving};
}
vehicle::laws::Actuator<Jet> jets(const vehicle::laws::Actuator<double>& a) {
  return {jets(a.history, {}), jet(a.place), jet(a.rate)};
}

vehicle::laws::Ledge<Jet> jets(const vehicle::laws::Ledge<double>& l) {
  return {l.known,          l.hub_m,       l.normal,      l.radius_m,
          jet(l.pressed_m), jet(l.sunk_m), jet(l.lent_j), l.lent_at_m};
}

/// What changes between steps: no state of the equations, so it has no derivative.
vehicle::Discrete<Jet> jets(const vehicle::Discrete<double>& d) {
  vehicle::Discrete<Jet> out;
  out.steer = jets(d.steer);
  out.throttle = jets(d.throttle);
  for (std::size_t i = 0; i < kWheels; ++i) {
    out.brake[i] = jets(d.brake[i]);
    out.brake_stick[i] = jets(d.brake_stick[i]);
    out.ledge[i] = jets(d.ledge[i]);
  }
  out.stuck_steer_rad = jet(d.stuck_steer_rad);
  out.last_steer_rad = jet(d.last_steer_rad);
  out.steer_stick = jets(d.steer_stick);
  out.played_steer_rad = jet(d.played_steer_rad);
  out.throttle_stick = jets(d.throttle_stick);
  out.gear = d.gear;
  out.gear_wanted = d.gear_wanted;
  out.shift_left_s = d.shift_left_s;
  out.step = d.step;
  return out;
}

vehicle::Controls<Jet> jets(const vehicle::Controls<double>& c,
                            const vehicle::Controls<double>& along) {
  vehicle::Controls<Jet> out;
  out.steer_command_rad = jet(c.steer_command_rad, along.steer_command_rad);
  out.throttle_command = jet(c.throttle_command, along.throttle_command);
  out.brake_command_pa = jets(c.brake_command_pa, along.brake_command_pa);
  out.gear_command = c.gear_command;
  out.clutch_command = jet(c.clutch_command, along.clutch_command);
  out.opponent = c.opponent;
  out.wake_x_m = jet(c.wake_x_m, along.wake_x_m);
  out.wake_y_m = jet(c.wake_y_m, along.wake_y_m);
  return out;
}

/// As the next step has them.
template <class T>
vehicle::State<T> rates_of(const vehicle::Car<T>& car, const vehicle::State<T>& state,
                           vehicle::Discrete<T> discrete, const vehicle::Controls<T>& controls,
                           const vehicle::Road& road, vehicle::RoadCursors cursors, double step_s) {
  const vehicle::Inputs<T> in = vehicle::actuate(car, discrete, controls, step_s);
  vehicle::State<T> rate;
  vehicle::Detail<T> detail;
  vehicle::derivative(car, state, in, road, cursors, rate, detail);
  vehicle::settle_frictions(car, step_s, rate, detail);
  if (car.files->turbo == vehicle::Turbo::kFull) vehicle::settle_air(step_s, rate, detail);
  vehicle::settle_ledges(car, step_s, state, discrete.ledge, discrete.ledges, rate, detail);
  return rate;
}

}  // namespace

void Instance::be_current() {
  prepare();
  if (!now_.started) throw base::Error("rates of states are there once the unit is initialised");
  if (changed_) build_car();
  changed_ = false;
}

double Instance::rate(std::size_t state) {
  be_current();
  vehicle::Controls<double> asked = controls();
  look_at_opponents(asked);
  const vehicle::Simulation<double>& s = now_.simulation;
  return rates_of(car_, s.state, s.discrete, asked, files_->road, s.cursors,
                  options_.step_s)[state];
}

/// How what the car is asked changes with inputs and, for places of opponents, with states.
vehicle::Controls<double> Instance::change_of_controls(std::span<const double> along,
                                                       const vehicle::Controls<double>& asked) {
  const auto input_along = [&](Input which, std::size_t i = 0) {
    return along[input_[static_cast<std::size_t>(which)] + i];
  };
  const double* const state_along = along.data() + first_[static_cast<std::size_t>(Source::kState)];
  vehicle::Controls<double> out;
  out.steer_command_rad = input_along(Input::kSteering);
  out.throttle_command = input_along(Input::kThrottle);
  for (std::size_t i = 0; i < kWheels; ++i) out.brake_command_pa[i] = input_along(Input::kBrake, i);
  out.clutch_command = input_along(Input::kClutch);
  if (input(Input::kWakeActive) != 0.0) {
    out.wake_x_m = input_along(Input::kWakeX);
    out.wake_y_m = input_along(Input::kWakeY);
  } else if (asked.opponent) {
    // Of the opponent that counts, from where the car is: both may move, and the car may turn.
    const vehicle::State<double>& s = now_.simulation.state;
    const double cy = std::cos(s[vehicle::kYaw]), sy = std::sin(s[vehicle::kYaw]);
    for (std::size_t i = 0; i < 4; ++i) {
      const vehicle::OpponentPlace place{input(Input::kOpponentX, i), input(Input::kOpponentY, i)};
      const auto wake = vehicle::nearest_wake(std::span(&place, 1), s);
      if (input(Input::kOpponentActive, i) == 0.0 || wake->x_m != asked.wake_x_m ||
          wake->y_m != asked.wake_y_m)
        continue;
      const double dx = input_along(Input::kOpponentX, i) - state_along[vehicle::kX],
                   dy = input_along(Input::kOpponentY, i) - state_along[vehicle::kY],
                   turn = state_along[vehicle::kYaw];
      out.wake_x_m = cy * dx + sy * dy + turn * wake->y_m;
      out.wake_y_m = -sy * dx + cy * dy - turn * wake->x_m;
      break;
    }
  }
  return out;
}

std::vector<double> Instance::derivatives(std::span<const std::uint32_t> unknowns,
                                          std::span<const std::uint32_t> knowns,
                                          std::span<const double> seed) {
  if (now_.phase != Phase::kStepping)
    throw base::Error("derivatives are there between steps alone, after the initialisation");
  std::vector<double> along(count_values(list_), 0.0);
  for (std::size_t k = 0; k < knowns.size(); ++k) {
    const Variable& v = variable(knowns[k]);
    if (v.type != Type::kReal || (v.source != Source::kInput && v.source != Source::kState))
      throw base::Error(fmt::format("a derivative after {}, wanted a real input or a state",
                                    value_name(v, knowns[k] - v.reference)));
    if (!std::isfinite(seed[k])) throw base::Error("a direction that is no number");
    along[knowns[k]] += seed[k];
  }
  be_current();
  vehicle::Controls<double> asked = controls();
  look_at_opponents(asked);
  const vehicle::Simulation<double>& s = now_.simulation;
  vehicle::State<double> state_along;
  std::copy_n(along.begin() + first_[static_cast<std::size_t>(Source::kState)], vehicle::kStateSize,
              state_along.value.begin());

  std::optional<vehicle::State<Jet>> rates;
  const auto rate_along = [&](std::size_t i) {
    if (!rates) {
      const auto car =
          vehicle::make_car<Jet>(*car_.files, {jets(car_.parameters.value, {})},
                                 {jets(car_.terms.value, {})}, car_.contact, car_.strip);
      rates = rates_of(car, {jets(s.state.value, state_along.value)}, jets(s.discrete),
                       jets(asked, change_of_controls(along, asked)), files_->road, s.cursors,
                       options_.step_s);
    }
    return (*rates)[i].v[0];
  };
  const double u_m = now_.numbers[1], v_m = now_.numbers[2];
  crg::Heading road{0.0, 0.0};
  if (files_->surface) road = files_->surface->heading_at_uv(u_m, v_m);
  const double c = std::cos(road.heading_rad), d = std::sin(road.heading_rad);
  const double dx = state_along[vehicle::kX], dy = state_along[vehicle::kY];

  std::vector<double> out;
  for (const std::uint32_t reference : unknowns) {
    const Variable& v = variable(reference);
    const std::size_t i = v.index + (reference - v.reference);
    if (v.type != Type::kReal || (v.causality != Causality::kOutput && v.source != Source::kRate))
      throw base::Error(fmt::format("a derivative of {}, wanted a real output or a rate",
                                    value_name(v, reference - v.reference)));
    const std::vector<std::size_t> states = states_behind(v, reference - v.reference);
    if (v.source == Source::kRate)
      out.push_back(rate_along(i));
    else if (reference == 1)  // u: the line through the place is longer or shorter than the road's
      out.push_back((c * dx + d * dy) * (1.0 + v_m * road.curvature_1pm));
    else if (reference == 2)  // v
      out.push_back(-d * dx + c * dy);
    else
      out.push_back(states.empty() ? 0.0 : state_along[states[0]]);
  }
  return out;
}

}  // namespace fmu
