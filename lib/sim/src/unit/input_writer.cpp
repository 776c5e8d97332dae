#include "input_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "base/error.h"

namespace sim {

InputWriter::InputWriter(const UnitInputs& inputs, const UnitDescription& unit,
                         const std::string& path)
    : inputs_(inputs) {
  for (const std::string& name : inputs.names) {
    const Place place = place_of(unit, path, name);
    if (!is_settable(*place.variable))
      throw base::Error(fmt::format(
          "{}: {} is no input of the unit and no tunable parameter, its causality is '{}'", path,
          name, place.variable->causality));
    places_.push_back(place);
    auto& values = starts_.emplace_back(place.variable->size, 0.0);
    if (place.variable->size > 1 && !place.variable->start.empty()) {
      std::istringstream words(place.variable->start);
      for (double& value : values) words >> value;
    }
  }
  restart();
}

void InputWriter::restart() {
  row_ = 0;
  last_ = starts_;
  written_.assign(starts_.size(), {});
}

void InputWriter::write(Unit& unit, double time_s) {
  if (inputs_.time_s.empty()) return;
  const std::size_t columns = places_.size();
  while (row_ + 1 < inputs_.time_s.size() && inputs_.time_s[row_ + 1] <= time_s) ++row_;
  const bool between = row_ + 1 < inputs_.time_s.size() && time_s > inputs_.time_s[row_];
  for (std::size_t k = 0; k < columns; ++k) {
    const UnitVariable& variable = *places_[k].variable;
    double value = inputs_.values[row_ * columns + k];
    if (between && (variable.type == ValueType::float64 || variable.type == ValueType::float32)) {
      const double begin_s = inputs_.time_s[row_], end_s = inputs_.time_s[row_ + 1];
      value += (inputs_.values[(row_ + 1) * columns + k] - value) * (time_s - begin_s) /
               (end_s - begin_s);
    }
    // All values of an array are in the list of its first place.
    std::size_t list = k;
    for (std::size_t other = 0; other < k; ++other)
      if (places_[other].variable == places_[k].variable) list = std::min(list, other);
    last_[list][places_[k].index] = value;
    const bool is_last_of_it =
        std::none_of(places_.begin() + static_cast<std::ptrdiff_t>(k) + 1, places_.end(),
                     [&](const Place& p) { return p.variable == places_[k].variable; });
    if (!is_last_of_it || written_[list] == last_[list]) continue;
    unit.set(variable, last_[list]);
    written_[list] = last_[list];
  }
}

}  // namespace sim
