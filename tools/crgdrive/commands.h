// The subcommands, one options struct and one function each. main.cpp turns arguments into the
// structs; the functions load, call the library, save. They throw on failure.
#pragma once

#include <string>

namespace crgdrive {

struct TyreCommand {
  std::string tyre_path, points_path, out_path;
  std::string alpha = "tan";  ///< tan or angle
  bool mirrored = false;
};
void tyre(const TyreCommand& command);

}  // namespace crgdrive
