#pragma once

#include "base/error.h"

namespace road {

/// The one exception of lib/mesh, circuit, road, inspect and make.
using Error = base::Error;

/// No road can be made of it that a car may drive on.
using NotUsable = base::NotUsable;

}  // namespace road
