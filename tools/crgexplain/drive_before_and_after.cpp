#include <cmath>

#include "explain/fuel.h"
#include "explain/kept.h"
#include "explain/simulate.h"
#include "run_steps.h"

namespace crgexplain {
namespace {

/// The columns that the corrected car is driven with: fuel that was given stays, fuel that was
/// found is added.
explain::Mapping driven_columns(const RunCommand& command, const vehicle::Vehicle& improved,
                                const Corrected& corrected, Recordings& recordings) {
  const explain::Mapping recorded = corrected.mapping ? *corrected.mapping : recordings.recorded;
  explain::Mapping out = recorded;
  if (command.fuel_kg > 0) out.columns.push_back(recordings.read.columns.back());
  if (corrected.fuel_kg > command.fuel_kg)
    for (std::size_t k = 0; k < recordings.logs.size(); ++k) {
      out = recorded;
      explain::add_fuel(recordings.tables[k], out, recordings.logs[k], improved, corrected.fuel_kg);
    }
  return out;
}

}  // namespace

void drive_before_and_after(const RunCommand& command, const Road& road,
                            const vehicle::Vehicle& car, const Corrected& corrected,
                            Recordings& recordings, const Stages& stages,
                            const base::Progress& progress, explain::Findings& findings) {
  progress("the whole simulated car, before and after", 0.0);
  const vehicle::Vehicle improved = vehicle::read_vehicle(corrected.vehicle_path);
  const Road changed = read_road(corrected.track_path, corrected.friction_path);
  const explain::Mapping columns = driven_columns(command, improved, corrected, recordings);
  const auto refit = [&](bool after, const std::function<explain::RefittedCar()>& make) {
    return stages.get<explain::RefittedCar>(after ? "refit after" : "refit before", make,
                                            explain::car_from_bytes,
                                            [](const auto& c) { return explain::to_bytes(c); });
  };
  const explain::SimulationCheck check =
      explain::check_simulation(recordings.all(), {&car, &road.surface, recordings.read},
                                {&improved, &changed.surface, columns},
                                {command.hold_out.begin(), command.hold_out.end()}, refit);
  for (explain::Finding& f : findings.findings)
    f.held_out.insert(f.held_out.end(), check.held_out.begin(), check.held_out.end());
  findings.remarks.insert(findings.remarks.end(), check.remarks.begin(), check.remarks.end());
  findings.driven = check.driven;
  findings.recorded_lap_s = check.recorded_lap_s;
  if (std::isfinite(check.lap_before_s)) findings.simulated_lap_before_s = check.lap_before_s;
  if (std::isfinite(check.lap_after_s)) findings.simulated_lap_after_s = check.lap_after_s;
  if (corrected.vehicle_path != command.vehicle_path && check.after &&
      !check.after->changed.empty())
    write_car(*explain::corrected_vehicle(command.vehicle_path, car, findings, recordings.logs,
                                          &*check.after),
              command.out_path);
}

}  // namespace crgexplain
