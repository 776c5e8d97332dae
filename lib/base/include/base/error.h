#pragma once

#include <stdexcept>
#include <string_view>

#include "base/one_line.h"

namespace base {

/// Input that cannot be used, or a file that cannot be read or written: the one exception of this
/// library and of those above it (road::Error, vehicle::Error). what() names the file (and line
/// where there is one), the value seen, the value wanted and what to do, in one line, whatever the
/// file holds that it quotes.
class Error : public std::runtime_error {
 public:
  explicit Error(std::string_view what) : std::runtime_error(one_line(what)) {}
};

/// What was given can be read, but nothing can be made of it that may be used.
class NotUsable : public Error {
 public:
  using Error::Error;
};

}  // namespace base
