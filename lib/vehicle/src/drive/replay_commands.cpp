#include "replay_commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/error.h"

namespace vehicle {
namespace {

constexpr std::array<const char*, kWheels> kWheelNames{"fl", "fr", "rl", "rr"};

Channel scaled(Channel values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

void read_steering(const Source& source, const ReplayOptions& options, Car<double>& car,
                   Commands& out, std::vector<std::string>& said) {
  out.steer_command_rad = source.channel("steer_command_rad");
  const char* const how = options.closed_path ? ", with what leads back to the recorded path" : "";
  if (!out.steer_command_rad.empty()) {
    said.push_back(std::string("steer_command_rad steers") + how);
  } else {
    out.steer_command_rad = source.channel("steer_rad");
    for (double& angle : out.steer_command_rad)
      angle = laws::steering_command(car.files->steering, car.parameters[Parameter::steering_ratio],
                                     angle);
    car.terms[Term::steering_actuator] = 0.0;
    car.terms[Term::steering_friction] = 0.0;
    if (!out.steer_command_rad.empty())
      said.push_back(std::string("the measured steer_rad steers, past the steering actuator") +
                     how);
    else if (options.closed_path)
      said.emplace_back("no steering was recorded: the driver steers along the recorded path");
    else
      throw Error(
          "the recording has neither steer_command_rad nor steer_rad; let the driver close the "
          "path");
  }
}

void read_throttle(const Source& source, Car<double>& car, Commands& out,
                   std::vector<std::string>& said) {
  out.throttle_command = source.channel("throttle_command");
  if (!out.throttle_command.empty()) {
    said.emplace_back("throttle_command drives");
  } else {
    out.throttle_command =
        scaled(source.channel("throttle"), 1.0 / car.parameters[Parameter::throttle_gain]);
    if (out.throttle_command.empty())
      throw Error("the recording has neither throttle_command nor throttle; a replay needs one");
    car.terms[Term::throttle_actuator] = 0.0;
    car.terms[Term::throttle_friction] = 0.0;
    said.emplace_back("the measured throttle drives, past the throttle actuator");
  }
}

void read_brakes(const Source& source, Car<double>& car, Commands& out,
                 std::vector<std::string>& said) {
  const auto all_wheels = [&](const std::string& before, const std::string& after) {
    bool found = false;
    for (std::size_t i = 0; i < kWheels; ++i) {
      out.brake_command_pa[i] =
          source.channel(fmt::format("{}{}{}", before, kWheelNames[i], after));
      found = found || !out.brake_command_pa[i].empty();
    }
    return found;
  };
  const auto one = [&](const char* name) {
    const Channel channel = source.channel(name);
    if (!channel.empty()) out.brake_command_pa.fill(channel);
    return !channel.empty();
  };
  if (all_wheels("brake_", "_command_pa")) {
    said.emplace_back("brake_.._command_pa brake each wheel");
  } else if (one("brake_command_pa")) {
    said.emplace_back("brake_command_pa brakes all wheels alike");
  } else if (all_wheels("brake_", "_pa") || one("brake_pa")) {
    for (Channel& channel : out.brake_command_pa)
      channel = scaled(channel, 1.0 / car.parameters[Parameter::brake_gain]);
    car.terms[Term::brake_actuator] = 0.0;
    said.emplace_back("the measured brake pressures brake, past the brake actuators");
  } else {
    said.emplace_back("no brake was recorded: it stays open");
  }
}

void read_gear(const Source& source, Commands& out) {
  if (const std::vector<double>* const gear = source.recording.table.find("gear")) {
    out.gear = source.channel("gear");
    // While a shift was measured as neutral, the command already is the next gear.
    double next = out.gear.empty() ? 0.0 : out.gear.back(), since = 0.0;
    for (std::size_t i = out.gear.size(); i-- > 0;) {
      out.gear[i] = std::round(std::isfinite((*gear)[i]) ? (*gear)[i] : next);
      if (out.gear[i] != 0.0) {
        next = out.gear[i];
        since = source.time[i];
      } else if (since - source.time[i] < 1.0) {
        out.gear[i] = next;
      }
    }
  }
}

}  // namespace

double at(const Channel& channel, const std::vector<double>& time, std::size_t row, double t) {
  const double share = std::clamp((t - time[row]) / (time[row + 1] - time[row]), 0.0, 1.0);
  return channel[row] + share * (channel[row + 1] - channel[row]);
}

Channel Source::channel(const std::string& name) const {
  const std::vector<double>* const values = recording.table.find(name);
  if (values == nullptr) return {};
  Channel filled = recording::fill_gaps(time, *values);
  if (std::isnan(filled.front())) return {};
  return filled;
}

Channel Source::need(const std::string& name) const {
  Channel values = channel(name);
  if (values.empty())
    throw Error(fmt::format("the recording has no channel {}; a replay needs it", name));
  return values;
}

Commands read_commands(const Source& source, const ReplayOptions& options, Car<double>& car,
                       std::vector<std::string>& said) {
  Commands out;
  out.wake_x_m = source.channel("wake_x_m");
  out.wake_y_m = source.channel("wake_y_m");
  if (options.driver) {
    said.emplace_back("the driver steers, accelerates, brakes and shifts along the recorded path");
    return out;
  }
  if (options.hold_speed)
    said.emplace_back("a push along the car holds its speed and place to the recording");
  read_steering(source, options, car, out, said);
  read_throttle(source, car, out, said);
  read_brakes(source, car, out, said);
  read_gear(source, out);
  said.emplace_back(out.gear.empty() ? "no gear was recorded: the car shifts by itself"
                                     : "gear shifts");
  return out;
}

Controls<double> controls_at(const Commands& commands, const std::vector<double>& time,
                             std::size_t row, double t, const Car<double>& car, double vx_mps,
                             int& gear) {
  Controls<double> c;
  if (!commands.steer_command_rad.empty())
    c.steer_command_rad = at(commands.steer_command_rad, time, row, t);
  if (!commands.throttle_command.empty())
    c.throttle_command = std::clamp(at(commands.throttle_command, time, row, t), 0.0, 1.0);
  for (std::size_t i = 0; i < kWheels; ++i)
    if (!commands.brake_command_pa[i].empty())
      c.brake_command_pa[i] = std::max(0.0, at(commands.brake_command_pa[i], time, row, t));
  gear = commands.gear.empty() ? choose_gear(car, vx_mps, gear)
                               : std::clamp(static_cast<int>(commands.gear[row]), -1, kMostGears);
  c.gear_command = gear;
  c.opponent = !commands.wake_x_m.empty() && !commands.wake_y_m.empty();
  if (c.opponent) {
    c.wake_x_m = at(commands.wake_x_m, time, row, t);
    c.wake_y_m = at(commands.wake_y_m, time, row, t);
  }
  return c;
}

}  // namespace vehicle
