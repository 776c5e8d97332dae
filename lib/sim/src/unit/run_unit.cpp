#include "sim/run_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <set>
#include <sstream>

#include "apart.h"
#include "base/error.h"
#include "base/one_line.h"
#include "base/read_file.h"
#include "input_writer.h"
#include "opponent_inputs.h"
#include "sim/unit.h"
#include "sim/unpack.h"
#include "unit_places.h"

namespace sim {
namespace {

constexpr double kUsualStop_s = 10.0, kUsualStep_s = 0.001;
constexpr std::size_t kMostRunValues = 100'000'000;

/// What is said between the processes: 'C' names of columns, 'R' a row, 'L' a line of the log, 'Z'
/// one at the run's end, 'X' that the unit wants to end.
void work(const UnpackedUnit& files, const UnitDescription& description,
          const UnitRunOptions& options, double start_s, double stop_s, double step_s,
          const std::vector<const UnitVariable*>& recorded, const std::function<void(Words)>& say,
          Watch* watch) {
  Unit unit(
      files, description,
      [&](const std::string& line, bool closes) {
        say({closes ? 'Z' : 'L', line});
      },
      watch);
  for (const auto& [name, text] : options.starts) set_start(unit, files.path(), name, text);
  InputWriter inputs(options.inputs, unit.description(), files.path());
  OpponentInputs opponents(options.opponents, 0, unit.description(), files.path());
  inputs.write(unit, start_s);
  unit.initialise(start_s, stop_s);
  std::vector<double> row;
  const auto record = [&](double time_s) {
    row.assign(1, time_s);
    for (const UnitVariable* const variable : recorded) {
      const std::size_t at = row.size();
      row.resize(at + variable->size);
      unit.get(*variable, std::span(row).subspan(at));
    }
    say({'R', {reinterpret_cast<const char*>(row.data()), row.size() * sizeof(double)}});
  };
  record(start_s);
  const auto steps = static_cast<std::size_t>(std::llround((stop_s - start_s) / step_s));
  for (std::size_t k = 0; k < steps; ++k) {
    const double time_s = start_s + static_cast<double>(k) * step_s;
    inputs.write(unit, time_s);
    opponents.write(unit, time_s);
    const bool goes_on = unit.step(time_s, step_s);
    if ((k + 1) % options.every == 0 || k + 1 == steps || !goes_on)
      record(start_s + static_cast<double>(k + 1) * step_s);
    if (!goes_on) return say({'X', {}});
  }
}

void want_each_once(const std::vector<std::string>& columns, const std::string& path) {
  std::set<std::string_view> names;
  for (const std::string& column : columns)
    if (!names.insert(column).second)
      throw base::Error(fmt::format(
          "{}: the record would have two columns {}; time_s is its own, and each variable wanted "
          "once (--record)",
          path, column));
}

}  // namespace

UnitRun run_unit(const std::string& path, const UnitRunOptions& options,
                 const base::Progress& progress) {
  const std::string road_path = road_of(options.starts);
  const UnitDescription description =
      read_unit_description(model_description_of(path, road_path), path);
  const double start_s = options.start_s.value_or(description.start_s.value_or(0.0));
  UnitRun run;
  run.stop_s = options.stop_s.value_or(description.stop_s.value_or(start_s + kUsualStop_s));
  run.step_s = options.step_s.value_or(description.step_s.value_or(kUsualStep_s));
  if (!(run.step_s > 0.0) || !(run.stop_s >= start_s))
    throw base::Error(
        fmt::format("{}: from {} to {} s in steps of {} s; a stop after the start "
                    "and a step above 0 wanted (--stop-s, --step-s)",
                    path, start_s, run.stop_s, run.step_s));

  std::vector<const UnitVariable*> recorded;
  if (options.record.empty()) {
    for (const UnitVariable& variable : description.variables)
      if (variable.is_output() && is_number(variable)) recorded.push_back(&variable);
  } else {
    for (const std::string& name : options.record) {
      recorded.push_back(&known(description, path, name));
      if (!is_number(*recorded.back()))
        throw base::Error(fmt::format("{}: {} holds no numbers", path, name));
    }
  }
  run.columns.emplace_back("time_s");
  for (const UnitVariable* const variable : recorded)
    for (std::size_t i = 0; i < variable->size; ++i)
      run.columns.push_back(variable->size == 1 ? variable->name
                                                : fmt::format("{}[{}]", variable->name, i + 1));
  want_each_once(run.columns, path);
  const double rows =
      (run.stop_s - start_s) / run.step_s / static_cast<double>(options.every) + 1.0;
  if (!options.keep_row && !(rows * static_cast<double>(run.columns.size()) <= kMostRunValues))
    throw base::Error(
        fmt::format("{}: {:.3g} rows of {} columns; record fewer (--record), or "
                    "shorter, or in larger steps",
                    path, rows, run.columns.size()));

  const UnpackedUnit files(path, road_path);
  std::string refused, closing;
  std::vector<double> row(run.columns.size());
  ApartPlace place{files.folder(), options.limits};
  place.limits.trusted = place.limits.trusted || is_vehicle_file(path);
  const Ending ending = run_apart(
      place,
      [&](const std::function<void(Words)>& say, Watch* watch) {
        work(files, description, options, start_s, run.stop_s, run.step_s, recorded, say, watch);
      },
      [&] {
        std::error_code ignored;
        std::filesystem::remove_all(files.folder(), ignored);
      },
      [&](Words words) {
        if (words.kind == 'E') refused = base::visible(words.bytes);
        if (words.kind == 'X') run.ended_early = true;
        if (words.kind == 'Z') closing = base::visible(words.bytes);
        if ((words.kind == 'L' || words.kind == 'Z') && run.log.size() < kMostLogLines)
          run.log.push_back(base::visible(words.bytes));
        if (words.kind != 'R' || words.bytes.size() != run.columns.size() * sizeof(double)) return;
        std::memcpy(row.data(), words.bytes.data(), words.bytes.size());
        ++run.row_count;
        run.reached_s = row[0];
        if (run.not_finite.empty()) run.not_finite = not_finite_of(run.columns, row, row[0]);
        if (options.keep_row)
          options.keep_row(run.columns, row);
        else
          run.values.insert(run.values.end(), row.begin(), row.end());
        if (progress) progress("steps", static_cast<double>(run.rows()) / rows);
      });
  if (refused.empty())
    refused = crash_of(path, ending, run.rows() == 0 ? std::nullopt : std::optional(run.reached_s));
  if (!refused.empty() && !closing.empty()) refused += "; the unit says: " + closing;
  if (!refused.empty()) throw base::Error(refused + refused_to(ending));
  run.refused = ending.refused;
  return run;
}

}  // namespace sim
