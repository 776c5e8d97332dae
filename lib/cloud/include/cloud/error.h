#pragma once

#include "base/error.h"

namespace cloud {

/// The one exception of lib/cloud.
using Error = base::Error;

}  // namespace cloud
