#include "vehicle/replay.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/json_text.h"
#include "base/write_file.h"
#include "load_car.h"
#include "vehicle/error.h"
#include "write_telemetry.h"

namespace crgdrive {
namespace {

/// What was wrong with the recording, in sentences.
void print_notes(const recording::Recording& r, Terminal& terminal) {
  const double length_s = r.table.find("time_s")->back() - r.table.find("time_s")->front();
  terminal.print(fmt::format(
      "recording: {} rows over {:.2f} s, one every {:.4f} s, {} stretches without a gap\n",
      r.table.rows(), length_s, r.step_s, r.stretches.size()));
  const std::size_t trouble =
      r.rows_repeated + r.rows_backwards + r.rows_without_time + r.clock_resets;
  if (trouble > 0)
    terminal.print(fmt::format(
        "  clock: {} rows repeat a time, {} come late, {} without time (all left out), {} resets; "
        "first at t = {:.3f} s\n",
        r.rows_repeated, r.rows_backwards, r.rows_without_time, r.clock_resets, r.first_trouble_s));
  if (r.stretches.size() > 1)
    terminal.print(
        fmt::format("  longest gap {:.3f} s: no window goes over a gap\n", r.longest_gap_s));
  if (r.cells_not_numbers > 0)
    terminal.print(fmt::format("  {} cells are no numbers: taken as empty\n", r.cells_not_numbers));
  for (const auto& [channel, share] : r.held)
    terminal.print(fmt::format("  {}: {:.0f} % of the samples repeat the one before\n", channel,
                               100.0 * share));
  for (const std::string& channel : r.constant)
    terminal.print(fmt::format("  {}: constant\n", channel));
}

void print_result(const vehicle::ReplayResult& result, bool held, Terminal& terminal) {
  for (const std::string& sentence : result.driven_by)
    terminal.print(fmt::format("{}\n", sentence));
  terminal.print(
      fmt::format("{} windows; {} left out standing, {} stretches too short, {} ended early\n",
                  result.windows, result.standing, result.too_short, result.problems.size()));
  for (std::size_t i = 0; i < std::min<std::size_t>(5, result.problems.size()); ++i)
    terminal.print(fmt::format("  {}\n", result.problems[i]));
  if (held)
    terminal.print(fmt::format(
        "push that held the speed: mean {:.1f} N, root mean square {:.1f} N, at most {:.1f} N\n",
        result.hold_mean_n, result.hold_rms_n, result.hold_most_n));
  for (const std::string& warning : {result.swing_warning, result.ledge_warning})
    if (!warning.empty()) terminal.print(warning + "\n");
  terminal.print(fmt::format("{:<20} {:>8} {:>12} {:>12} {:>12} {:>12}\n", "channel", "samples",
                             "max", "RMSE", "hold RMSE", "trend RMSE"));
  for (const vehicle::ChannelError& e : result.errors)
    terminal.print(fmt::format("{:<20} {:>8} {:>12.5g} {:>12.5g} {:>12.5g} {:>12.5g}\n", e.channel,
                               e.samples, e.max, e.rmse, e.hold_rmse, e.trend_rmse));
}

nlohmann::ordered_json replay_numbers(const recording::Recording& recording,
                                      const vehicle::ReplayResult& result) {
  nlohmann::ordered_json errors = nlohmann::ordered_json::object();
  for (const vehicle::ChannelError& e : result.errors)
    errors[e.channel] = {{"samples", e.samples},
                         {"max", e.max},
                         {"rmse", e.rmse},
                         {"hold_rmse", e.hold_rmse},
                         {"trend_rmse", e.trend_rmse}};
  return {{"rows", recording.table.rows()},
          {"step_s", recording.step_s},
          {"stretches", recording.stretches.size()},
          {"driven_by", result.driven_by},
          {"windows", result.windows},
          {"standing", result.standing},
          {"too_short", result.too_short},
          {"problems", result.problems},
          {"hold_mean_n", result.hold_mean_n},
          {"hold_rms_n", result.hold_rms_n},
          {"hold_most_n", result.hold_most_n},
          {"step_swing", result.step_swing},
          {"swing_warning", result.swing_warning},
          {"ledge_warning", result.ledge_warning},
          {"errors", errors}};
}

/// A folder with errors and telemetry, or the telemetry alone as MCAP.
void write_result(const std::string& path, const std::string& from,
                  const vehicle::ReplayResult& result) {
  if (is_mcap(path)) return write_telemetry(path, from, result.telemetry);
  std::filesystem::create_directories(path);
  const std::filesystem::path folder(path);
  base::write_file((folder / "errors.csv").string(), from + vehicle::format_errors(result));
  write_telemetry((folder / "replay.csv").string(), from, result.telemetry, 17);
}

}  // namespace

int replay(const ReplayCommand& command, Terminal& terminal) {
  const vehicle::Vehicle v = load_vehicle(command.car);
  const auto car = vehicle::make_car(v.files, v.parameters, v.terms, v.contact);
  const crg::Surface surface = read_road(command.track_path, command.friction_path, terminal);
  recording::Mapping mapping;
  if (!command.mapping_path.empty()) mapping = recording::read_mapping(command.mapping_path);
  const recording::Recording recording = recording::read_recording(command.recording_path, mapping);
  require_on_road(surface, command.track_path, recording.table, command.recording_path);
  if (!terminal.json) print_notes(recording, terminal);
  vehicle::ReplayOptions options;
  options.window_s = command.window_s;
  options.closed_path = command.closed_path;
  options.hold_speed = command.hold_speed;
  options.driver = command.driver;
  options.fuel_kg = command.fuel_kg;
  options.tyre_k = command.tyre_k;
  options.disc_k = command.disc_k;
  options.step = step_options(command.car);
  options.progress = terminal.progress();
  const vehicle::ReplayResult result =
      vehicle::replay(car, vehicle::Road(surface), recording, options);
  if (terminal.json)
    terminal.print(base::json_text(replay_numbers(recording, result)));
  else
    print_result(result, command.hold_speed, terminal);
  if (!command.out_path.empty()) {
    std::vector<std::string> files{command.track_path, command.recording_path};
    if (!command.friction_path.empty()) files.push_back(command.friction_path);
    if (!command.mapping_path.empty()) files.push_back(command.mapping_path);
    const std::string from =
        provenance("replay", v, command.car, files) +
        fmt::format("# start fuel_kg={:g} tyre_k={:g} disc_k={:g} where not recorded\n",
                    command.fuel_kg, command.tyre_k, command.disc_k);
    write_result(command.out_path, from, result);
  }
  if (result.problems.size() == result.windows)
    throw vehicle::Error("no window came to its end; the first: " + result.problems.front());
  return kOk;
}

}  // namespace crgdrive
