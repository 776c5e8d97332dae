// Names as they are compared: "GPS Latitude" and "gps_latitude" are one.
#pragma once

#include <string>
#include <string_view>

namespace base {

/// The letters of a text in lower case, and nothing else; bytes beyond ASCII are no letters.
inline std::string letters_of(std::string_view text, bool with_digits = false) {
  std::string out;
  for (const char c : text) {
    if ((c >= 'a' && c <= 'z') || (with_digits && c >= '0' && c <= '9')) out += c;
    if (c >= 'A' && c <= 'Z') out += static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

/// The same with its digits.
inline std::string letters_and_digits_of(std::string_view text) { return letters_of(text, true); }

}  // namespace base
