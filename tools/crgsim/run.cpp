#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/csv.h"
#include "base/error.h"
#include "base/json_text.h"
#include "base/read_file.h"
#include "base/write_file.h"
#include "commands.h"
#include "sim/run_unit.h"

namespace crgsim {
namespace {

std::optional<double> said(double value) {
  return value == RunCommand::kFromTheUnit ? std::nullopt : std::optional(value);
}

/// Names of the columns but time_s. Names of variables may hold commas only where quoted.
std::vector<std::string> columns_of(const std::string& path) {
  base::want_regular_file(path);
  std::ifstream file(path);
  std::string header;
  std::getline(file, header);
  std::vector<std::string> names(1);
  bool quoted = false;
  for (const char c : header) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      names.emplace_back();
    else if (c != '\r')
      names.back() += c;
  }
  std::erase(names, "time_s");
  return names;
}

sim::UnitInputs read_inputs(const std::string& path) {
  sim::UnitInputs inputs;
  if (path.empty()) return inputs;
  inputs.names = columns_of(path);
  std::vector<std::string> wanted{"time_s"};
  wanted.insert(wanted.end(), inputs.names.begin(), inputs.names.end());
  const base::CsvTable table = base::read_csv(path, wanted);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double time_s = table.value(row, 0);
    if (!std::isfinite(time_s) || (row > 0 && time_s <= inputs.time_s.back()))
      throw base::Error(fmt::format("{}:{}: time_s is {}; later than the row before wanted", path,
                                    table.line[row], time_s));
    inputs.time_s.push_back(time_s);
    for (std::size_t k = 1; k < table.columns; ++k) {
      if (!std::isfinite(table.value(row, k)))
        throw base::Error(fmt::format("{}:{}: no value of {}; fill it in", path, table.line[row],
                                      inputs.names[k - 1]));
      inputs.values.push_back(table.value(row, k));
    }
  }
  return inputs;
}

}  // namespace

int run(const RunCommand& command, Terminal& terminal) {
  sim::UnitRunOptions options;
  for (const std::string& start : command.starts)
    options.starts.push_back(assignment("--set", start));
  options.inputs = read_inputs(command.inputs_path);
  options.record = command.record;
  for (const std::string& opponent : command.opponents)
    options.opponents.push_back(sim::read_opponent(opponent));
  options.start_s = said(command.start_s);
  options.stop_s = said(command.stop_s);
  options.step_s = said(command.step_s);
  terminal.start("steps");
  const sim::UnitRun run = sim::run_unit(command.unit_path, options, terminal.progress());
  terminal.progress_done();
  for (const std::string& line : run.log) terminal.remark("the unit says: " + line);
  base::write_file(command.out_path, csv_of(run.columns, run.values));
  const double reached_s = run.values[(run.rows() - 1) * run.columns.size()];
  if (run.ended_early)
    terminal.remark(fmt::format("the unit ended the run at {:g} s of {:g}", reached_s, run.stop_s));
  if (terminal.json)
    terminal.print(base::json_text(nlohmann::ordered_json{{"rows", run.rows()},
                                                          {"columns", run.columns.size()},
                                                          {"step_s", run.step_s},
                                                          {"reached_s", reached_s},
                                                          {"ended_early", run.ended_early},
                                                          {"file", command.out_path}}));
  else
    terminal.print(fmt::format("{} rows of {} columns, to {:g} s in steps of {:g} s\n", run.rows(),
                               run.columns.size(), reached_s, run.step_s));
  return kOk;
}

}  // namespace crgsim
