#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "base/json_text.h"
#include "base/output_set.h"
#include "commands.h"
#include "served_run.h"
#include "sim/serve_unit.h"

namespace crgsim {
namespace {

/// What a user ought to know of a car's run.
void remark(const std::string& name, const sim::ServeRun& run, std::size_t cars,
            Terminal& terminal) {
  for (const std::string& one : remarks_of(run)) terminal.remark(name + ": " + one);
  if (!run.failed.empty()) terminal.remark(name + ": " + run.failed);
  if (run.counts.silent)
    terminal.remark(name + ": no command came any more, and its safe input acted to the end");
  if (cars == 1 || !run.failed.empty()) return;
  if (run.counts.others_seen == 0)
    terminal.remark(name + ": its unit has no input.opponent and does not feel the others");
  if (!run.counts.tells_its_place)
    terminal.remark(name + ": its unit has no car.x and car.y, and the others do not feel it");
}

}  // namespace

int race(const RaceCommand& command, Terminal& terminal) {
  want_one_connection(command);
  if (command.sights && command.out_path.empty())
    throw command::UsageError("--sights is kept in the folder of -o, and none was named");
  const std::vector<RaceCar> cars = read_race(command);
  std::optional<base::OutputSet> out;
  if (!command.out_path.empty()) out.emplace(command.out_path, "crgsim race");
  std::deque<base::GrowingFile> files;
  std::vector<std::string> names;
  const auto file = [&](const std::string& name) -> base::GrowingFile& {
    names.push_back(name);
    say_killed(files.emplace_back(out->path(name)), terminal);
    return files.back();
  };
  std::vector<sim::ServedUnit> units;
  for (const auto& [name, serve] : cars) {
    units.push_back({name, serve.unit_path, options_of(serve)});
    sim::ServeOptions& options = units.back().options;
    options.keep_row = [](const auto&, const auto&) {};
    if (!out) continue;
    options.keep_row = rows_into(file(name + ".csv"));
    options.keep_remark = lines_into(file(name + ".remarks.jsonl"));
    if (!command.sights) continue;
    options.keep_sight = lines_into(file(name + ".jsonl"));
    files.back().append("");
  }
  terminal.start("waiting for commands");
  const std::vector<sim::ServeRun> runs = sim::serve_units(units, terminal.progress());
  terminal.progress_done();
  for (base::GrowingFile& one : files) one.finish();
  nlohmann::ordered_json json;
  std::string text;
  bool all_drove = true;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const std::string& name = cars[k].name;
    remark(name, runs[k], runs.size(), terminal);
    json["cars"][name] = json_of(runs[k]);
    text += name + ": " + summary_of(runs[k], command.step_s);
    all_drove = all_drove && is_sound(runs[k]);
  }
  std::erase_if(names,
                [&](const std::string& name) { return !std::filesystem::exists(out->path(name)); });
  if (out) out->commit("race", names);
  terminal.print(terminal.json ? base::json_text(json) : text);
  return all_drove ? kOk : command::kNotValid;
}

}  // namespace crgsim
