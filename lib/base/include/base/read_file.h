#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "base/answer.h"

namespace base {

constexpr std::size_t kAnySize = static_cast<std::size_t>(-1);

/// The bytes of a file. Throws Error when it is a folder or no regular file (a FIFO is refused at
/// once, not waited for), cannot be read, is larger than `largest_bytes` or is a pointer of Git LFS
/// in the place of the file; never takes more memory than that.
std::string read_file(const std::string& path, std::size_t largest_bytes = kAnySize);

/// The same for those who can do without the file: a refusal in place of the Error.
Answer<std::string> try_read_file(const std::string& path, std::size_t largest_bytes = kAnySize);

/// The same refusal of what is no regular file, for readers that open the file themselves; one that
/// is missing is left to their words.
std::optional<Refusal> no_regular_file(const std::string& path);
/// The same for those who cannot do without the file: throws it as Error.
void want_regular_file(const std::string& path);

}  // namespace base
