// The commands that fit a part of a car to one drive: mass, aero, suspension, brakes, engine.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/json_text.h"
#include "base/one_line.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "commands.h"
#include "identify/measure.h"
#include "map_report.h"
#include "recording/table.h"

namespace crgidentify {
namespace {

using nlohmann::ordered_json;

std::pair<double, double> stretch_of(const std::string& text) {
  std::pair<double, double> out;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, out.first);
  if (first.ec == std::errc() && first.ptr != end && *first.ptr == ',') {
    const auto second = std::from_chars(first.ptr + 1, end, out.second);
    if (second.ec == std::errc() && second.ptr == end && out.first < out.second) return out;
  }
  throw command::UsageError("--engine-off " + text + ": wanted BEGIN,END in seconds, like 12.5,30");
}

std::string left_out(const identify::DriveWindows& w) {
  return rows_said({{w.slow, "rows too slow"},
                    {w.off_road, "rows with a wheel beside the road"},
                    {w.on_kerbs, "rows near kerbs"},
                    {w.short_of_rows, "rows in windows that lack rows"}});
}

std::string table(const identify::DriveFit& fit) {
  std::string out = fmt::format("{:26} {:>10} {:>11} {:>11} {:>9} {:>10}\n", "", "found",
                                "90 % within", "of that log", "file", "unit");
  for (const identify::Found& f : fit.found) {
    const std::string stated = std::isfinite(f.stated) ? fmt::format("{:.5g}", f.stated) : "-";
    if (f.unseen.empty())
      out += fmt::format("{:26} {:10.5g} {:11.2g} {:11.2g} {:>9} {:>10}\n", f.name, f.value,
                         f.within, f.sd > 0.0 ? f.within * f.sd_drive / f.sd : 0.0, stated, f.unit);
    else
      out += fmt::format("{:26} not observable: {}\n", f.name, f.unseen);
  }
  return out;
}

identify::MeasureRequest request_of(const DriveCommand& command) {
  identify::MeasureRequest out = command.request;
  out.body_axes = command.accelerations == "body";
  for (const std::string& text : command.engine_off) out.engine_off_s.push_back(stretch_of(text));
  return out;
}

ordered_json drive_json(const identify::Measured& measured) {
  const identify::DriveWindows& w = measured.windows;
  const identify::DriveFit& fit = measured.fit;
  ordered_json out{{"windows", fit.windows},
                   {"places", fit.blocks},
                   {"rows", w.rows},
                   {"slow", w.slow},
                   {"off_road", w.off_road},
                   {"on_kerbs", w.on_kerbs},
                   {"short_of_rows", w.short_of_rows},
                   {"found", ordered_json::array()},
                   {"not_observable", ordered_json::array()},
                   {"remarks", fit.remarks},
                   {"doubts", fit.doubts}};
  for (const identify::Found& f : fit.found) {
    if (!f.unseen.empty()) {
      out["not_observable"].push_back({{"name", f.name}, {"why", f.unseen}});
      continue;
    }
    ordered_json one{{"name", f.name},        {"unit", f.unit}, {"value", f.value},
                     {"within_90", f.within}, {"sd", f.sd},     {"sd_of_drive", f.sd_drive}};
    if (std::isfinite(f.stated)) one["vehicle_file"] = f.stated;
    out["found"].push_back(std::move(one));
  }
  return out;
}

/// The first lines of a sheet: log, its sum, fuel.
std::string drive_header(const DriveCommand& command, const identify::ReadDrive& drive) {
  const char* const from = drive.fuel_from == identify::FuelFrom::kLog
                               ? "the recorded fuel's median"
                           : drive.fuel_from == identify::FuelFrom::kRequest ? "--fuel-kg"
                                                                             : kFuelAssumed;
  return fmt::format("# {} from {} (sha256 {})\n# with {:.4g} kg of fuel, by {}\n", command.part,
                     base::one_line(command.request.recording_path),
                     base::sha256_of_file(command.request.recording_path), drive.fuel_kg, from);
}

std::string drive_text(const identify::Measured& measured) {
  const identify::DriveFit& fit = measured.fit;
  std::string out = fmt::format("{} windows at {} places, of {} rows{}\n", fit.windows, fit.blocks,
                                measured.windows.rows, left_out(measured.windows)) +
                    table(fit);
  for (const std::string& remark : fit.remarks) out += fmt::format("- {}\n", remark);
  return out;
}

/// Whether a file is asked for and nothing speaks against it; says so where something does.
bool may_write(const std::vector<std::string>& doubts, const std::string& path,
               Terminal& terminal) {
  if (path.empty()) return false;
  if (!doubts.empty())
    terminal.remark(fmt::format("{}: not written: {}", base::one_line(path), doubts.front()));
  return doubts.empty();
}

/// Every place with its interval and the seconds in each gear; torques empty where unseen.
std::string engine_cells_csv(const identify::EngineFit& fit) {
  constexpr double kEmpty = std::numeric_limits<double>::quiet_NaN();
  recording::Table out;
  const auto add = [&](std::string name, auto value) {
    std::vector<double> column;
    for (const identify::MapPlace& cell : fit.places) column.push_back(value(cell));
    out.add(std::move(name), std::move(column));
  };
  add("engine_radps", [](const identify::MapPlace& c) { return c.x; });
  add("throttle", [](const identify::MapPlace& c) { return c.y; });
  add("torque_nm", [](const identify::MapPlace& c) { return c.seen() ? c.value : kEmpty; });
  add("within_90_nm", [](const identify::MapPlace& c) { return c.seen() ? c.within : kEmpty; });
  add("vehicle_file_nm", [](const identify::MapPlace& c) { return c.stated; });
  for (std::size_t g = 0; !fit.places.empty() && g < fit.places.front().seconds.size(); ++g)
    add(fmt::format("gear_{}_s", g + 1), [g](const identify::MapPlace& c) { return c.seconds[g]; });
  return recording::format_table(out, 6);
}

/// Lines for a vehicle file, none where no place of the map was seen; `map_name` is the map's file.
std::string engine_yaml(const identify::EngineFit& fit, const std::string& map_name) {
  const auto unseen = std::ranges::count_if(fit.places, std::not_fn(&identify::MapPlace::seen));
  const bool is_map = fit.any_seen();
  std::string out =
      is_map ? fmt::format(
                   "# Lines for a vehicle file. {} of {} places of the map were not seen: "
                   "they follow their\n# neighbours and the stated map's shape.\n",
                   unseen, fit.places.size())
             : "# No lines for a vehicle file: no place of the map was seen.\n";
  for (const std::string& doubt : fit.fit.doubts)
    out += fmt::format("# not to be used: {}\n", base::one_line(doubt));
  for (const identify::Found& f : fit.fit.found)
    out += f.unseen.empty()
               ? fmt::format("# {}: {:.4f}, 90 % within {:.4f}\n", f.name, f.value, f.within)
               : fmt::format("# {} not observable: {}\n", f.name, base::one_line(f.unseen));
  if (!is_map) return out;
  return out +
         fmt::format("maps:\n  engine_torque_nm: {}\nparameters:\n  engine.torque: 1\n", map_name);
}

void write_engine(const DriveCommand& command, const std::string& header,
                  const identify::EngineFit& fit, Terminal& terminal) {
  if (command.out_path == "-") {  // standard output takes one file
    base::write_file(command.out_path, header + engine_yaml(fit, "engine_map.csv"));
    if (fit.any_seen())
      terminal.remark(
          "engine_map.csv, which these lines name, is not written: -o FILE.yaml writes both");
    return;
  }
  const std::filesystem::path yaml(command.out_path);
  const std::string stem = yaml.stem().string(), beside = (yaml.parent_path() / stem).string();
  if (fit.any_seen()) base::write_file(beside + "_map.csv", map_csv(kEngineWords, fit));
  base::write_file(beside + "_places.csv", engine_cells_csv(fit));
  base::write_file(command.out_path, header + engine_yaml(fit, stem + "_map.csv"));
}

/// Writes the map of the pads where it is asked for and seen; the lines of the sheet beside it.
std::string write_pads(const DriveCommand& command, const identify::Measured& measured,
                       Terminal& terminal) {
  const std::string path = base::one_line(command.pad_map_path);
  if (!measured.pads->any_seen()) {
    if (!path.empty())
      terminal.remark(fmt::format(
          "{}: not written: no place of a map of the pads' friction is observable", path));
    return measured.sheet;
  }
  if (!may_write(measured.fit.doubts, command.pad_map_path, terminal)) return measured.sheet;
  base::write_file(command.pad_map_path, map_csv(kPadWords, *measured.pads));
  return fmt::format(
      "# the brakes' torque is in the map of the pads; for the vehicle file:\n# maps:\n#   "
      "pad_friction: {}\n",
      path);
}

}  // namespace

int drive_part(const DriveCommand& command, Terminal& terminal) {
  const identify::MeasureRequest request = request_of(command);
  terminal.start("reading");
  const identify::ReadDrive drive(request);
  terminal.start("fitting");
  const identify::Measured measured = identify::measure(command.part, drive);
  const std::vector<std::string>& doubts = measured.fit.doubts;
  const std::string header = drive_header(command, drive);
  std::string lines = measured.sheet;
  if (measured.pads) lines = write_pads(command, measured, terminal) + measured.discs_sheet;
  std::string sheet = header;
  for (const std::string& doubt : doubts)
    sheet += fmt::format("# not to be used: {}\n", base::one_line(doubt));
  if (doubts.empty()) sheet += lines;
  if (may_write(doubts, command.out_path, terminal)) {
    if (measured.engine)
      write_engine(command, header, *measured.engine, terminal);
    else
      base::write_file(command.out_path, sheet);
  }
  const identify::FoundMap* const map = measured.engine ? &*measured.engine
                                        : measured.pads ? &*measured.pads
                                                        : nullptr;
  const MapWords& words = measured.engine ? kEngineWords : kPadWords;
  if (map != nullptr && !command.plots_path.empty())
    base::write_file(command.plots_path,
                     map_page(words, *map, measured.fit,
                              fmt::format("{} from {}", measured.engine ? "Engine" : "Brakes",
                                          base::one_line(command.request.recording_path))));
  if (terminal.json) {
    ordered_json json = drive_json(measured);
    json["fuel_kg"] = drive.fuel_kg;
    if (measured.engine) json["map"] = map_json(words, *map);
    if (measured.pads) {
      json["pad_map"] = map_json(words, *map);
      json["pad_map"]["remarks"] = map->fit.remarks;
    }
    terminal.print(base::json_text(json));
  } else {
    terminal.print(sheet + drive_text(measured) + (map ? map_table(words, *map) : std::string()));
  }
  return doubts.empty() ? kOk : command::kNotValid;
}

}  // namespace crgidentify
