// What a unit that is being stepped and the program that drives it say to each other: datagrams, in
// a JSON and in a binary form. docs/crgsim.md describes both.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/sights.h"

namespace sim {

constexpr std::size_t kMostSavedStates = 16, kLongestStateName = 64;
constexpr std::size_t kLongestMessage = 60'000;  ///< bytes; what a datagram takes everywhere

/// Values for the commands of a run, in its order; NaN where the message says nothing of one.
struct CommandMessage {
  std::uint32_t sequence = 0;  ///< counted by whoever commands; a smaller one is old
  std::vector<double> values;
  bool ends = false;           ///< the run shall end
  std::optional<bool> pauses;  ///< in real time: the unit shall stand still, or go on
  /// The unit shall begin anew at 0 s, with these starts besides those of the run: name and number.
  bool resets = false;
  std::vector<std::pair<std::string, double>> starts;
  /// With resets: not at 0 s, but in the state that was saved under this name; empty: at 0 s.
  std::string state;
  /// The state in which the command finds the unit is kept under this name; empty: it is not.
  std::string save;
  /// The way that is going to be taken, at most kMostPlanPoints; nothing: not told.
  std::optional<std::vector<PlanPoint>> plan;
  bool is_binary = false;
};

struct MeasurementMessage {
  std::uint32_t sequence = 0;  ///< of the last command that was taken
  double time_s = 0.0;
  bool is_safe = false;    ///< the safe input acts, because commands stayed out
  bool was_reset = false;  ///< the unit began anew since the measurement before
  std::vector<double> values;
  std::string clipped = {};  ///< what of the last command was taken at its bound; empty: nothing
  std::string parked = {};   ///< why the unit stands still since an error of it; empty: it does not
};

/// What is said of a run besides its numbers: of a command of which nothing was taken ("refused"),
/// one that was taken at a bound ("clipped"), an error after which the unit stands ("parked").
struct Remark {
  std::string kind, text;
  std::optional<std::uint32_t> sequence;  ///< of the command; nothing where it did not say one
  double time_s = 0.0;
  std::uint64_t resets = 0;  ///< before it, in this run
};

/// Empty, or why a message with such names of states is none. A name has 1 to kLongestStateName
/// bytes; `save` and `state` are empty where nothing is saved or gone back to.
std::string wrong_with_states(const CommandMessage& message);

/// Reads either form: what begins with '{' is JSON. Nothing, and the reason in `why`, for what is
/// longer than kLongestMessage, broken, or holds unknown names or numbers that are not finite.
std::optional<CommandMessage> read_command(std::string_view bytes,
                                           const std::vector<std::string>& names, std::string& why);

bool is_binary(std::string_view bytes);  ///< by its first bytes

/// The sequence number of a message in either form that is no command; nothing where it has none.
std::optional<std::uint32_t> sequence_of(std::string_view bytes);

/// One line of JSON, or of the binary form what a refused command is answered by.
std::string write_remark(const Remark& remark, bool as_binary);

std::string write_measurement(const MeasurementMessage& message,
                              const std::vector<std::string>& names, bool as_binary);

}  // namespace sim
