#pragma once

#include <string>

namespace files {

/// SHA-256 of a file's bytes as 64 hex digits. Throws Error.
std::string sha256_of_file(const std::string& path);

}  // namespace files
