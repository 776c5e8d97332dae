// Walks over the lines of a text and the numbers of a line without copying.
#pragma once

#include <charconv>
#include <cstddef>
#include <limits>
#include <optional>
#include <string_view>

namespace base {

/// One line after the other, without line ends (LF, CR LF, or CR in a text without LF); number()
/// counts from 1.
class Lines {
 public:
  explicit Lines(std::string_view text)
      : rest_(text), end_(text.find('\n') == std::string_view::npos ? '\r' : '\n') {}

  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find(end_);
    line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    ++number_;
    return true;
  }
  std::size_t number() const { return number_; }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  char end_;
  std::size_t number_ = 0;
};

/// The text without the blanks, tabs and carriage returns at its ends.
inline std::string_view trimmed(std::string_view text) {
  // By hand: find_first_not_of calls memchr for each character, which a table of numbers feels.
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

/// The next word of `line` (blank or tab separated); empty at the end.
inline std::string_view take_word(std::string_view& line) {
  // A quarter of the time of reading a mesh went into asking find_first_of for these two.
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  std::size_t begin = 0;
  while (begin < line.size() && is_blank(line[begin])) ++begin;
  std::size_t end = begin;
  while (end < line.size() && !is_blank(line[end])) ++end;
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

/// The whole word as a number (nan and inf included), or nothing.
template <class Number>
std::optional<Number> to_number(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty()) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    // 1e999 is as unusable as infinity, 1e-999 as good as zero; from_chars tells them apart no
    // further.
    if constexpr (std::numeric_limits<Number>::has_infinity) {
      return word.find("e-") != std::string_view::npos || word.find("E-") != std::string_view::npos
                 ? Number{0}
                 : std::numeric_limits<Number>::infinity();
    }
    return std::nullopt;
  }
  if (error != std::errc{}) return std::nullopt;
  return value;
}

}  // namespace base
