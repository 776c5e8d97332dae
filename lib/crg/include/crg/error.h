#pragma once

#include <stdexcept>

namespace crg {

/// The one exception of lib/crg: a file or a value that cannot be used. what() names the file and
/// line or byte offset where there is one, the value seen, the value wanted and what to do.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace crg
