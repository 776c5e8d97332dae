// Names of other loggers for what they measure at a wheel or an axle.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace explain {

/// What a name says of one wheel; of a brake's pressure, also of both wheels of an axle.
struct WheelWord {
  std::vector<std::string> channels;  ///< one, or the left and the right wheel's
  const char* quantity = nullptr;     ///< picks the unit table
};

/// A brake disc's temperature, a suspension's travel or a brake's pressure, in English, German,
/// French, Italian or Spanish. `name` of letters and digits alone. None: something else.
std::optional<WheelWord> wheel_word(const std::string& name);

}  // namespace explain
