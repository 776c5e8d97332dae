// A run of a Functional Mock-up Unit from its start to a stop, in a process of its own.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/progress.h"
#include "sim/opponents.h"
#include "sim/unit_description.h"
#include "sim/unit_limits.h"

namespace sim {

/// Inputs, and tunable parameters, over time. Floats run straight between rows, other types are
/// held from a row on; before the first row and after the last its values stand.
struct UnitInputs {
  std::vector<std::string> names;  ///< of variables; name[1], name[2] ... of an array
  std::vector<double> time_s;      ///< rising
  std::vector<double> values;      ///< row after row
};

/// Takes a row of a table as it comes, and the table's columns.
using KeepRow =
    std::function<void(const std::vector<std::string>& columns, std::span<const double> row)>;

struct UnitRunOptions {
  /// Before initialisation, in this order: variable and value as text ("true" and "false" are
  /// booleans); an array's values separated by blanks.
  std::vector<std::pair<std::string, std::string>> starts;
  UnitInputs inputs;
  std::vector<OpponentDrive> opponents;  ///< above the inputs; [0] is the unit's first
  std::vector<std::string> record;       ///< variables; empty: all outputs that are no text
  std::optional<double> start_s, stop_s, step_s;  ///< else of the unit's default experiment
  std::size_t every = 1;  ///< steps from one row to the next; the last step has a row too
  KeepRow keep_row;       ///< gets the rows as they come, which are not kept then
  UnitLimits limits;      ///< not of a vehicle file, whose car is trusted
};

/// Of what a unit says, so many lines are kept.
constexpr std::size_t kMostLogLines = 1000;

struct UnitRun {
  std::vector<std::string> columns;  ///< time_s first
  /// Row after row: after initialisation and after each step; empty with keep_row.
  std::vector<double> values;
  std::size_t row_count = 0;
  std::vector<std::string> log;  ///< of the unit, at most kMostLogLines
  double step_s = 0.0, stop_s = 0.0, reached_s = 0.0;
  bool ended_early = false;  ///< by the unit's wish
  std::string refused;       ///< calls that its sandbox refused the unit; empty: none
  std::string not_finite;    ///< the first recorded value that is no finite number; empty: none

  std::size_t rows() const { return row_count; }
};

/// Loads, initialises and steps the unit. Without anything said it runs as its default experiment
/// says, else 10 s in steps of 1 ms. What the unit prints goes to standard error. Throws Error on
/// what UnpackedUnit, read_unit_description and Unit refuse, on names that it does not have, more
/// than 100 M values that are kept, and when the unit crashes or crosses a limit, with the time
/// that it had reached. Nothing of it is left behind, also when this process is killed.
UnitRun run_unit(const std::string& path, const UnitRunOptions& options,
                 const base::Progress& progress = {});

}  // namespace sim
