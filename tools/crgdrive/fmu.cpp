#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/write_file.h"
#include "command/version.h"
#include "commands.h"
#include "fmu/export_unit.h"
#include "vehicle/error.h"

namespace crgdrive {
namespace {

/// The shared object lies where this program was built or installed.
std::string find_binary() {
  namespace fs = std::filesystem;
  const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
  for (const char* const beside : {KERBSTONE_CAR_INSTALLED, KERBSTONE_CAR_BUILT})
    if (std::error_code ignored; fs::is_regular_file(here / beside, ignored))
      return (here / beside).lexically_normal().string();
  throw vehicle::Error(fmt::format(
      "{}.so, which a unit holds, is not where this program was installed or built, "
      "{}; install or build the whole of Kerbstone",
      fmu::kModelIdentifier, (here / KERBSTONE_CAR_INSTALLED).lexically_normal().string()));
}

}  // namespace

int fmu(const FmuCommand& command, Terminal& terminal) {
  fmu::ExportOptions options;
  options.vehicle_path = command.car.vehicle_path;
  options.setup_path = command.car.setup_path;
  options.settings = command.car.settings;
  options.contact = command.car.contact;
  options.integrator = command.car.integrator;
  options.step_s = command.car.step_s;
  options.road_path = command.track_path;
  options.friction_path = command.friction_path;
  options.version = command.version == "3" ? fmu::Version::kFmi3 : fmu::Version::kFmi2;
  options.binary_path = find_binary();
  options.generation_tool = std::string("Kerbstone crgdrive ") + command::version();
  const fmu::Exported unit = fmu::export_unit(options);
  base::write_file(command.out_path, unit.bytes);
  if (terminal.json) {
    const nlohmann::ordered_json numbers{{"fmu", command.out_path},     {"fmi", command.version},
                                         {"model", unit.model_name},    {"token", unit.token},
                                         {"variables", unit.variables}, {"files", unit.files},
                                         {"bytes", unit.bytes.size()}};
    terminal.print(base::json_text(numbers));
  } else {
    terminal.print(fmt::format("{}: FMI {}.0 co-simulation, {} variables, {:.1f} MB\n",
                               command.out_path, command.version, unit.variables,
                               static_cast<double>(unit.bytes.size()) / 1e6));
  }
  return kOk;
}

}  // namespace crgdrive
