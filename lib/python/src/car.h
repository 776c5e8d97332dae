// The car that Python holds.
#pragma once

#include <pybind11/pybind11.h>

#include "recording/table.h"
#include "vehicle/vehicle_file.h"

namespace kerbstone {

/// A car keeps referring to the files it was made of: neither moves.
struct Car {
  vehicle::Vehicle files;
  vehicle::Car<double> car{};
};

/// An array per column.
pybind11::dict by_name(const recording::Table& table);

}  // namespace kerbstone
