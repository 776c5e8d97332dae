#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <set>

#include "base/output_set.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "crg/file.h"
#include "explain/explain.h"
#include "explain/kept.h"
#include "explain/page.h"
#include "run_steps.h"
#include "vehicle/error.h"

namespace explain {
namespace {

/// Every file that is read. A name may be empty: that input was not given.
std::vector<std::string> inputs_of(const ExplainRequest& request, const vehicle::Vehicle& car) {
  std::vector<std::string> out = car.read_files;
  out.insert(out.end(), {request.track_path, request.friction_path, request.mapping_path});
  out.insert(out.end(), request.recording_paths.begin(), request.recording_paths.end());
  return out;
}

/// Everything that the result depends on: this program, names and bytes of all inputs, options.
std::string hash_of(const ExplainRequest& request, const std::vector<std::string>& inputs) {
  std::string all = base::sha256_of_program();
  for (const std::string& input : inputs)
    if (!input.empty()) all += fmt::format("\n{} {}", input, base::sha256_of_file(input));
  all +=
      fmt::format("\n{} {} {}", request.nulls, fmt::join(request.hold_out, ","), request.fuel_kg);
  return base::sha256(all);
}

/// What the command line refuses as well.
void want_bounds(const ExplainRequest& request) {
  if (request.fuel_kg < 0 || request.fuel_kg > kMostFuelKg)  // what is no number: read_car()
    throw vehicle::Error(
        fmt::format("--fuel-kg {:g} seen, 0 to {:g} wanted", request.fuel_kg, kMostFuelKg));
  if (request.nulls < kLeastNulls || request.nulls > kMostNulls)
    throw vehicle::Error(
        fmt::format("--nulls {} seen, {} to {} wanted", request.nulls, kLeastNulls, kMostNulls));
  for (const int lap : request.hold_out)
    if (lap < 0) throw vehicle::Error(fmt::format("--hold-out {} seen, 0 or more wanted", lap));
  if (request.recording_paths.empty())
    throw vehicle::Error("no recording is given; one log or more is wanted");
}

/// Laps that are held out exist, and some stay to find something with.
void want_laps(const std::vector<int>& hold_out, const std::vector<Signals>& logs) {
  int laps = 0;
  for (const Signals& log : logs) laps += log.lap.empty() ? 1 : log.lap.back() + 1;
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

ExplainedFiles explain_files(const ExplainRequest& request, const base::Progress& progress,
                             const std::function<void(const std::string&)>& remark) {
  want_bounds(request);
  const vehicle::Vehicle car = read_car(request);
  const std::vector<std::string> inputs = inputs_of(request, car);
  refuse_to_overwrite(inputs, request.out_path);
  const StatedRoad road = read_road(request.track_path, request.friction_path);
  const Recordings recordings = read_recordings(request, road.surface, car);
  want_laps(request.hold_out, recordings.logs);
  base::OutputSet outputs(request.out_path, "crgexplain run");
  ExplainRequest staged = request;
  staged.out_path = outputs.staged(".");

  const Stages stages(request.out_path, hash_of(request, inputs));
  if (const auto taken = stages.taken_up(); !taken.empty() && remark)
    remark(fmt::format("goes on where a run was stopped; finished: {}", fmt::join(taken, ", ")));
  const auto find = [&] {
    return explain(
        {recordings.logs, recordings.all(), recordings.read, road.surface, car},
        {.hold_out = {request.hold_out.begin(), request.hold_out.end()},
         .threads = request.threads,
         .nulls = request.nulls,
         .progress = progress,
         .kept = {[&](const auto& name, auto& bytes) { return stages.load_part(name, bytes); },
                  [&](const auto& name, const auto& bytes) { stages.keep_part(name, bytes); }}});
  };
  ExplainedFiles out;
  Findings& findings = out.findings;
  findings = stages.get<Findings>("relations", find, findings_from_bytes,
                                  [](const auto& f) { return to_bytes(f); });
  findings.remarks.insert(findings.remarks.begin(), recordings.notes.begin(),
                          recordings.notes.end());

  const bool drive = !findings.findings.empty() && !request.skip_simulation;
  if (!findings.findings.empty() && request.skip_simulation)
    findings.remarks.emplace_back(
        "--skip-simulation: whether the whole simulated car is better with what was found was not "
        "tried");
  Findings used = findings;
  std::erase_if(used.findings, [](const Finding& f) { return !f.not_used.empty(); });
  out.corrected = drive ? use_what_helps(staged, road, car, recordings, stages, progress, findings)
                        : write_corrected(staged, staged.out_path, road, car, recordings, used);
  // Without a logged fuel the stated mass is that of the whole car.
  out.fuel_logged = recordings.logs.front().present[kFuel] && request.fuel_kg == 0;

  const std::string title = fmt::format("Simulation and recording: {} on {}", car.name,
                                        std::filesystem::path(request.track_path).stem().string());
  out.findings_json = findings_json(findings);
  base::write_file(outputs.staged("findings.json"), out.findings_json);
  for (std::string* path : {&out.corrected.track_path, &out.corrected.friction_path,
                            &out.corrected.vehicle_path, &out.corrected.mapping_path})
    if (path->starts_with(staged.out_path))
      *path = outputs.path(std::filesystem::path(*path).filename());
  out.next = next_steps(request, out);
  base::write_file(outputs.staged("report.html"),
                   findings_page(findings, recordings.logs, title, out.next));
  outputs.commit("explain");
  remove_corrected_of_others(request.out_path);
  out.json_path = outputs.path("findings.json"), out.page_path = outputs.path("report.html");
  stages.done();
  return out;
}

}  // namespace explain
