#pragma once

#include "files/error.h"

namespace cloud {

/// The one exception of lib/cloud.
using Error = files::Error;

}  // namespace cloud
