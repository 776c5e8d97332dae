// The subcommands, one options struct and one function each. main.cpp turns arguments into the
// structs; the functions load, call the library, save and print. They throw on failure; what they
// return is the exit code.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace lidar2mesh {

/// "m", "ft", "us-ft", "cm", "mm" or empty (automatic) as metres.
std::optional<double> metres_per_unit(const std::string& unit);

struct InfoCommand {
  std::string cloud, unit;
  bool json = false;
};
int run_info(const InfoCommand& command);

}  // namespace lidar2mesh
