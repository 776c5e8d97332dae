// resources/unit.txt: what a unit knows about itself when it is loaded.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "fmu/variables.h"

namespace fmu {

/// Lines "name = value": the token that must be asked for, and starts of variables that are not
/// those of the list or of the vehicle's files.
struct UnitFile {
  std::string token;
  std::array<std::string, kTextCount> texts;
  struct Number {
    std::string name;
    double value;
  };
  std::vector<Number> numbers;
};

std::string format_unit_file(const UnitFile& unit);

/// Throws base::Error with file:line on what is no such line, names no variable, or a number out of
/// its bounds.
UnitFile parse_unit_file(std::string_view bytes, const std::string& path,
                         const std::vector<Variable>& list);

}  // namespace fmu
