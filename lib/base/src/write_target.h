// Where a file that is named goes. Private.
#pragma once

#include <cerrno>
#include <string>

namespace base {

/// Throws Error of a file that cannot be written.
[[noreturn]] void fail_to_write(const std::string& path, const char* what, int reason = errno);

std::string folder_of(const std::string& path);  ///< ends with '/', or "."

/// Where the bytes go.
struct Target {
  int descriptor = -1;   ///< of this process, to be written through
  std::string path;      ///< links followed
  bool through = false;  ///< something that is there and no regular file
};

/// Throws Error where no file can be.
Target find_target(const std::string& path);

/// Opens what is written through; to be closed. Throws Error, which names `path`.
int open_through(const Target& target, const std::string& path);

}  // namespace base
