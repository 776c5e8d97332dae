// Numbers of a unit that follow a table over time. Private.
#pragma once

#include <string>
#include <vector>

#include "sim/run_unit.h"
#include "unit_places.h"

namespace sim {

/// Inputs, and parameters that may change while the unit runs, at a time, written into the unit
/// where they change.
class InputWriter {
 public:
  /// `inputs` has to stay. Throws Error, with the unit's path, on names of anything else.
  InputWriter(const UnitInputs& inputs, const UnitDescription& unit, const std::string& path);

  void write(Unit& unit, double time_s);  ///< times rise
  void restart();                         ///< of a new instance, from the begin

 private:
  const UnitInputs& inputs_;
  std::vector<Place> places_;
  std::vector<std::vector<double>> starts_, last_, written_;
  std::size_t row_ = 0;
};

}  // namespace sim
