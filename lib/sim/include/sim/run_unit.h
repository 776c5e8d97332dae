// A run of a Functional Mock-up Unit from its start to a stop, in a process of its own.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/progress.h"
#include "sim/opponents.h"
#include "sim/unit_description.h"

namespace sim {

/// Inputs, and tunable parameters, over time. Floats run straight between rows, other types are
/// held from a row on; before the first row and after the last its values stand.
struct UnitInputs {
  std::vector<std::string> names;  ///< of variables; name[1], name[2] ... of an array
  std::vector<double> time_s;      ///< rising
  std::vector<double> values;      ///< row after row
};

struct UnitRunOptions {
  /// Before initialisation, in this order: variable and value as text ("true" and "false" are
  /// booleans); an array's values separated by blanks.
  std::vector<std::pair<std::string, std::string>> starts;
  UnitInputs inputs;
  std::vector<OpponentDrive> opponents;  ///< above the inputs; [0] is the unit's first
  std::vector<std::string> record;       ///< variables; empty: all outputs that are no text
  std::optional<double> start_s, stop_s, step_s;  ///< else of the unit's default experiment
};

struct UnitRun {
  std::vector<std::string> columns;  ///< time_s first
  std::vector<double> values;        ///< row after row: after initialisation and after each step
  std::vector<std::string> log;      ///< of the unit, at most 1000 lines
  double step_s = 0.0, stop_s = 0.0;
  bool ended_early = false;  ///< by the unit's wish

  std::size_t rows() const { return columns.empty() ? 0 : values.size() / columns.size(); }
};

/// Loads, initialises and steps the unit. Without anything said it runs as its default experiment
/// says, else 10 s in steps of 1 ms. What the unit prints goes to standard error. Throws Error on
/// what UnpackedUnit, read_unit_description and Unit refuse, on names that it does not have, more
/// than 100 M values, and when the unit crashes, with the time that it had reached. Nothing of it
/// is left behind, also when this process is killed.
UnitRun run_unit(const std::string& path, const UnitRunOptions& options,
                 const base::Progress& progress = {});

}  // namespace sim
