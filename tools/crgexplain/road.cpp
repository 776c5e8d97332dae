#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <utility>

#include "base/json_text.h"
#include "base/write_file.h"
#include "commands.h"
#include "crg/file.h"
#include "explain/mapping.h"
#include "recording/log_table.h"
#include "recording/recording.h"
#include "road/driven_road.h"
#include "road/reckon.h"
#include "road/track_crg.h"
#include "vehicle/error.h"

namespace crgexplain {
namespace {

namespace fs = std::filesystem;

/// Without a mapping: canonical columns as they are, those of others as `map` would propose.
recording::Mapping mapping_of(const RoadCommand& command, const recording::Table& log) {
  if (!command.mapping_path.empty()) return recording::read_mapping(command.mapping_path);
  if (log.find("time_s") != nullptr &&
      (log.find("vx_mps") != nullptr || (log.find("x_m") != nullptr && log.find("y_m") != nullptr)))
    return {};
  explain::Mapping proposed = explain::propose_mapping(log, command.log_path);
  if (!proposed.missing.empty())
    throw vehicle::Error(fmt::format("{}: {}; give a log or a mapping that has it",
                                     command.log_path, proposed.missing.front()));
  return proposed;
}

const std::vector<double>& wanted(const recording::Recording& drive, const RoadCommand& command,
                                  const char* channel) {
  const std::vector<double>* const values = drive.table.find(channel);
  if (values == nullptr)
    throw vehicle::Error(
        fmt::format("{}: no {}; a road wants x_m and y_m, latitude and longitude, or vx_mps and "
                    "yaw_rate_radps: name their columns in a mapping",
                    command.log_path, channel));
  return *values;
}

/// Turns places so that they are driven in the direction of the logged heading, where it follows
/// them: crgexplain run compares the two.
void turn_to_heading(const recording::Table& log, road::ReckonedPlaces& places) {
  const std::vector<double>* const yaw = log.find("yaw_rad");
  std::complex<double> sum = 0.0;
  double count = 0.0;
  for (std::size_t i = 1; yaw != nullptr && i < places.x_m.size(); ++i) {
    const std::complex<double> step(places.x_m[i] - places.x_m[i - 1],
                                    places.y_m[i] - places.y_m[i - 1]);
    if (!(std::abs(step) > 0.0) || !std::isfinite((*yaw)[i])) continue;
    sum += step / std::abs(step) * std::polar(1.0, -(*yaw)[i]);
    count += 1.0;
  }
  if (!(std::abs(sum) > 0.9 * count)) return;
  for (std::size_t i = 0; i < places.x_m.size(); ++i) {
    const std::complex<double> turned =
        std::complex<double>(places.x_m[i], places.y_m[i]) * std::conj(sum) / std::abs(sum);
    places.x_m[i] = turned.real();
    places.y_m[i] = turned.imag();
  }
}

/// How the car turns on the map, rad/s: by its heading where that follows the gyro, which turns
/// less on a road that leans.
std::vector<double> turning_of(const recording::Table& log, const std::vector<double>& time_s,
                               const std::vector<double>& yaw_rate_radps) {
  constexpr double kFollows = 0.25;
  const std::vector<double>* const yaw = log.find("yaw_rad");
  if (yaw == nullptr) return yaw_rate_radps;
  std::vector<double> out(yaw->size(), std::numeric_limits<double>::quiet_NaN());
  double both = 0.0, gyro = 0.0;
  for (std::size_t i = 1; i < out.size(); ++i) {
    out[i] = std::remainder((*yaw)[i] - (*yaw)[i - 1], 2.0 * std::numbers::pi) /
             (time_s[i] - time_s[i - 1]);
    const double r = yaw_rate_radps[i];
    if (std::isfinite(out[i] * r)) both += out[i] * r, gyro += r * r;
  }
  return std::abs(both / gyro - 1.0) < kFollows ? out : yaw_rate_radps;
}

/// Places by speed and turning, as columns of the recording.
std::optional<road::ReckonedPlaces> add_places(const RoadCommand& command,
                                               recording::Recording& drive) {
  if (drive.table.find("x_m") != nullptr && drive.table.find("y_m") != nullptr) return std::nullopt;
  const std::vector<double>* const left = drive.table.find("vy_mps");
  const std::vector<double>& time_s = wanted(drive, command, "time_s");
  road::ReckonedPlaces places =
      road::reckon_places(command.log_path, time_s, wanted(drive, command, "vx_mps"),
                          turning_of(drive.table, time_s, wanted(drive, command, "yaw_rate_radps")),
                          left != nullptr ? *left : std::vector<double>{});
  turn_to_heading(drive.table, places);
  drive.table.add("x_m", places.x_m);
  drive.table.add("y_m", places.y_m);
  return places;
}

/// Of reckoned places those of whole laps: before and after nothing says how the car stood.
road::DrivenPlaces places_of(const RoadCommand& command, const recording::Recording& drive,
                             const std::optional<road::ReckonedPlaces>& reckoned) {
  const auto rows = [&](const char* channel) {
    const std::vector<double>& all = *drive.table.find(channel);
    const auto at = [&](std::size_t row) { return all.begin() + static_cast<std::ptrdiff_t>(row); };
    return reckoned ? std::vector<double>(at(reckoned->begin), at(reckoned->end)) : all;
  };
  return {command.log_path, rows("x_m"), rows("y_m")};
}

std::string log_with_places(const std::string& out_path) {
  return fs::path(out_path).replace_extension().string() + "_log.csv";
}

void refuse_overwriting(const RoadCommand& command) {
  for (const std::string& out : {command.out_path, log_with_places(command.out_path)})
    for (const std::string& in : {command.log_path, command.mapping_path}) {
      std::error_code none;
      if (!in.empty() && fs::equivalent(in, out, none))
        throw vehicle::Error(
            fmt::format("{}: is read, and -o would overwrite it; choose another name", out));
    }
}

std::string how_closed(const road::ReckonedPlaces& places) {
  if (places.laps == 0)
    return "places are reckoned from speed and turning; no lap was found, so the road is open";
  return fmt::format(
      "places are reckoned from speed and turning: {} laps of {:.1f} m, each closed by turning "
      "it by up to {:.2f} degrees and moving its end by up to {:.1f} m",
      places.laps, places.lap_m, places.turn_rad * 57.29577951308232, places.gap_m);
}

std::string next_step(const RoadCommand& command, bool reckoned, bool mapped) {
  std::string out;
  std::string log = command.log_path, mapping = command.mapping_path;
  if (reckoned) {
    log = log_with_places(command.out_path), mapping.clear();
  } else if (mapping.empty() && mapped) {
    mapping = "mapping.yaml";
    out = fmt::format("next     crgexplain map {} -o {}\n", shell_word(log), mapping);
  }
  return out +
         fmt::format("next     crgexplain run --road {} --car vehicle.yaml --log {}{} -o out\n",
                     shell_word(command.out_path), shell_word(log),
                     mapping.empty() ? "" : " --mapping " + shell_word(mapping));
}

}  // namespace

int flat_road(const RoadCommand& command, Terminal& terminal) {
  refuse_overwriting(command);
  const recording::Table log = recording::read_log_table(command.log_path);
  const recording::Mapping mapping = mapping_of(command, log);
  recording::Recording drive = recording::make_recording(log, command.log_path, mapping);
  const std::optional<road::ReckonedPlaces> reckoned = add_places(command, drive);
  if (reckoned && command.out_path == "-")
    throw vehicle::Error(fmt::format(
        "{}: its places are reckoned, and the log with them lies beside the road; name a file in "
        "place of -",
        command.log_path));
  road::DrivenRoadReport report;
  road::EdgeRoad flat = road::road_under(places_of(command, drive, reckoned), &report);
  std::vector<std::string> remarks;
  if (reckoned) remarks.push_back(how_closed(*reckoned));
  if (!reckoned && report.edges.closed)
    remarks.push_back(
        fmt::format("the lap is closed by moving its end across by up to {:.2f} m", report.gap_m));
  if (report.leaps > 0)
    remarks.push_back(fmt::format("{} places leap from those beside them: left out", report.leaps));
  if (report.beside_share > 0.01)
    remarks.push_back(fmt::format("{:.0f} % of the places lie beside this road or against it",
                                  100.0 * report.beside_share));
  constexpr std::size_t kMost = 3;
  const std::vector<std::string>& more = report.edges.remarks;
  for (std::size_t k = 0; k < std::min(kMost, more.size()); ++k) remarks.push_back(more[k]);
  if (more.size() > kMost)
    remarks.push_back(fmt::format("and {} remarks more of this kind", more.size() - kMost));
  crg::Crg file = road::track_crg(flat.line, std::move(flat.sampled.grid));
  file.comment = {"flat road under a drive: heights and edges were not measured"};
  const std::string with_places = log_with_places(command.out_path);
  if (reckoned) base::write_file(with_places, recording::format_table(drive.table, 17));
  base::write_file(command.out_path, crg::to_bytes(file, crg::Format::KRBI));
  if (terminal.json) {
    nlohmann::ordered_json out{
        {"road", command.out_path},    {"closed", report.edges.closed},
        {"length_m", report.length_m}, {"left_m", report.left_m},
        {"right_m", report.right_m},   {"places", reckoned ? "reckoned" : "logged"},
        {"remarks", remarks}};
    if (reckoned) {
      out["log"] = with_places;
      out["laps"] = reckoned->laps;
      out["turn_rad"] = reckoned->turn_rad;
      out["gap_m"] = reckoned->gap_m;
    }
    terminal.print(base::json_text(out));
    return kOk;
  }
  terminal.print(
      fmt::format("{}: {} flat road of {:.1f} m, {:.1f} m to the left and {:.1f} m to the "
                  "right of the lap driven\n",
                  one_line(command.out_path), report.edges.closed ? "closed" : "open",
                  report.length_m, report.left_m, report.right_m));
  for (const std::string& remark : remarks) terminal.print(fmt::format("  {}\n", one_line(remark)));
  if (reckoned) terminal.print(fmt::format("log      {}\n", one_line(with_places)));
  if (drive.table.find("time_s") == nullptr || drive.table.find("vx_mps") == nullptr)
    terminal.print("crgexplain run wants time_s and vx_mps too, which this log has not\n");
  else
    terminal.print(
        next_step(command, reckoned.has_value(), mapping.path.empty() && !mapping.columns.empty()));
  return kOk;
}

}  // namespace crgexplain
