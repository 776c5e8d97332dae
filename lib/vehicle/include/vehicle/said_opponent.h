// Another car on the road, as a command line says it.
#pragma once

#include <optional>
#include <string>

namespace vehicle {

struct SaidOpponent {
  std::string path;
  std::optional<double> ahead_s;  ///< FILE@2s; may be negative
  std::optional<double> ahead_m;  ///< FILE@30m; may be negative
};

/// FILE, FILE@2s or FILE@30m taken apart. What stands behind an @ and is no finite number with `s`
/// or `m` is part of the file's name.
SaidOpponent said_opponent(const std::string& said);

}  // namespace vehicle
