// What the modelDescription.xml of a Functional Mock-up Unit says (FMI 2.0 and 3.0, co-simulation).
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sim {

/// Types of values. FMI 2.0 has real (float64), integer (int32), boolean and string alone;
/// enumerations are read and written as int32 there, as int64 in FMI 3.0.
enum class ValueType {
  float64,
  float32,
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  boolean,
  string,
  other  ///< binary and clocks: told, not read
};

struct UnitVariable {
  std::string name, description, unit;
  std::string causality = "local", variability = "continuous";
  std::uint32_t reference = 0;
  ValueType type = ValueType::float64;
  std::size_t size = 1;  ///< values, of an array all of them; its first dimension varies slowest
  std::string start;     ///< as written; empty where none is
  /// Bounds of each value, where min and max of the variable or its declared type say them.
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool is_input() const { return causality == "input"; }
  bool is_output() const { return causality == "output"; }
};

struct UnitDescription {
  int version = 2;  ///< of FMI: 2 or 3
  std::string model_name, token, generation_tool;
  std::string identifier;  ///< of the binary
  bool needs_its_tool = false;
  bool can_be_instantiated_once_only = false;
  bool takes_any_step = false;
  bool keeps_states = false;  ///< they can be saved and set while it runs
  std::optional<double> start_s, stop_s, step_s, tolerance;  ///< of the default experiment
  std::vector<UnitVariable> variables;

  /// Null where no variable has this name.
  const UnitVariable* find(std::string_view name) const;
};

/// Reads a model description. `where` names it in messages. Throws Error on what is no model
/// description of FMI 2 or 3, has no co-simulation, names a binary outside its folder, a variable
/// twice, or holds more than 1 M variables or values.
UnitDescription read_unit_description(std::string_view xml, const std::string& where);

}  // namespace sim
