#include <fmt/format.h>

#include "base/error.h"
#include "commands.h"
#include "drive_report.h"
#include "identify/brakes_fit.h"

namespace crgidentify {

int brakes(const DriveCommand& command, Terminal& terminal) {
  terminal.start("reading");
  const ReadDrive drive(command);
  terminal.start("fitting");
  identify::BrakesFitOptions options;
  options.fuel_kg = drive.fuel_kg;
  options.body_axes = drive.options.body_axes;
  try {
    const identify::DriveWindows windows = drive.windows();
    if (const auto weighed = mass_where_seen(drive, windows)) {
      options.mass_kg = weighed->at("mass_kg").value;
      options.mass_sd_kg = weighed->at("mass_kg").sd;
    }
    const identify::DriveFit fit =
        identify::fit_brakes(drive.car, drive.vehicle.prior, windows, options);
    return tell(command, drive, windows, fit, "brakes", identify::brakes_sheet(drive.car, fit),
                terminal);
  } catch (const base::Error& error) {
    throw base::Error(fmt::format("{}: {}", command.recording_path, error.what()));
  }
}

}  // namespace crgidentify
