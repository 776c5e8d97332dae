// Coordinate systems as text: WKT 1 (OGC 01-009) and WKT 2 (OGC 18-010r7).
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace cloud {

struct LengthUnit {
  std::string name;
  double metres = 1.0;
};

/// "m", "ft" or "US survey ft" where the factor is that of one of them, else the name given.
LengthUnit length_unit(const std::string& name, double metres);

struct CoordinateSystem {
  std::string name;                        ///< of the plan's; empty where there is none
  std::optional<LengthUnit> plan, height;  ///< as far as the text says
  bool in_degrees = false;
};

/// Of any text: what it does not hold stays empty.
CoordinateSystem read_wkt(std::string_view text);

}  // namespace cloud
