#pragma once

#include <string>

namespace base {

/// A path or another word as a shell takes it: in quotes where it needs them.
std::string shell_word(const std::string& word);

}  // namespace base
