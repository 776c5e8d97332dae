#pragma once

#include "files/error.h"

namespace road {

/// The one exception of lib/road.
using Error = files::Error;

}  // namespace road
