#include <fmt/format.h>

#include "base/error.h"
#include "commands.h"
#include "drive_report.h"

namespace crgidentify {

int mass(const DriveCommand& command, Terminal& terminal) {
  terminal.start("reading");
  const ReadDrive drive(command);
  terminal.start("fitting");
  identify::MassFitOptions options;
  options.fuel_kg = drive.fuel_kg;
  options.body_axes = drive.options.body_axes;
  try {
    identify::DriveWindows windows = drive.windows();
    const identify::DriveFit fit =
        identify::fit_mass(drive.car, drive.vehicle.prior, windows, options);
    return tell(command, drive, windows, fit, "mass",
                identify::mass_sheet(drive.car, fit, drive.fuel_kg), terminal);
  } catch (const base::Error& error) {
    throw base::Error(fmt::format("{}: {}", command.recording_path, error.what()));
  }
}

}  // namespace crgidentify
