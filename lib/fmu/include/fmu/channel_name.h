// Structured names of variables from the names that channels, states and parameters have.
#pragma once

#include <string>
#include <string_view>

namespace fmu {

struct ChannelName {
  std::string name;     ///< "wheel.*.fz", "car.steer_command"
  std::string unit;     ///< "N"; "1" where the channel's name has none
  std::string pattern;  ///< the channel with * for the wheel: "fz_*_n"
  bool of_wheel = false;
};

/// Takes a channel apart: its unit at the end, and fl, fr, rl, rr (or * for all) within. What is
/// left is the name; temperatures say so, and the wheel's own speed is its spin.
ChannelName structured_name(std::string_view channel);

}  // namespace fmu
