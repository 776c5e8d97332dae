#include "fmu/saved_state.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

#include "base/archive.h"
#include "base/error.h"

namespace fmu {
namespace {

constexpr base::ArchiveKind kCarState{"kerbstone car", 5};

[[noreturn]] void refuse(std::string_view why) {
  throw base::Error(fmt::format("this is no state of this unit: {}", why));
}

template <class Archive, class Actuator>
void each_field_of_actuator(Archive& archive, Actuator& a) {
  archive(a.history, a.place, a.rate);
}

template <class Archive, class Stick>
void each_field_of_stick(Archive& archive, Stick& s) {
  archive(s.output, s.drive, s.moving);
}

template <class Archive, class Ledge>
void each_field_of_ledge(Archive& archive, Ledge& l) {
  archive(l.known);
  for (auto* const at : {&l.hub_m, &l.normal, &l.lent_at_m}) archive(at->x, at->y, at->z);
  archive(l.radius_m, l.pressed_m, l.sunk_m, l.lent_j);
}

/// The one order of the fields, for writing and for reading.
template <class Archive, class Simulation>
void each_field_of_simulation(Archive& archive, Simulation& sim) {
  archive(sim.state.value);
  auto& d = sim.discrete;
  each_field_of_actuator(archive, d.steer);
  each_field_of_actuator(archive, d.throttle);
  for (auto& brake : d.brake) each_field_of_actuator(archive, brake);
  archive(d.stuck_steer_rad, d.last_steer_rad);
  each_field_of_stick(archive, d.steer_stick);
  archive(d.played_steer_rad);
  for (auto& stick : d.brake_stick) each_field_of_stick(archive, stick);
  each_field_of_stick(archive, d.throttle_stick);
  for (auto& ledge : d.ledge) each_field_of_ledge(archive, ledge);
  archive(d.ledges.work_j, d.ledges.most_j, d.ledges.u_m, d.ledges.v_m);
  archive(d.gear, d.gear_wanted, d.shift_left_s, d.step, sim.time_s);
}

template <class Archive, class State>
void each_field(Archive& archive, State& state) {
  archive(state.phase, state.started, state.begin_s, state.texts, state.numbers, state.given);
  archive(state.place.u_m, state.place.v_m, state.place.x_m, state.place.y_m);
  each_field_of_simulation(archive, state.simulation);
}

void require_sane(const SavedState& state, const std::vector<Variable>& list) {
  const auto want = [](bool holds, std::string_view what) {
    if (!holds) refuse(what);
  };
  constexpr double kLargest = 1e9;  // in any unit
  const auto& d = state.simulation.discrete;
  const std::size_t numbers = count_values(list) - kTextCount;
  want(state.numbers.size() == numbers && state.given.size() == numbers, "a count of values");
  want(state.phase >= Phase::kInstantiated && state.phase <= Phase::kFailed, "a phase");
  want(state.started || state.phase < Phase::kStepping, "it steps without a car");
  const auto is_gear = [](int gear) { return gear >= -1 && gear <= vehicle::kMostGears; };
  want(is_gear(d.gear) && is_gear(d.gear_wanted), "a gear");
  want(d.step >= 0 && d.step < std::int64_t{1} << 52, "a count of steps");
  want(std::isfinite(d.shift_left_s) && std::isfinite(state.begin_s), "a time");
  for (const signed char given : state.given)
    want(given >= kNotGiven && given <= kGivenAsExported, "a mark that is neither");
  for (const double value : state.simulation.state.value)
    want(!state.started || std::abs(value) <= kLargest, "a state that no car has");
  for (const double value : {state.place.v_m, state.place.x_m, state.place.y_m})
    want(std::abs(value) <= kLargest, "a place");
  for (const auto& ledge : d.ledge) {
    for (const auto& at : {ledge.hub_m, ledge.normal, ledge.lent_at_m})
      want(std::abs(at.x) + std::abs(at.y) + std::abs(at.z) <= kLargest, "a plane under a wheel");
    want(ledge.pressed_m >= 0.0 && ledge.sunk_m >= 0.0 && ledge.lent_j >= 0.0 &&
             ledge.pressed_m + ledge.sunk_m + std::abs(ledge.radius_m) <= kLargest &&
             ledge.lent_j <= kLargest,
         "a deflection");
  }
  want(std::isnan(state.place.u_m) || std::abs(state.place.u_m) <= kLargest, "a place");
  for (const Variable& v : list)
    for (std::size_t i = 0; i < v.size && v.source != Source::kText; ++i) {
      const double value = state.numbers[v.reference + i];
      const bool set = v.causality == Causality::kInput || v.causality == Causality::kParameter;
      want(!set || (value >= v.low && value <= v.high), fmt::format("{} = {}", v.name, value));
      want(!set || v.type == Type::kReal || value == std::floor(value), v.name);
    }
}

}  // namespace

std::string to_bytes(const SavedState& state, std::string_view token) {
  base::ArchiveWriter out(kCarState);
  out(std::string(token));
  each_field(out, state);
  return out.finish();
}

SavedState from_bytes(std::string_view bytes, std::string_view token,
                      const std::vector<Variable>& list) {
  base::ArchiveReader in(bytes, kCarState);
  std::string own;
  in(own);
  if (in.good() && own != token) refuse("it was saved by another unit");
  SavedState state;
  each_field(in, state);
  if (!in.finish()) refuse(in.problem());
  require_sane(state, list);
  return state;
}

}  // namespace fmu
