#pragma once

#include <string>

namespace base {

/// What a file's name ends in, in lower case and with its dot: ".obj" of "A.OBJ", "" of "a".
std::string ending_of(const std::string& path);

}  // namespace base
