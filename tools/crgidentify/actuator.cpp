#include <fmt/format.h>

#include <algorithm>

#include "actuator_report.h"
#include "base/error.h"
#include "base/json_text.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "commands.h"
#include "recording/recording.h"

namespace crgidentify {
namespace {

/// One channel each, of the longest stretch without a gap in time.
struct Channels {
  std::vector<double> time_s, command, movement;
};

Channels read_channels(const ActuatorCommand& command, const std::string& in,
                       const std::string& out) {
  recording::Mapping mapping;
  if (!command.mapping_path.empty()) mapping = recording::read_mapping(command.mapping_path);
  const recording::Recording recording = recording::read_recording(command.recording_path, mapping);
  if (recording.table.find(command.out_path) != nullptr)
    throw command::UsageError("-o " + command.out_path +
                              " is a channel: a file is wanted; --measure names the channel");
  const std::vector<double>& time_s = *recording.table.find("time_s");
  const auto longest = *std::max_element(
      recording.stretches.begin(), recording.stretches.end(),
      [](const auto& a, const auto& b) { return a.end - a.begin < b.end - b.begin; });
  const auto cut = [&](const std::vector<double>& values) {
    return std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(longest.begin),
                               values.begin() + static_cast<std::ptrdiff_t>(longest.end));
  };
  const auto channel = [&](const std::string& name) {
    const std::vector<double>* const values = recording.table.find(name);
    if (values == nullptr)
      throw base::Error(
          fmt::format("{}: no channel {}; name its column in a mapping, or another "
                      "channel by --command or --measure",
                      command.recording_path, name));
    return cut(recording::fill_gaps(time_s, *values));
  };
  return {cut(time_s), channel(in), channel(out)};
}

identify::ActuatorFitOptions options_of(const ActuatorCommand& command) {
  identify::ActuatorFitOptions options;
  options.threads = command.threads;
  if (command.order != "auto") {
    identify::ActuatorOrder order;
    order.poles = command.order[0] - '0';
    order.zero = command.order.find("zero") != std::string::npos;
    order.play = command.order.find("play") != std::string::npos;
    options.order = order;
  }
  if (command.hold != "auto")
    options.hold = command.hold == "line" ? identify::Hold::kLine : identify::Hold::kStep;
  return options;
}

}  // namespace

int actuator(const ActuatorCommand& command, Terminal& terminal) {
  const bool steering = command.part == "steering", throttle = command.part == "throttle";
  const std::string in = !command.input.empty() ? command.input
                         : steering             ? "steer_command_rad"
                         : throttle             ? "throttle_command"
                                                : "brake_fl_command_pa";
  const std::string out = !command.movement.empty() ? command.movement
                          : steering                ? "steer_rad"
                          : throttle                ? "throttle"
                                                    : "brake_fl_pa";
  terminal.start("reading");
  const Channels channels = read_channels(command, in, out);
  terminal.start("fitting");
  identify::ActuatorFit fit, for_car;
  try {
    identify::ActuatorFitOptions options = options_of(command);
    fit = for_car =
        identify::fit_actuator(channels.time_s, channels.command, channels.movement, options);
    if (fit.order.poles == 3) {  // the car's actuators have two
      options.order = identify::ActuatorOrder{2, true, fit.order.play};
      for_car =
          identify::fit_actuator(channels.time_s, channels.command, channels.movement, options);
    }
  } catch (const base::Error& error) {
    throw base::Error(
        fmt::format("{}: {} to {}: {}", command.recording_path, in, out, error.what()));
  }
  std::string sheet =
      fmt::format("# {} to {}, {} rows of {} (sha256 {})\n", in, out, fit.rows,
                  command.recording_path, base::sha256_of_file(command.recording_path));
  if (fit.order.poles == 3)
    sheet += fmt::format(
        "# 3 poles leave {:.4g} rms, 2 and a zero, as below, {:.4g}; the car's actuators have 2\n",
        fit.rms, for_car.rms);
  sheet += actuator_sheet(for_car, command.part);
  if (for_car.dead_time_s.value > 0.2)
    terminal.remark(fmt::format("the dead time is {:.3f} s; a car takes no more than 0.2 s",
                                for_car.dead_time_s.value));
  if (!command.out_path.empty()) base::write_file(command.out_path, sheet);
  if (!command.plots_path.empty())
    base::write_file(command.plots_path,
                     actuator_page(fit, in + " to " + out, channels.command, channels.movement));
  if (terminal.json) {
    auto json = actuator_json(fit);
    json["command"] = in;
    json["movement"] = out;
    terminal.print(base::json_text(json));
  } else {
    terminal.print(sheet + actuator_text(fit));
  }
  return kOk;
}

}  // namespace crgidentify
