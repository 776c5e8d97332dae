#pragma once

#include "files/parallel.h"

namespace road {

using files::parallel_for;

}  // namespace road
