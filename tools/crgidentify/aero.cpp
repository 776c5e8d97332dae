#include <fmt/format.h>

#include <charconv>

#include "base/error.h"
#include "commands.h"
#include "drive_report.h"
#include "identify/aero_fit.h"

namespace crgidentify {
namespace {

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

}  // namespace

int aero(const DriveCommand& command, Terminal& terminal) {
  identify::AeroFitOptions options;
  for (const std::string& text : command.engine_off)
    options.engine_off_s.push_back(stretch_of(text));
  terminal.start("reading");
  const ReadDrive drive(command);
  terminal.start("fitting");
  options.fuel_kg = drive.fuel_kg;
  options.body_axes = drive.options.body_axes;
  try {
    identify::DriveWindows windows = drive.windows();
    const auto weighed = mass_where_seen(drive, windows);
    if (weighed) {
      options.mass_kg = weighed->at("mass_kg").value;
      options.mass_sd_kg = weighed->at("mass_kg").sd;
    }
    identify::DriveFit fit = identify::fit_aero(drive.car, drive.vehicle.prior, windows, options);
    std::string lines = identify::aero_sheet(fit);
    for (const char* const axle : {"front", "rear"}) {
      const std::string name = fmt::format("{}_lift_area_m2", axle);
      identify::Found lift{
          name,
          "m2",
          0,
          0,
          0,
          0,
          drive.car.parameters.axle(axle[0] == 'f' ? 0 : 1, vehicle::Parameter::front_lift_area_m2),
          "no wheel loads that tell weight and downforce apart"};
      if (weighed) lift = weighed->at(name);
      lines += lift.unseen.empty()
                   ? fmt::format("{}.lift_area_m2 = {:.6g}\n", axle, lift.value)
                   : fmt::format("# {}.lift_area_m2 not observable: {}\n", axle, lift.unseen);
      fit.found.push_back(std::move(lift));
    }
    return tell(command, drive, windows, fit, "aero", lines, terminal);
  } catch (const base::Error& error) {
    throw base::Error(fmt::format("{}: {}", command.recording_path, error.what()));
  }
}

}  // namespace crgidentify
