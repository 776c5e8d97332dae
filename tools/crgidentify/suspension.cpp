#include <fmt/format.h>

#include "base/error.h"
#include "commands.h"
#include "drive_report.h"
#include "identify/suspension_fit.h"

namespace crgidentify {

int suspension(const DriveCommand& command, Terminal& terminal) {
  terminal.start("reading");
  const ReadDrive drive(command);
  terminal.start("fitting");
  try {
    const identify::DriveWindows windows = drive.windows();
    const auto weighed = mass_where_seen(drive, windows);
    const double stated_kg =
        drive.car.parameters[vehicle::Parameter::chassis_mass_kg] + drive.fuel_kg;
    const identify::DriveFit fit =
        identify::fit_suspension(drive.car, drive.vehicle.prior, windows,
                                 weighed ? weighed->at("mass_kg").value : stated_kg);
    return tell(command, drive, windows, fit, "suspension", identify::suspension_sheet(fit),
                terminal);
  } catch (const base::Error& error) {
    throw base::Error(fmt::format("{}: {}", command.recording_path, error.what()));
  }
}

}  // namespace crgidentify
