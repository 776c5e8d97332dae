// Whether the coefficients of a tyre can be.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>

#include "vehicle/tyre_file.h"

namespace vehicle {

/// The line that settled a keyword, for errors found after the whole file is read.
using TyrePlaces = std::map<std::string, std::size_t, std::less<>>;

/// Throws Error with file:line where a coefficient (SI units) cannot be a tyre's.
void check_tyre(const TyreCoefficients& tyre, const TyrePlaces& places, const std::string& name);

}  // namespace vehicle
