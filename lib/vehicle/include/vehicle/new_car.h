// From a data sheet to the files of a car.
#pragma once

#include <map>
#include <string>

#include "vehicle/data_sheet.h"

namespace vehicle {

/// The files of a car, text by name: vehicle.yaml, front.tir, rear.tir, engine.csv.
struct NewCar {
  std::map<std::string, std::string> files;
  std::size_t guessed = 0;  ///< parameters that the sheet does not tell
};

/// Every parameter that the sheet tells, or from which it follows, and the rest guessed by the kind
/// of car: marked in vehicle.yaml as assumed, with a prior, the range and why. Throws Error where
/// the sheet's numbers make no car.
NewCar make_new_car(const DataSheet& sheet);

}  // namespace vehicle
