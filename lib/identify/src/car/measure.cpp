#include "identify/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/error.h"
#include "base/statistics.h"
#include "identify/drive_fits.h"
#include "recording/channels.h"
#include "vehicle/road_file.h"
#include "window_fit.h"

namespace identify {
namespace {

/// A fit's options with fuel, axes and, where wheel loads tell it, the mass.
WeighedOptions options_of(const ReadDrive& drive, const std::optional<DriveFit>& weighed = {}) {
  WeighedOptions out{0.0, 0.0, drive.fuel_kg, drive.options.body_axes};
  if (weighed)
    out.mass_kg = weighed->at("mass_kg").value, out.mass_sd_kg = weighed->at("mass_kg").sd;
  return out;
}

/// The fit of the loads; nothing where there are none, or where they do not tell. What makes it
/// doubtful joins the doubts of the windows: all fits lean on the loads.
std::optional<DriveFit> mass_where_seen(const ReadDrive& drive, DriveWindows& windows) {
  if (!windows.loads || !windows.accelerations) return std::nullopt;
  auto fit = fit_mass(drive.car, drive.vehicle.prior, windows, options_of(drive));
  if (fit && fit->doubts.empty() && fit->at("mass_kg").unseen.empty()) return *std::move(fit);
  if (fit) windows.doubts.insert(windows.doubts.end(), fit->doubts.begin(), fit->doubts.end());
  return std::nullopt;  // the vehicle file's mass stands in, and is named
}

void join(DriveFit& fit, const DriveFit& more) {
  fit.found.insert(fit.found.end(), more.found.begin(), more.found.end());
  fit.remarks.insert(fit.remarks.end(), more.remarks.begin(), more.remarks.end());
  fit.doubts.insert(fit.doubts.end(), more.doubts.begin(), more.doubts.end());
}

void measure_mass(const ReadDrive& drive, Measured& out) {
  out.fit = fit_mass(drive.car, drive.vehicle.prior, out.windows, options_of(drive)).or_throw();
  out.sheet = mass_sheet(drive.car, out.fit, drive.fuel_kg);
}

void measure_aero(const ReadDrive& drive, Measured& out) {
  const auto weighed = mass_where_seen(drive, out.windows);
  out.fit = fit_aero(drive.car, drive.vehicle.prior, out.windows,
                     {options_of(drive, weighed), drive.request.engine_off_s});
  out.sheet = aero_sheet(out.fit);
  DriveFit lift;
  for (std::size_t a = 0; a < 2; ++a) {
    const std::string name = fmt::format("{}_lift_area_m2", recording::kAxleNames[a]);
    lift.found.push_back(
        weighed ? weighed->at(name)
                : found_of(name, "m2",
                           drive.car.parameters.axle(a, vehicle::Parameter::front_lift_area_m2),
                           "no wheel loads that tell weight and downforce apart"));
  }
  out.sheet += plain_sheet(lift.found);
  join(out.fit, lift);
}

void measure_suspension(const ReadDrive& drive, Measured& out) {
  const auto weighed = mass_where_seen(drive, out.windows);
  const double stated_kg =
      drive.car.parameters[vehicle::Parameter::chassis_mass_kg] + drive.fuel_kg;
  out.fit = fit_suspension(drive.car, drive.vehicle.prior, out.windows,
                           weighed ? weighed->at("mass_kg").value : stated_kg);
  const DriveFit dampers = fit_dampers(drive.car, drive.recording);
  out.sheet = suspension_sheet(out.fit) + plain_sheet(dampers.found);
  join(out.fit, dampers);
}

/// The discs, heated by the torques that were found where they were.
DriveFit discs_of(const ReadDrive& drive, const DriveFit& brakes) {
  constexpr double kUnknownShare = 0.05;  // of the vehicle file's friction, where nothing is found
  DiscsFitOptions options;
  const Found &both = brakes.at("torque"), &front = brakes.at("front_torque"),
              &rear = brakes.at("rear_torque");
  if (front.unseen.empty() && rear.unseen.empty()) {
    options.torque = {front.value, rear.value};
    options.torque_sd = std::max(front.sd / front.value, rear.sd / rear.value);
  } else if (both.unseen.empty()) {
    options.torque = {both.value, both.value};
    options.torque_sd = both.sd / both.value;
  } else {
    options.torque_sd = kUnknownShare;
  }
  return fit_discs(drive.car, drive.vehicle.prior, drive.recording, options);
}

void measure_brakes(const ReadDrive& drive, Measured& out) {
  const auto options = options_of(drive, mass_where_seen(drive, out.windows));
  out.fit = fit_brakes(drive.car, drive.vehicle.prior, out.windows, options);
  out.pads = fit_pad_map(drive.car, drive.vehicle.prior, out.windows, options);
  const DriveFit discs = discs_of(drive, out.fit);
  out.sheet = brakes_sheet(drive.car, out.fit);
  out.discs_sheet = plain_sheet(discs.found);
  join(out.fit, out.pads->fit);
  join(out.fit, discs);
}

void measure_engine(const ReadDrive& drive, Measured& out) {
  const auto options = options_of(drive, mass_where_seen(drive, out.windows));
  out.engine = fit_engine(drive.car, drive.vehicle.prior, out.windows, drive.recording, options);
  out.fit = out.engine->fit;
}

}  // namespace

recording::Recording without_short_gaps(recording::Recording recording, double longest_s) {
  recording::Table& table = recording.table;
  const std::vector<double>* const found = table.find("time_s");
  if (found == nullptr) return recording;
  const std::vector<double> time_s = *found;
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    if (table.names[c] == "time_s") continue;
    std::vector<double>& v = table.columns[c];
    const bool steps = table.names[c] == "gear";
    for (const recording::Stretch& stretch : recording.stretches) {
      std::size_t last = stretch.end;  // none yet
      for (std::size_t k = stretch.begin; k < stretch.end; ++k) {
        if (!std::isfinite(v[k])) continue;
        if (last < k && time_s[k] - time_s[last] <= longest_s)
          for (std::size_t i = last + 1; i < k; ++i) {
            const double way = (time_s[i] - time_s[last]) / (time_s[k] - time_s[last]);
            v[i] = steps ? v[last] : v[last] + way * (v[k] - v[last]);
          }
        last = k;
      }
    }
  }
  return recording;
}

ReadDrive::ReadDrive(const MeasureRequest& asked)
    : request(asked),
      vehicle(vehicle::read_vehicle(asked.vehicle_path, asked.setup_path, asked.settings)),
      car(make_car(vehicle.files, vehicle.parameters, vehicle.terms, vehicle.contact)) {
  recording::Mapping mapping;
  if (!asked.mapping_path.empty()) mapping = recording::read_mapping(asked.mapping_path);
  recording = without_short_gaps(recording::read_recording(asked.recording_path, mapping));
  if (!asked.road_path.empty())
    road.emplace(std::move(vehicle::read_road(asked.road_path, {}).surface));
  options.imu_ahead_m = mapping.imu_ahead_m;
  options.imu_yaw_rad = mapping.imu_yaw_rad;
  options.body_axes = asked.body_axes;
  fuel_kg = asked.fuel_kg.value_or(kAssumedFuel_kg);
  fuel_from = asked.fuel_kg ? FuelFrom::kRequest : FuelFrom::kAssumed;
  std::vector<double> recorded;
  if (const auto* fuel = recording.table.find("fuel_kg"); fuel != nullptr)
    std::copy_if(fuel->begin(), fuel->end(), std::back_inserter(recorded),
                 [](double v) { return std::isfinite(v); });
  if (recorded.empty()) return;
  fuel_kg = base::median(recorded);
  fuel_from = FuelFrom::kLog;
}

Measured measure(const std::string& part, const ReadDrive& drive) {
  constexpr std::pair<const char*, void (*)(const ReadDrive&, Measured&)> kFits[] = {
      {kMeasuredParts[0], measure_mass},
      {kMeasuredParts[1], measure_aero},
      {kMeasuredParts[2], measure_suspension},
      {kMeasuredParts[3], measure_brakes},
      {kMeasuredParts[4], measure_engine}};
  for (const auto& [name, fit] : kFits) {
    if (part != name) continue;
    try {
      Measured out;
      out.windows = drive_windows(drive.car, drive.road ? &*drive.road : nullptr, drive.recording,
                                  drive.options);
      fit(drive, out);
      out.fit.doubts.insert(out.fit.doubts.begin(), out.windows.doubts.begin(),
                            out.windows.doubts.end());
      return out;
    } catch (const base::Error& error) {
      throw base::Error(fmt::format("{}: {}", drive.request.recording_path, error.what()));
    }
  }
  throw base::Error(fmt::format("no part of a car is called '{}'; wanted {}", part,
                                fmt::join(kMeasuredParts, ", ")));
}

}  // namespace identify
