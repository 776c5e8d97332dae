#include <fmt/format.h>

#include "base/error.h"
#include "commands.h"
#include "drive_report.h"
#include "identify/damper_fit.h"
#include "identify/suspension_fit.h"

namespace crgidentify {

int suspension(const DriveCommand& command, Terminal& terminal) {
  terminal.start("reading");
  const ReadDrive drive(command);
  terminal.start("fitting");
  try {
    identify::DriveWindows windows = drive.windows();
    const auto weighed = mass_where_seen(drive, windows);
    const double stated_kg =
        drive.car.parameters[vehicle::Parameter::chassis_mass_kg] + drive.fuel_kg;
    identify::DriveFit fit =
        identify::fit_suspension(drive.car, drive.vehicle.prior, windows,
                                 weighed ? weighed->at("mass_kg").value : stated_kg);
    const identify::DriveFit dampers = identify::fit_dampers(drive.car, drive.recording);
    const std::string lines = identify::suspension_sheet(fit) + identify::dampers_sheet(dampers);
    fit.found.insert(fit.found.end(), dampers.found.begin(), dampers.found.end());
    fit.remarks.insert(fit.remarks.end(), dampers.remarks.begin(), dampers.remarks.end());
    fit.doubts.insert(fit.doubts.end(), dampers.doubts.begin(), dampers.doubts.end());
    return tell(command, drive, windows, fit, "suspension", lines, terminal);
  } catch (const base::Error& error) {
    throw base::Error(fmt::format("{}: {}", command.recording_path, error.what()));
  }
}

}  // namespace crgidentify
