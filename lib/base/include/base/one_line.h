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

}  // namespace base
