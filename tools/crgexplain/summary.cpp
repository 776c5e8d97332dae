#include "explain/summary.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "command/version.h"
#include "commands.h"
#include "explain/read_inputs.h"
#include "vehicle/error.h"

namespace crgexplain {
namespace {

std::string hash_of_all(const std::vector<std::string>& paths) {
  std::string all;
  for (const std::string& path : paths)
    if (!path.empty()) all += base::sha256_of_file(path) + "\n";
  return base::sha256(all);
}

void name(explain::DriveSummary& out, const RunCommand& in, const vehicle::Vehicle& car) {
  out.program = std::string("crgexplain ") + command::version();
  out.road_sha256 = hash_of_all({in.track_path, in.friction_path});
  out.car_sha256 = hash_of_all(car.read_files);
  out.recording_sha256 = hash_of_all(in.recording_paths);
  out.settings_sha256 = base::sha256(fmt::format(
      "{} {}", in.mapping_path.empty() ? "" : base::sha256_of_file(in.mapping_path), in.fuel_kg));
  out.car = car.name;
  out.recording = in.recording_paths.front();
  if (in.recording_paths.size() > 1)
    out.recording += fmt::format(" and {} more", in.recording_paths.size() - 1);
}

}  // namespace

int summary(const RunCommand& in, Terminal& terminal) {
  const vehicle::Vehicle car = explain::read_car(in);
  std::vector<std::string> inputs = car.read_files;
  inputs.insert(inputs.end(), {in.track_path, in.friction_path, in.mapping_path});
  inputs.insert(inputs.end(), in.recording_paths.begin(), in.recording_paths.end());
  for (const std::string& input : inputs) {
    std::error_code none;
    if (!input.empty() && std::filesystem::equivalent(input, in.out_path, none))
      throw vehicle::Error(
          fmt::format("{}: is read, and -o would overwrite it; choose another name", in.out_path));
  }
  const explain::StatedRoad road = explain::read_road(in.track_path, in.friction_path);
  const explain::Recordings recordings = explain::read_recordings(in, road.surface, car);
  explain::ExplainOptions options;
  options.threads = in.threads;
  options.progress = terminal.progress();
  explain::DriveSummary out = explain::summarise(recordings.logs, car, options);
  name(out, in, car);
  const std::string bytes = explain::to_bytes(out);
  base::write_file(in.out_path, bytes);
  std::vector<std::string> notes = recordings.notes;
  for (const explain::Signals& log : recordings.logs)
    notes.insert(notes.end(), log.remarks.begin(), log.remarks.end());
  if (terminal.json) {
    terminal.print(
        base::json_text(nlohmann::ordered_json{{"summary", in.out_path},
                                               {"bytes", bytes.size()},
                                               {"car", out.car},
                                               {"laps", out.laps},
                                               {"driven_s", out.driven_s},
                                               {"knots", out.knots},
                                               {"unknowns", out.columns.size()},
                                               {"rows_without_forces", out.by_sensors.rows},
                                               {"rows_with_forces", out.by_forces.rows},
                                               {"remarks", notes}}));
    return kOk;
  }
  for (const std::string& note : notes) terminal.print(fmt::format("  {}\n", one_line(note)));
  terminal.print(fmt::format(
      "{}: {} laps of {}, {:.0f} measurements without and {:.0f} with forces, {:.0f} kB\n",
      one_line(in.out_path), out.laps, one_line(out.car), out.by_sensors.rows, out.by_forces.rows,
      1e-3 * static_cast<double>(bytes.size())));
  return kOk;
}

}  // namespace crgexplain
