#pragma once

#include <string>
#include <string_view>

namespace base {

/// Words that may come from a file or from another library, fit for one line: runs of control
/// characters become one blank, none stands at the end, and of more than 1,500 bytes the middle
/// is left out.
inline std::string one_line(std::string_view words) {
  constexpr std::size_t kMost = 1500;
  std::string line;
  for (const char c : words) {
    const bool control = static_cast<unsigned char>(c) < 32 || c == 127;
    if (!control)
      line += c;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  if (line.size() > kMost) line.replace(kMost / 2, line.size() - kMost, " ... ");
  return line;
}

/// Words that may come from a file or from foreign code, fit for a terminal: control characters,
/// those of Unicode too (U+0080 to U+009F), become "\\x1b"; with `keeps` those in it stay.
inline std::string visible(std::string_view words, std::string_view keeps = {}) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string out;
  const auto show = [&](unsigned char c) {
    out += "\\x";
    out += kDigits[c >> 4];
    out += kDigits[c & 15];
  };
  for (std::size_t k = 0; k < words.size(); ++k) {
    const auto c = static_cast<unsigned char>(words[k]);
    const auto next = k + 1 < words.size() ? static_cast<unsigned char>(words[k + 1]) : 0u;
    if (c == 0xC2 && next >= 0x80 && next < 0xA0) {
      show(c);
      show(static_cast<unsigned char>(next));
      ++k;
    } else if ((c < 32 || c == 127) && keeps.find(words[k]) == std::string_view::npos) {
      show(c);
    } else {
      out += words[k];
    }
  }
  return out;
}

}  // namespace base
