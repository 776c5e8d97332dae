// Where a text stands among those of an instance.
#pragma once

#include <cstddef>

#include "fmu/variables.h"

namespace fmu {

constexpr std::size_t place(Text text) { return static_cast<std::size_t>(text); }

}  // namespace fmu
