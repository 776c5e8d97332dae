// Whole text files in and out. Private to the readers and writers of this library.
#pragma once

#include <cstddef>
#include <string>

namespace vehicle {

/// The bytes of a file. Throws Error when it cannot be read or is larger than `largest_bytes`.
std::string read_text(const std::string& path, std::size_t largest_bytes);

}  // namespace vehicle
