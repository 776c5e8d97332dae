#pragma once

#include <stdexcept>

namespace files {

/// Input that cannot be used, or a file that cannot be read or written: the one exception of this
/// library and of those above it (road::Error, vehicle::Error). what() names the file (and line
/// where there is one), the value seen, the value wanted and what to do.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace files
