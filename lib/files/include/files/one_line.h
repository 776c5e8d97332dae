#pragma once

#include <string>

namespace files {

/// Text from a file or from another library's error, fit for one line of a message: control
/// characters become blanks.
inline std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
  return text;
}

}  // namespace files
