// Writes a trial: what the simulation is given, the recording, and the truth in a folder of its
// own.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <utility>

#include "drive.h"
#include "ride.h"

namespace trials {

struct Trial {
  std::string name, kind;  ///< folder; class of the truth file
  int id = 0;
  Track track;
  Variant truth;              ///< with its effects
  std::vector<double> sizes;  ///< of the effects, in standard deviations
  TruthCar nominal;           ///< what the stated car is made from
  double off = 0.04;          ///< how wrong the stated car is
  Style style;
  double hz = 50;
  std::vector<std::string> alike;
  std::optional<Track> stated_track;  ///< the road as the simulation has it, where it differs
  std::optional<Ride> ride;           ///< suspension, wheel loads, body rates in the log
  bool commands = false;              ///< of the driver, logged by the names that they have
  std::optional<Discs> discs;         ///< disc temperatures in the log
  bool accelerometers = true;         ///< in the log
  std::vector<std::string> without;   ///< terms that the stated car has switched off
  std::optional<Style> experiment;    ///< a second drive: experiment.csv
  std::vector<std::pair<std::string, double>> notes;  ///< further figures of the truth
};

inline constexpr std::size_t kShortestDrive = 4000;  ///< rows; what is shorter left the road

/// An effect in a truth file.
nlohmann::ordered_json truth_of(const Effect& effect, double size_sd);

/// Drives and writes; false (and a line on stderr) when the car left the road. `dice` goes on.
bool write_trial(const Trial& trial, Random& dice, const std::filesystem::path& folder);

}  // namespace trials
