#include "drive_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/one_line.h"
#include "base/sha256.h"
#include "base/statistics.h"
#include "base/write_file.h"
#include "identify/short_gaps.h"
#include "vehicle/road_file.h"

namespace crgidentify {
namespace {

using nlohmann::ordered_json;

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

ordered_json drive_json(const identify::DriveWindows& w, const identify::DriveFit& fit) {
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

std::string drive_header(const DriveCommand& command, const ReadDrive& drive,
                         const std::string& what) {
  return fmt::format("# {} from {} (sha256 {})\n# with {:.4g} kg of fuel, by {}\n", what,
                     base::one_line(command.recording_path),
                     base::sha256_of_file(command.recording_path), drive.fuel_kg, drive.fuel_from);
}

std::string drive_text(const identify::DriveWindows& windows, const identify::DriveFit& fit) {
  std::string out = fmt::format("{} windows at {} places, of {} rows{}\n", fit.windows, fit.blocks,
                                windows.rows, left_out(windows)) +
                    table(fit);
  for (const std::string& remark : fit.remarks) out += fmt::format("- {}\n", remark);
  return out;
}

ReadDrive::ReadDrive(const DriveCommand& command)
    : vehicle(vehicle::read_vehicle(command.vehicle_path, command.setup_path, command.settings)),
      car(make_car(vehicle.files, vehicle.parameters, vehicle.terms, vehicle.contact)) {
  recording::Mapping mapping;
  if (!command.mapping_path.empty()) mapping = recording::read_mapping(command.mapping_path);
  recording =
      identify::without_short_gaps(recording::read_recording(command.recording_path, mapping));
  if (!command.track_path.empty())
    road.emplace(std::move(vehicle::read_road(command.track_path, {}).surface));
  options.imu_ahead_m = mapping.imu_ahead_m;
  options.imu_yaw_rad = mapping.imu_yaw_rad;
  options.body_axes = command.accelerations == "body";
  fuel_kg = command.fuel_kg.value_or(kAssumedFuel_kg);
  fuel_from = command.fuel_kg ? "--fuel-kg" : kFuelAssumed;
  std::vector<double> recorded;
  if (const auto* fuel = recording.table.find("fuel_kg"); fuel != nullptr)
    std::copy_if(fuel->begin(), fuel->end(), std::back_inserter(recorded),
                 [](double v) { return std::isfinite(v); });
  if (recorded.empty()) return;
  fuel_kg = base::median(recorded);
  fuel_from = "the recorded fuel's median";
}

identify::DriveWindows ReadDrive::windows() const {
  return identify::drive_windows(car, road ? &*road : nullptr, recording, options);
}

std::optional<identify::DriveFit> mass_where_seen(const ReadDrive& drive,
                                                  identify::DriveWindows& windows) {
  if (!windows.loads || !windows.accelerations) return std::nullopt;
  identify::MassFitOptions options;
  options.fuel_kg = drive.fuel_kg;
  options.body_axes = drive.options.body_axes;
  auto fit = identify::try_fit_mass(drive.car, drive.vehicle.prior, windows, options);
  if (fit && fit->doubts.empty() && fit->at("mass_kg").unseen.empty()) return *std::move(fit);
  if (fit) windows.doubts.insert(windows.doubts.end(), fit->doubts.begin(), fit->doubts.end());
  return std::nullopt;  // the vehicle file's mass stands in, and is named
}

std::vector<std::string> all_doubts(const identify::DriveWindows& windows,
                                    const identify::DriveFit& fit) {
  std::vector<std::string> out = windows.doubts;
  out.insert(out.end(), fit.doubts.begin(), fit.doubts.end());
  return out;
}

bool may_write(const std::vector<std::string>& doubts, const std::string& path,
               Terminal& terminal) {
  if (path.empty()) return false;
  if (!doubts.empty())
    terminal.remark(fmt::format("{}: not written: {}", base::one_line(path), doubts.front()));
  return doubts.empty();
}

int tell(const DriveCommand& command, const ReadDrive& drive, const identify::DriveWindows& windows,
         identify::DriveFit fit, const std::string& what, const std::string& lines,
         Terminal& terminal, const Beside& beside) {
  fit.doubts = all_doubts(windows, fit);
  std::string sheet = drive_header(command, drive, what);
  for (const std::string& doubt : fit.doubts)
    sheet += fmt::format("# not to be used: {}\n", base::one_line(doubt));
  if (fit.doubts.empty()) sheet += lines;
  if (may_write(fit.doubts, command.out_path, terminal)) base::write_file(command.out_path, sheet);
  if (terminal.json) {
    ordered_json json = drive_json(windows, fit);
    json["fuel_kg"] = drive.fuel_kg;
    if (!beside.key.empty()) json[beside.key] = beside.json;
    terminal.print(base::json_text(json));
  } else {
    terminal.print(sheet + drive_text(windows, fit) + beside.text);
  }
  return fit.doubts.empty() ? kOk : command::kNotValid;
}

}  // namespace crgidentify
