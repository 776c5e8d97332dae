// Tables whose cells stand between blanks.
#include <algorithm>
#include <string>
#include <vector>

#include "base/text_lines.h"
#include "readers.h"

namespace recording {

std::string blanks_to_commas(std::string_view text) {
  constexpr std::size_t kLinesToSee = 8;
  const auto cells_of = [](std::string_view line) {
    line = base::trimmed(line);
    while (line.starts_with('#')) line = base::trimmed(line.substr(1));
    std::vector<std::string_view> out;
    while (!line.empty()) out.push_back(base::take_word(line));
    return out;
  };
  const auto is_number = [](std::string_view cell) {
    return base::to_number<double>(cell).has_value();
  };
  std::string_view line;
  std::size_t seen = 0, names = 0, cells = 0;  // the names stand right above the numbers
  for (base::Lines lines(text); seen < kLinesToSee && lines.next(line);) {
    for (const char separator : {',', ';', '\t'})
      if (line.find(separator) != std::string_view::npos) return {};
    const std::vector<std::string_view> words = cells_of(line);
    if (words.empty()) continue;
    if (!std::all_of(words.begin(), words.end(), is_number)) {
      if (cells != 0 && !line.starts_with('#')) return {};
      if (cells == 0) names = words.size();
      continue;
    }
    if (cells == 0) cells = names == 0 ? words.size() : names;  // 0: refused as without names
    if (words.size() != cells || cells < 2) return {};
    ++seen;
  }
  if (seen < 2) return {};
  std::string out;
  out.reserve(text.size());
  for (base::Lines lines(text); lines.next(line);) {
    const std::vector<std::string_view> words = cells_of(line);
    if (words.size() == cells)
      for (std::size_t c = 0; c < cells; ++c) (out += c == 0 ? "" : ",") += words[c];
    else
      out += line;  // refused with its place
    out += '\n';
  }
  return out;
}

}  // namespace recording
