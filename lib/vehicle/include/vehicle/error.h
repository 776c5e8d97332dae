#pragma once

#include "base/error.h"

namespace vehicle {

/// The one exception of lib/vehicle.
using Error = base::Error;

}  // namespace vehicle
