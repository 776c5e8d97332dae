// All that changes in an instance while it runs, and its bytes.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "fmu/variables.h"
#include "vehicle/start.h"

namespace fmu {

enum class Phase { kInstantiated, kInitialising, kStepping, kTerminated, kFailed };

/// Whether a parameter was set, and to something else than its exported start.
inline constexpr signed char kNotGiven = 0, kGiven = 1, kGivenAsExported = 2;

/// A plain value: a copy is a restart point.
struct SavedState {
  Phase phase = Phase::kInstantiated;
  bool started = false;  ///< the simulation holds a car
  /// Time of step 0, if all solver steps up to here had been whole.
  double begin_s = 0.0;
  std::array<std::string, kTextCount> texts;
  std::vector<double> numbers;               ///< by value reference; integers and booleans too
  std::vector<signed char> given;            ///< by value reference: kNotGiven ...
  vehicle::Simulation<double> simulation{};  ///< cursors are left out: they change no answer
  vehicle::RoadTracker::Place place;
};

/// The same state gives the same bytes, on every machine; nothing in them depends on where anything
/// lies in memory. `token` says which unit they belong to.
std::string to_bytes(const SavedState& state, std::string_view token);

/// Throws base::Error where the bytes are no such state, are not as they were written (a checksum
/// of them all), are of another version or unit, have a length
/// other than they say, or hold what no car can have (a gear, a count of steps, a number beyond
/// 1e9 or that is none).
SavedState from_bytes(std::string_view bytes, std::string_view token,
                      const std::vector<Variable>& list);

}  // namespace fmu
