#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <set>

#include "base/output_set.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "crg/file.h"
#include "explain/kept.h"
#include "explain/page.h"
#include "run_steps.h"
#include "vehicle/error.h"

namespace crgexplain {
namespace {

/// Every file that is read. A name may be empty: that input was not given.
std::vector<std::string> inputs_of(const RunCommand& command, const vehicle::Vehicle& car) {
  std::vector<std::string> out = car.read_files;
  out.insert(out.end(), {command.track_path, command.friction_path, command.mapping_path});
  out.insert(out.end(), command.recording_paths.begin(), command.recording_paths.end());
  return out;
}

/// Everything that the result depends on: this program, names and bytes of all inputs, options.
std::string hash_of(const RunCommand& command, const std::vector<std::string>& inputs) {
  std::string all = base::sha256_of_program();
  for (const std::string& input : inputs)
    if (!input.empty()) all += fmt::format("\n{} {}", input, base::sha256_of_file(input));
  all +=
      fmt::format("\n{} {} {}", command.nulls, fmt::join(command.hold_out, ","), command.fuel_kg);
  return base::sha256(all);
}

explain::ExplainOptions options_of(const RunCommand& command, Terminal& terminal) {
  explain::ExplainOptions out;
  out.hold_out.insert(command.hold_out.begin(), command.hold_out.end());
  out.threads = command.threads;
  out.nulls = command.nulls;
  out.progress = terminal.progress();
  return out;
}

/// Laps that are held out exist, and some stay to find something with.
void want_laps(const std::vector<int>& hold_out, const std::vector<explain::Signals>& logs) {
  int laps = 0;
  for (const explain::Signals& log : logs) laps += log.lap.empty() ? 1 : log.lap.back() + 1;
  const std::set<int> held(hold_out.begin(), hold_out.end());
  if (!held.empty() && *held.rbegin() >= laps)
    throw vehicle::Error(fmt::format(
        "--hold-out {}: no such lap; these recordings have laps 0 to {}, begun ones too",
        *held.rbegin(), laps - 1));
  if (static_cast<int>(held.size()) == laps)
    throw vehicle::Error(
        fmt::format("--hold-out {}: all laps that there are; leave some to find something with",
                    fmt::join(held, ",")));
}

}  // namespace

int run(const RunCommand& command, Terminal& terminal) {
  const vehicle::Vehicle car = read_car(command);
  const std::vector<std::string> inputs = inputs_of(command, car);
  refuse_to_overwrite(inputs, command.out_path);
  const Road road = read_road(command.track_path, command.friction_path);
  const Recordings recordings = read_recordings(command, road.surface, car);
  want_laps(command.hold_out, recordings.logs);
  const base::FolderLock lock(command.out_path, "crgexplain run");

  const Stages stages(command.out_path, hash_of(command, inputs));
  if (const auto taken = stages.taken_up(); !taken.empty())
    terminal.remark(
        fmt::format("goes on where a run was stopped; finished: {}", fmt::join(taken, ", ")));
  const auto find = [&] {
    return explain::explain({recordings.logs, recordings.all(), recordings.read, road.surface, car},
                            options_of(command, terminal));
  };
  auto findings = stages.get<explain::Findings>("relations", find, explain::findings_from_bytes,
                                                [](const auto& f) { return explain::to_bytes(f); });
  findings.remarks.insert(findings.remarks.begin(), recordings.notes.begin(),
                          recordings.notes.end());

  // From here on until the end no verdict lies beside corrected inputs of another run.
  for (const char* name : {"findings.json", "report.html"})
    std::filesystem::remove(std::filesystem::path(command.out_path) / name);
  const bool drive = !findings.findings.empty() && !command.skip_simulation;
  if (!findings.findings.empty() && command.skip_simulation)
    findings.remarks.emplace_back(
        "--skip-simulation: whether the whole simulated car is better with what was found was not "
        "tried");
  const Corrected corrected =
      drive ? use_what_helps(command, road, car, recordings, stages, terminal.progress(), findings)
            : write_corrected(command, command.out_path, road, car, recordings, findings);

  const std::string title = fmt::format("Simulation and recording: {} on {}", car.name,
                                        std::filesystem::path(command.track_path).stem().string());
  const std::string json = explain::findings_json(findings);
  base::write_file(command.out_path + "/findings.json", json);
  base::write_file(command.out_path + "/report.html",
                   explain::findings_page(findings, recordings.logs, title));
  stages.done();
  if (terminal.json)
    terminal.print(json);
  else
    print_result(command, recordings, findings, corrected, terminal);
  return kOk;
}

}  // namespace crgexplain
