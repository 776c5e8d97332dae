#pragma once

#include <string>
#include <string_view>

#include "base/answer.h"

namespace base {

/// SHA-256 of a file's bytes as 64 hex digits. Throws Error.
std::string sha256_of_file(const std::string& path);

/// The same for those who can do without the file: a refusal in place of the Error.
Answer<std::string> try_sha256_of_file(const std::string& path);

/// The same of the program that runs, or of the module of Python that this is part of: results of
/// another one are not taken for its own.
const std::string& sha256_of_program();

/// The same of bytes in memory.
std::string sha256(std::string_view bytes);

}  // namespace base
