// modelDescription.xml of a unit.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "fmu/variables.h"

namespace fmu {

enum class Version { kFmi2, kFmi3 };

struct Description {
  std::string name;   ///< of the model, any bytes
  std::string token;  ///< guid of FMI 2, instantiation token of FMI 3
  std::string generation_tool;
  double step_s = 0.001;
  std::vector<double> starts;  ///< by value reference, of the numbers
  std::array<std::string, kTextCount> texts;
};

inline constexpr const char* kModelIdentifier = "kerbstone_car";

/// FMI 2.0.x lists every value, FMI 3.0 wheels as arrays of four. No output depends on an input at
/// the same time: inputs act in the next step. Throws base::Error where a unit has no definition.
std::string model_description(const Description& description, Version version);

}  // namespace fmu
