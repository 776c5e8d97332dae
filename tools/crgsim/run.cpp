#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "commands.h"
#include "sim/run_unit.h"
#include "sim/unpack.h"

namespace crgsim {
namespace {

std::optional<double> said(double value) {
  return value == RunCommand::kFromTheUnit ? std::nullopt : std::optional(value);
}

}  // namespace

std::string refused_remark(const std::string& refused) {
  return "the unit's sandbox refused it " + refused + "; --trust runs it without";
}

int run(const RunCommand& command, Terminal& terminal) {
  sim::UnitRunOptions options;
  if (!command.road_path.empty() && !sim::is_vehicle_file(command.unit_path))
    throw command::UsageError(
        "--road is of a vehicle file; a unit has its road in it, and --set road=FILE is another");
  if (!command.road_path.empty())
    options.starts.emplace_back("road", std::filesystem::absolute(command.road_path).string());
  for (const std::string& start : command.starts)
    options.starts.push_back(assignment("--set", start));
  options.inputs = read_inputs(command.inputs_path);
  options.record = command.record;
  for (const std::string& opponent : command.opponents)
    options.opponents.push_back(sim::read_opponent(opponent));
  options.start_s = said(command.start_s);
  options.stop_s = said(command.stop_s);
  options.step_s = said(command.step_s);
  options.every = command.every;
  options.limits = command.limits;
  base::GrowingFile table(command.out_path);
  say_killed(table, terminal);
  options.keep_row = rows_into(table);
  terminal.start("steps");
  const sim::UnitRun run = sim::run_unit(command.unit_path, options, terminal.progress());
  terminal.progress_done();
  for (const std::string& line : run.log) terminal.remark("the unit says: " + line);
  if (!run.refused.empty()) terminal.remark(refused_remark(run.refused));
  table.finish();
  const double reached_s = run.reached_s;
  if (run.ended_early)
    terminal.remark(fmt::format("the unit ended the run at {:g} s of {:g}", reached_s, run.stop_s));
  if (terminal.json)
    terminal.print(base::json_text(nlohmann::ordered_json{{"rows", run.rows()},
                                                          {"columns", run.columns.size()},
                                                          {"step_s", run.step_s},
                                                          {"reached_s", reached_s},
                                                          {"ended_early", run.ended_early},
                                                          {"unit_says", run.log},
                                                          {"file", command.out_path}}));
  else
    terminal.print(fmt::format("{} rows of {} columns, to {:g} s in steps of {:g} s\n", run.rows(),
                               run.columns.size(), reached_s, run.step_s));
  if (run.not_finite.empty()) return kOk;
  terminal.remark(run.not_finite + ", the first value that is no finite number");
  return command::kNotValid;
}

}  // namespace crgsim
