// Single numbers of a unit by their names. Private.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "sim/unit.h"

namespace sim {

/// A number of a variable: an array's [1], [2] ... or all there is.
struct Place {
  const UnitVariable* variable;
  std::size_t index = 0;
};

bool is_number(const UnitVariable& variable);

/// An input, or a parameter that may change while the unit runs.
bool is_settable(const UnitVariable& variable);

/// Empty, or what is wrong with a value for a variable: beyond its bounds, a fraction where it is a
/// whole number, neither 0 nor 1 where it is true or false.
std::string wrong_with(const UnitVariable& variable, double value);

/// "car.x is inf at 0.5 s" of the first such value; empty where all are finite.
std::string not_finite_of(const std::vector<std::string>& names, const std::vector<double>& values,
                          double time_s);

/// The variable of this name. Throws Error, with the unit's path, where there is none.
const UnitVariable& known(const UnitDescription& unit, const std::string& path,
                          const std::string& name);

/// The number of this name: a variable's with one value, or name[1], name[2] ... of an array.
Place place_of(const UnitDescription& unit, const std::string& path, const std::string& name);

/// The start called "road": what the car of a vehicle file drives on; empty: none.
std::string road_of(const std::vector<std::pair<std::string, std::string>>& starts);

/// Sets a variable from text, before initialisation.
void set_start(Unit& unit, const std::string& path, const std::string& name,
               const std::string& text);

}  // namespace sim
