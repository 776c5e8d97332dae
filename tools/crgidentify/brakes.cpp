#include <fmt/format.h>

#include <algorithm>

#include "base/json_text.h"
#include "base/one_line.h"
#include "base/write_file.h"
#include "commands.h"
#include "drive_report.h"
#include "pad_report.h"

namespace crgidentify {

int brakes(const DriveCommand& command, Terminal& terminal) {
  const identify::MeasureRequest request = request_of(command);
  terminal.start("reading");
  const identify::ReadDrive drive(request);
  terminal.start("fitting");
  const identify::Measured measured = identify::measure(command.part, drive);
  const identify::PadMapFit& pads = *measured.pads;
  std::string lines = measured.sheet;
  const bool is_map =
      std::any_of(pads.cells.begin(), pads.cells.end(),
                  [](const identify::PadCell& cell) { return cell.unseen.empty(); });
  if (!command.pad_map_path.empty() && !is_map)
    terminal.remark(
        fmt::format("{}: not written: no place of a map of the pads' friction is observable",
                    base::one_line(command.pad_map_path)));
  if (is_map && may_write(measured.fit.doubts, command.pad_map_path, terminal)) {
    base::write_file(command.pad_map_path, pad_map_csv(pads));
    lines = fmt::format(
        "# the brakes' torque is in the map of the pads; for the vehicle file:\n# maps:\n#   "
        "pad_friction: {}\n",
        base::one_line(command.pad_map_path));
  }
  lines += measured.discs_sheet;
  if (!command.plots_path.empty())
    base::write_file(
        command.plots_path,
        pad_page(pads, measured.fit,
                 fmt::format("Brakes from {}", base::one_line(command.recording_path))));
  return tell(command, drive, measured, command.part, lines, terminal,
              {pad_table(pads), "pad_map", pad_json(pads)});
}

}  // namespace crgidentify
