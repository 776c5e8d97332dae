#include <fmt/format.h>

#include <cmath>

#include "explain/fuel.h"
#include "explain/kept.h"
#include "explain/simulate.h"
#include "run_steps.h"

namespace explain {
namespace {

/// Places in the list of findings, in order.
using Chosen = std::vector<std::size_t>;

Findings only(const Findings& all, const Chosen& chosen) {
  Findings out = all;
  out.findings.clear();
  for (const std::size_t k : chosen) out.findings.push_back(all.findings[k]);
  return out;
}

bool moves_the_car(const ExplainRequest& request, const CorrectedFiles& now) {
  return now.track_path != request.track_path || now.friction_path != request.friction_path ||
         now.vehicle_path != request.vehicle_path;
}

/// What drives once before and after.
struct Trial {
  const ExplainRequest& request;
  const StatedRoad& road;
  const vehicle::Vehicle& car;
  const Recordings& recordings;
  const Stages& stages;
  const Findings& findings;
  KnownSide& before_side;  ///< as stated: the same in all
  const base::Progress& progress;
};

/// The columns that the corrected car is driven with: fuel that was given stays, fuel that was
/// found is added to the tables.
Mapping driven_columns(const Trial& trial, const vehicle::Vehicle& improved,
                       const CorrectedFiles& corrected, std::vector<recording::Table>& tables) {
  const Recordings& recordings = trial.recordings;
  const Mapping recorded = corrected.mapping ? *corrected.mapping : recordings.recorded;
  Mapping out = recorded;
  if (trial.request.fuel_kg > 0) out.columns.push_back(recordings.read.columns.back());
  if (corrected.fuel_kg > trial.request.fuel_kg)
    for (std::size_t k = 0; k < recordings.logs.size(); ++k) {
      out = recorded;
      add_fuel(tables[k], out, recordings.logs[k], improved, corrected.fuel_kg);
    }
  return out;
}

constexpr const char* kDriving = "the whole simulated car, before and after";

struct Outcome {
  SimulationCheck check;
  std::string why_not;  ///< empty: use them
};

/// The whole simulated car with the stated inputs, and with those that these findings correct.
Outcome drive(const Trial& trial, const Chosen& chosen) {
  const ExplainRequest& request = trial.request;
  const CorrectedFiles corrected =
      write_corrected(request, trial.stages.scratch(), trial.road, trial.car, trial.recordings,
                      only(trial.findings, chosen));
  std::string of;
  if (chosen.size() < trial.findings.findings.size())
    for (const std::size_t k : chosen) of += fmt::format(" {}", k + 1);
  const auto refit = [&](bool after, const std::function<RefittedCar()>& make) {
    return trial.stages.get<RefittedCar>(after ? "refit after" + of : "refit before", make,
                                         car_from_bytes, [](const auto& c) { return to_bytes(c); });
  };
  const auto check = [&] {
    const vehicle::Vehicle improved = vehicle::read_vehicle(corrected.vehicle_path);
    const StatedRoad changed = read_road(corrected.track_path, corrected.friction_path);
    std::vector<recording::Table> tables = trial.recordings.tables;
    const Mapping columns = driven_columns(trial, improved, corrected, tables);
    std::vector<RecordedLog> logs;
    for (std::size_t k = 0; k < tables.size(); ++k)
      logs.push_back({&tables[k], &trial.recordings.logs[k]});
    const bool same_car = corrected.vehicle_path == request.vehicle_path,
               same_road = corrected.track_path == request.track_path &&
                           corrected.friction_path == request.friction_path;
    return check_simulation(logs, {&trial.car, &trial.road.surface, trial.recordings.read},
                            {same_car ? &trial.car : &improved,
                             same_road ? &trial.road.surface : &changed.surface, columns},
                            {{request.hold_out.begin(), request.hold_out.end()},
                             refit,
                             [&] {
                               if (trial.progress) trial.progress(kDriving, 0.0);
                             }},
                            trial.before_side);
  };
  Outcome out;
  out.check = trial.stages.get<SimulationCheck>("whole car" + of, check, check_from_bytes,
                                                [](const auto& c) { return to_bytes(c); });
  out.why_not = why_not_used(out.check, moves_the_car(request, corrected));
  if (!out.why_not.empty()) out.why_not += "; --skip-simulation writes it untried";
  return out;
}

/// All together if the whole car is the better for it; else those with which it is one by one, less
/// the last as long as together they are not. The others are told why not.
Chosen what_helps(const Trial& trial, Findings& findings, Outcome& outcome) {
  Chosen chosen;
  for (std::size_t k = 0; k < findings.findings.size(); ++k)
    if (findings.findings[k].not_used.empty()) chosen.push_back(k);
  outcome = drive(trial, chosen);
  if (chosen.empty() || outcome.why_not.empty()) return chosen;
  if (chosen.size() == 1) {
    findings.findings[chosen.front()].not_used = outcome.why_not;
    return {};
  }
  const Outcome together = outcome;
  Chosen helping;
  for (const std::size_t k : chosen) {
    if (trial.progress)
      trial.progress("the whole simulated car, finding by finding",
                     static_cast<double>(k) / static_cast<double>(chosen.size()));
    const Outcome alone = drive(trial, {k});
    if (alone.why_not.empty())
      helping.push_back(k);
    else
      findings.findings[k].not_used = alone.why_not;
  }
  for (; !helping.empty(); helping.pop_back()) {
    outcome = drive(trial, helping);
    if (outcome.why_not.empty()) return helping;
    findings.findings[helping.back()].not_used = "with the findings before it: " + outcome.why_not;
  }
  outcome = together;
  return {};
}

}  // namespace

CorrectedFiles use_what_helps(const ExplainRequest& request, const StatedRoad& road,
                              const vehicle::Vehicle& car, const Recordings& recordings,
                              const Stages& stages, const base::Progress& progress,
                              Findings& findings) {
  if (progress) progress(kDriving, 0.0);
  Outcome outcome;
  const Findings all = findings;
  KnownSide before_side;
  const Chosen used = what_helps(
      {request, road, car, recordings, stages, all, before_side, progress}, findings, outcome);
  const SimulationCheck& check = outcome.check;
  for (Finding& f : findings.findings)
    f.held_out.insert(f.held_out.end(), check.held_out.begin(), check.held_out.end());
  findings.remarks.insert(findings.remarks.end(), check.remarks.begin(), check.remarks.end());
  findings.driven = check.driven;
  findings.recorded_lap_s = check.recorded_lap_s;
  if (std::isfinite(check.lap_before_s)) findings.simulated_lap_before_s = check.lap_before_s;
  if (std::isfinite(check.lap_after_s)) findings.simulated_lap_after_s = check.lap_after_s;
  const Findings chosen = only(findings, used);
  CorrectedFiles corrected =
      write_corrected(request, request.out_path, road, car, recordings, chosen);
  if (corrected.vehicle_path != request.vehicle_path && check.after &&
      !check.after->changed.empty())
    write_car(*corrected_vehicle(request.vehicle_path, car, chosen, recordings.logs, &*check.after),
              request.out_path);
  return corrected;
}

}  // namespace explain
