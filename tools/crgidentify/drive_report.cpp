#include "drive_report.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/json_text.h"
#include "base/one_line.h"
#include "base/sha256.h"
#include "base/write_file.h"

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
  std::string out;
  const auto say = [&](std::size_t rows, const char* why) {
    if (rows > 0) out += fmt::format("; {} rows {}", rows, why);
  };
  say(w.slow, "too slow");
  say(w.off_road, "with a wheel beside the road");
  say(w.on_kerbs, "near kerbs");
  say(w.short_of_rows, "in windows that lack rows");
  return out;
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

}  // namespace

identify::MeasureRequest request_of(const DriveCommand& command) {
  identify::MeasureRequest out;
  out.recording_path = command.recording_path;
  out.vehicle_path = command.vehicle_path;
  out.setup_path = command.setup_path;
  out.road_path = command.track_path;
  out.mapping_path = command.mapping_path;
  out.settings = command.settings;
  out.body_axes = command.accelerations == "body";
  out.fuel_kg = command.fuel_kg;
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

std::string drive_header(const DriveCommand& command, const identify::ReadDrive& drive,
                         const std::string& what) {
  const char* const from = drive.fuel_from == identify::FuelFrom::kLog
                               ? "the recorded fuel's median"
                           : drive.fuel_from == identify::FuelFrom::kRequest ? "--fuel-kg"
                                                                             : kFuelAssumed;
  return fmt::format("# {} from {} (sha256 {})\n# with {:.4g} kg of fuel, by {}\n", what,
                     base::one_line(command.recording_path),
                     base::sha256_of_file(command.recording_path), drive.fuel_kg, from);
}

std::string drive_text(const identify::Measured& measured) {
  const identify::DriveFit& fit = measured.fit;
  std::string out = fmt::format("{} windows at {} places, of {} rows{}\n", fit.windows, fit.blocks,
                                measured.windows.rows, left_out(measured.windows)) +
                    table(fit);
  for (const std::string& remark : fit.remarks) out += fmt::format("- {}\n", remark);
  return out;
}

bool may_write(const std::vector<std::string>& doubts, const std::string& path,
               Terminal& terminal) {
  if (path.empty()) return false;
  if (!doubts.empty())
    terminal.remark(fmt::format("{}: not written: {}", base::one_line(path), doubts.front()));
  return doubts.empty();
}

int tell(const DriveCommand& command, const identify::ReadDrive& drive,
         const identify::Measured& measured, const std::string& what, const std::string& lines,
         Terminal& terminal, const Beside& beside) {
  const std::vector<std::string>& doubts = measured.fit.doubts;
  std::string sheet = drive_header(command, drive, what);
  for (const std::string& doubt : doubts)
    sheet += fmt::format("# not to be used: {}\n", base::one_line(doubt));
  if (doubts.empty()) sheet += lines;
  if (may_write(doubts, command.out_path, terminal)) base::write_file(command.out_path, sheet);
  if (terminal.json) {
    ordered_json json = drive_json(measured);
    json["fuel_kg"] = drive.fuel_kg;
    if (!beside.key.empty()) json[beside.key] = beside.json;
    terminal.print(base::json_text(json));
  } else {
    terminal.print(sheet + drive_text(measured) + beside.text);
  }
  return doubts.empty() ? kOk : command::kNotValid;
}

}  // namespace crgidentify
