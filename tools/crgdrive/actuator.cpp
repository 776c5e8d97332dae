#include "vehicle/actuator.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "base/json_text.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "vehicle/error.h"
#include "vehicle/recording.h"

namespace crgdrive {

int actuator(const ActuatorCommand& command, Terminal& terminal) {
  const bool steering = command.actuator == "steering", throttle = command.actuator == "throttle";
  const std::string in = !command.command.empty() ? command.command
                         : steering               ? "steer_command_rad"
                         : throttle               ? "throttle_command"
                                                  : "brake_fl_command_pa";
  const std::string out = !command.movement.empty() ? command.movement
                          : steering              ? "steer_rad"
                          : throttle              ? "throttle"
                                                  : "brake_fl_pa";
  vehicle::Mapping mapping;
  if (!command.mapping_path.empty()) mapping = vehicle::read_mapping(command.mapping_path);
  const vehicle::Recording recording = vehicle::read_recording(command.recording_path, mapping);
  const auto channel = [&](const std::string& name) -> std::vector<double> {
    const std::vector<double>* const values = recording.table.find(name);
    if (values == nullptr)
      throw vehicle::Error(
          fmt::format("{}: no channel {}; name its column in a mapping, or another "
                      "channel by --command or --movement",
                      command.recording_path, name));
    return vehicle::fill_gaps(*recording.table.find("time_s"), *values);
  };
  if (recording.table.find(command.out_path) != nullptr)
    throw UsageError("-o " + command.out_path + " is a channel: a file is wanted; --movement names the channel");
  const std::vector<double> u = channel(in), y = channel(out);
  // The longest stretch without a gap in time.
  const auto longest = *std::max_element(
      recording.stretches.begin(), recording.stretches.end(),
      [](const auto& a, const auto& b) { return a.end - a.begin < b.end - b.begin; });
  const auto cut = [&](const std::vector<double>& values) {
    return std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(longest.begin),
                               values.begin() + static_cast<std::ptrdiff_t>(longest.end));
  };
  vehicle::ActuatorModel m;
  try {
    m = vehicle::identify_actuator(cut(*recording.table.find("time_s")), cut(u), cut(y));
  } catch (const vehicle::Error& error) {
    throw vehicle::Error(
        fmt::format("{}: {} to {}: {}", command.recording_path, in, out, error.what()));
  }
  const std::string& group = command.actuator;
  const std::string sheet = fmt::format(
      "# {} to {}, {} rows of {} (sha256 {})\n"
      "{}.{} = {:.6g}\n{}.dead_time_s = {:.6g}\n{}.lag_s = {:.6g}\n{}.damping = {:.6g}\n"
      "{}.lead_s = {:.6g}\n",
      in, out, longest.end - longest.begin, command.recording_path,
      base::sha256_of_file(command.recording_path), group, steering ? "ratio" : "gain",
      steering ? 1.0 / m.gain : m.gain, group, m.dead_time_s, group, m.lag_s, group, m.damping,
      group, m.lead_s);
  const vehicle::ArxCoefficients arx = vehicle::arx_of(m, 0.001);
  if (!command.out_path.empty()) base::write_file(command.out_path, sheet);
  if (terminal.json) {
    terminal.print(base::json_text(nlohmann::ordered_json{{"command", in},
                                                           {"movement", out},
                                                           {"rows", longest.end - longest.begin},
                                                           {"gain", m.gain},
                                                           {"dead_time_s", m.dead_time_s},
                                                           {"lag_s", m.lag_s},
                                                           {"damping", m.damping},
                                                           {"lead_s", m.lead_s},
                                                           {"rms", m.rms},
                                                           {"rms_gain_alone", m.rms_plain}}));
    return kOk;
  }
  terminal.print(fmt::format("{}root mean square left: {:.4g}; with a gain alone: {:.4g}\n", sheet, m.rms,
             m.rms_plain));
  terminal.print(fmt::format(
      "at 1 ms: y[k] = {:.8g} y[k-1] {:+.8g} y[k-2] {:+.8g} u[k-{:.1f}] {:+.8g} u[k-1-{:.1f}]\n",
      arx.a1, arx.a2, m.gain * arx.b0, m.dead_time_s * 1e3, m.gain * arx.b1, m.dead_time_s * 1e3));
  return kOk;
}

}  // namespace crgdrive
