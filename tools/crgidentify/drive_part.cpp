#include "commands.h"
#include "drive_report.h"

namespace crgidentify {

int drive_part(const DriveCommand& command, Terminal& terminal) {
  const identify::MeasureRequest request = request_of(command);
  terminal.start("reading");
  const identify::ReadDrive drive(request);
  terminal.start("fitting");
  const identify::Measured measured = identify::measure(command.part, drive);
  return tell(command, drive, measured, command.part, measured.sheet, terminal);
}

}  // namespace crgidentify
