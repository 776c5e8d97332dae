#pragma once

#include "base/error.h"

namespace road {

/// The one exception of lib/mesh, circuit, road, inspect and make.
using Error = base::Error;

/// What was given can be read, but no road can be made of it that a car may drive on.
class NotUsable : public Error {
 public:
  using Error::Error;
};

}  // namespace road
