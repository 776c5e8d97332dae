#pragma once

#include <string>
#include <string_view>

namespace vehicle {

/// Writes `bytes` to a temporary name beside `path`, flushes, renames: a kill at any moment leaves
/// the old file or the new one. Throws Error with the path and the system's reason.
void write_file(const std::string& path, std::string_view bytes);

/// SHA-256 of a file's bytes as 64 hex digits. Throws Error.
std::string sha256_of_file(const std::string& path);

}  // namespace vehicle
