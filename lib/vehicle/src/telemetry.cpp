#include "vehicle/telemetry.h"

#include <fmt/format.h>

#include <array>
#include <string>

namespace vehicle {
namespace {

constexpr const char* kWheelNames[] = {"fl", "fr", "rl", "rr"};

}  // namespace

const std::vector<std::string>& telemetry_channels() {
  static const std::vector<std::string> channels = [] {
    std::vector<std::string> names;
    const auto add = [&](std::string name) { names.push_back(std::move(name)); };
    const auto add4 = [&](const std::string& before, const std::string& after) {
      for (const char* wheel : kWheelNames) add(fmt::format("{}{}{}", before, wheel, after));
    };
    for (const char* name : {"time_s",
                             "u_m",
                             "v_m",
                             "x_m",
                             "y_m",
                             "z_m",
                             "roll_rad",
                             "pitch_rad",
                             "yaw_rad",
                             "vx_mps",
                             "vy_mps",
                             "roll_rate_radps",
                             "pitch_rate_radps",
                             "yaw_rate_radps",
                             "ax_mps2",
                             "ay_mps2",
                             "az_mps2",
                             "steer_command_rad",
                             "steer_rad",
                             "throttle_command",
                             "throttle"})
      add(name);
    add4("brake_", "_command_pa");
    add4("brake_", "_pa");
    add("gear");
    add("engine_radps");
    add("boost");
    add("fuel_kg");
    add4("wheel_", "_radps");
    add4("fz_", "_n");
    add4("suspension_", "_m");
    add4("brake_disc_", "_k");
    add4("tyre_", "_k");
    return names;
  }();
  return channels;
}

void fill_telemetry(double time_s, const State<double>& s, const Detail<double>& d,
                    const Controls<double>& c, double u_m, double v_m, std::span<double> values) {
  std::size_t column = 0;
  const auto put = [&](double value) { values[column++] = value; };
  const auto put4 = [&](std::size_t group) {
    for (std::size_t i = 0; i < kWheels; ++i) put(s[group + i]);
  };
  put(time_s);
  put(u_m);
  put(v_m);
  for (const std::size_t i :
       {kX, kY, kZ, kRoll, kPitch, kYaw, kVx, kVy, kRollRate, kPitchRate, kYawRate})
    put(s[i]);
  put(d.specific_force_mps2.x);
  put(d.specific_force_mps2.y);
  put(d.specific_force_mps2.z);
  put(c.steer_command_rad);
  put(d.inputs.steer_rad);
  put(c.throttle_command);
  put(d.inputs.throttle);
  for (const double pressure : c.brake_command_pa) put(pressure);
  for (const double pressure : d.inputs.brake_pa) put(pressure);
  put(d.inputs.gear);
  put(s[kEngine]);
  put(d.boost);
  put(s[kFuel]);
  put4(kSpin);
  for (const auto& wheel : d.wheel) put(wheel.fz_n);
  put4(kTravel);
  put4(kDiscSurface);
  put4(kTyre);
}

}  // namespace vehicle
