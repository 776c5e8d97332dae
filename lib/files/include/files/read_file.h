#pragma once

#include <cstddef>
#include <string>

namespace files {

/// The bytes of a file. Throws Error when it is a folder, cannot be read or is larger than
/// `largest_bytes`; never takes more memory than that.
std::string read_file(const std::string& path, std::size_t largest_bytes);

}  // namespace files
