#pragma once

#include "files/error.h"

namespace vehicle {

/// The one exception of lib/vehicle.
using Error = files::Error;

}  // namespace vehicle
