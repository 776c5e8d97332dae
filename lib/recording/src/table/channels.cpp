#include "recording/channels.h"

#include <fmt/format.h>

namespace recording {
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

const std::vector<std::string>& canonical_channels() {
  static const std::vector<std::string> channels = [] {
    std::vector<std::string> names = telemetry_channels();
    for (const char* name :
         {"brake_pa", "brake_command_pa", "wheel_fl_mps", "wheel_fr_mps", "wheel_rl_mps",
          "wheel_rr_mps", "wake_x_m", "wake_y_m", "latitude_rad", "longitude_rad"})
      names.emplace_back(name);
    return names;
  }();
  return channels;
}

}  // namespace recording
