// How a tool ends.
#pragma once

#include <stdexcept>

namespace command {

/// Done; cannot be done; wrong command line; done, but the result must not be used. Ctrl-C ends a
/// tool with 130, SIGTERM with 143.
constexpr int kOk = 0, kFailed = 1, kUsage = 2, kNotValid = 3;

/// A command line that cannot be meant: exit code 2; what() is shown with a hint at --help.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The result was written, but must not be used: exit code 3.
class NotValid : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace command
