#pragma once

#include <cstddef>
#include <string>

namespace base {

constexpr std::size_t kAnySize = static_cast<std::size_t>(-1);

/// The bytes of a file. Throws Error when it is a folder or no regular file (a FIFO is refused at
/// once, not waited for), cannot be read, is larger than `largest_bytes` or is a pointer of Git LFS
/// in the place of the file; never takes more memory than that.
std::string read_file(const std::string& path, std::size_t largest_bytes = kAnySize);

/// The same refusal of what is no regular file, for readers that open the file themselves; one that
/// is missing is left to their words.
void want_regular_file(const std::string& path);

}  // namespace base
