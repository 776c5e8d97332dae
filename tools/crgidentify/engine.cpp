#include <fmt/format.h>

#include <filesystem>

#include "base/json_text.h"
#include "base/one_line.h"
#include "base/write_file.h"
#include "commands.h"
#include "drive_report.h"
#include "engine_report.h"

namespace crgidentify {

int engine(const DriveCommand& command, Terminal& terminal) {
  const identify::MeasureRequest request = request_of(command);
  terminal.start("reading");
  const identify::ReadDrive drive(request);
  terminal.start("fitting");
  const identify::Measured measured = identify::measure(command.part, drive);
  const identify::EngineFit& fit = *measured.engine;
  const bool writes = may_write(measured.fit.doubts, command.out_path, terminal);
  std::string lines = drive_header(command, drive, "engine");
  if (writes && command.out_path == "-") {  // standard output takes one file
    base::write_file(command.out_path, lines + engine_yaml(fit, "engine_map.csv"));
    if (is_any_seen(fit))
      terminal.remark(
          "engine_map.csv, which these lines name, is not written: -o FILE.yaml writes both");
  } else if (writes) {
    const std::filesystem::path yaml(command.out_path);
    const std::string stem = yaml.stem().string();
    const auto beside = [&](const char* ending) {
      return (yaml.parent_path() / (stem + ending)).string();
    };
    if (is_any_seen(fit)) base::write_file(beside("_map.csv"), engine_map_csv(fit));
    base::write_file(beside("_places.csv"), engine_cells_csv(fit));
    base::write_file(command.out_path, lines + engine_yaml(fit, stem + "_map.csv"));
  }
  if (!command.plots_path.empty())
    base::write_file(
        command.plots_path,
        engine_page(fit, fmt::format("Engine from {}", base::one_line(command.recording_path))));
  if (terminal.json) {
    nlohmann::ordered_json json = drive_json(measured);
    json["fuel_kg"] = drive.fuel_kg;
    json["map"] = engine_json(fit);
    terminal.print(base::json_text(json));
  } else {
    for (const std::string& doubt : measured.fit.doubts)
      lines += fmt::format("# not to be used: {}\n", base::one_line(doubt));
    terminal.print(lines + drive_text(measured) + engine_table(fit));
  }
  return measured.fit.doubts.empty() ? kOk : command::kNotValid;
}

}  // namespace crgidentify
