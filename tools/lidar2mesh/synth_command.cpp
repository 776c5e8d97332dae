#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/ending.h"
#include "base/json_text.h"
#include "base/write_file.h"
#include "circuit/circuit.h"
#include "cloud/synth.h"
#include "commands.h"

namespace lidar2mesh {
namespace {

/// What a simulator's mesh of this circuit would be: no kerbs, no bumps, the banking a third of a
/// degree off.
crg::Crg approximation_of(const road::Circuit& circuit) {
  road::CircuitDesign design = circuit.design();
  design.kerbs.clear(), design.bumps.clear();
  for (double& banking : design.banking.value) banking += 0.006;
  return road::truth_crg(road::Circuit(design));
}

}  // namespace

int run_synth(const SynthCommand& command, Terminal& terminal) {
  const bool is_circuit = base::ending_of(command.road) == ".yaml";
  std::optional<road::Circuit> circuit;
  if (is_circuit) circuit = road::read_circuit(command.road);
  const crg::Crg road = circuit ? road::truth_crg(*circuit) : crg::read(command.road);
  cloud::ScanSynthOptions options;
  options.laps = command.laps, options.beams = command.beams, options.azimuths = command.azimuths,
  options.cars = command.cars;
  options.u_begin_m = command.u_begin_m, options.u_end_m = command.u_end_m,
  options.speed_mps = command.speed_mps;
  options.range_noise_m = command.noise_m, options.drift_m_per_100m = command.drift_m,
  options.drift_rad_per_100m = command.drift_rad;
  options.grass_height_m = command.grass_m, options.scenery_every_m = command.scenery_m,
  options.seed = command.seed, options.threads = command.threads,
  options.progress = terminal.progress();
  if (!command.v_m.empty()) options.v_m = command.v_m;
  const cloud::ScanSynthReport made = cloud::synth_scans(road, command.output_dir, options);
  const std::string truth = command.output_dir + "/truth.crg";
  base::write_file(truth, crg::to_bytes(road, crg::Format::KRBI));
  const std::string base = circuit ? command.output_dir + "/base.crg" : "";
  if (circuit) base::write_file(base, crg::to_bytes(approximation_of(*circuit), crg::Format::KRBI));
  if (terminal.json) {
    nlohmann::ordered_json out = head_of(hashed("road", command.road), command.options);
    out.update(nlohmann::ordered_json{{"points", made.points},
                                      {"share_on_cars", made.share_on_cars},
                                      {"share_on_scenery", made.share_on_scenery},
                                      {"scans", made.scan_paths},
                                      {"trajectory", made.trajectory_path},
                                      {"truth_trajectory", made.truth_path},
                                      {"truth_road", truth}});
    if (circuit) out["base_road"] = base;
    terminal.print(base::json_text(out));
    return kOk;
  }
  terminal.print(
      fmt::format("{} points in {} files, {:.1f} % on other cars, {:.1f} % on trees, poles and "
                  "walls\ntrajectory  {}\ntruth       {}, {}\n",
                  made.points, made.scan_paths.size(), 100.0 * made.share_on_cars,
                  100.0 * made.share_on_scenery, made.trajectory_path, made.truth_path, truth));
  if (circuit)
    terminal.print(fmt::format(
        "base        {}: no kerbs, no bumps, banking 0.006 m/m off, for 'map --road'\n", base));
  return kOk;
}

}  // namespace lidar2mesh
