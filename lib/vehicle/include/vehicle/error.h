#pragma once

#include <stdexcept>

namespace vehicle {

/// The one exception of lib/vehicle: a file or a value that cannot be used. what() names the file
/// (and line where there is one), the value seen, the value wanted and what to do.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace vehicle
