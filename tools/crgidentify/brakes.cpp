#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/json_text.h"
#include "base/one_line.h"
#include "base/write_file.h"
#include "commands.h"
#include "drive_report.h"
#include "identify/brakes_fit.h"
#include "identify/discs_fit.h"
#include "identify/pad_map_fit.h"
#include "pad_report.h"

namespace crgidentify {
namespace {

/// The discs, heated by the torques that were found where they were.
identify::DriveFit discs_of(const ReadDrive& drive, const identify::DriveFit& brakes) {
  constexpr double kUnknownShare = 0.05;  // of the vehicle file's friction, where nothing is found
  identify::DiscsFitOptions options;
  const identify::Found &both = brakes.at("torque"), &front = brakes.at("front_torque"),
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
  return identify::fit_discs(drive.car, drive.vehicle.prior, drive.recording, options);
}

}  // namespace

int brakes(const DriveCommand& command, Terminal& terminal) {
  terminal.start("reading");
  const ReadDrive drive(command);
  terminal.start("fitting");
  try {
    identify::DriveWindows windows = drive.windows();
    const auto options = options_of<identify::BrakesFitOptions>(drive, windows);
    identify::DriveFit fit = identify::fit_brakes(drive.car, drive.vehicle.prior, windows, options);
    const identify::PadMapFit pads =
        identify::fit_pad_map(drive.car, drive.vehicle.prior, windows, options);
    const identify::DriveFit discs = discs_of(drive, fit);
    std::string lines = identify::brakes_sheet(drive.car, fit);
    const bool is_map =
        std::any_of(pads.cells.begin(), pads.cells.end(),
                    [](const identify::PadCell& cell) { return cell.unseen.empty(); });
    if (!command.pad_map_path.empty() && !is_map)
      terminal.remark(
          fmt::format("{}: not written: no place of a map of the pads' friction is observable",
                      base::one_line(command.pad_map_path)));
    for (const identify::DriveFit* more : {&pads.fit, &discs}) {
      fit.found.insert(fit.found.end(), more->found.begin(), more->found.end());
      fit.remarks.insert(fit.remarks.end(), more->remarks.begin(), more->remarks.end());
      fit.doubts.insert(fit.doubts.end(), more->doubts.begin(), more->doubts.end());
    }
    if (is_map && may_write(all_doubts(windows, fit), command.pad_map_path, terminal)) {
      base::write_file(command.pad_map_path, pad_map_csv(pads));
      lines = fmt::format(
          "# the brakes' torque is in the map of the pads; for the vehicle file:\n# maps:\n#   "
          "pad_friction: {}\n",
          base::one_line(command.pad_map_path));
    }
    lines += identify::discs_sheet(discs);
    if (!command.plots_path.empty())
      base::write_file(
          command.plots_path,
          pad_page(pads, fit,
                   fmt::format("Brakes from {}", base::one_line(command.recording_path))));
    return tell(command, drive, windows, fit, "brakes", lines, terminal,
                {pad_table(pads), "pad_map", pad_json(pads)});
  } catch (const base::Error& error) {
    throw base::Error(fmt::format("{}: {}", command.recording_path, error.what()));
  }
}

}  // namespace crgidentify
