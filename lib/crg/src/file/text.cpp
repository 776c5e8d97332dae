#include "text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

namespace crg {

std::string_view trim(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string upper(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return result;
}

std::optional<double> parse_number(std::string_view text, std::string_view* rest) {
  text = trim(text);
  char buffer[64];
  std::size_t length = 0;
  std::size_t taken = 0;
  if (!text.empty() && text.front() == '+') ++taken;
  while (taken < text.size() && length < sizeof buffer) {
    const char c = text[taken];
    if (std::strchr("0123456789+-.eE", c) != nullptr && c != '\0') {
      buffer[length++] = c;
    } else if (c == 'd' || c == 'D') {
      buffer[length++] = 'e';
    } else {
      break;
    }
    ++taken;
  }
  // from_chars takes no "+" in front of an exponent-less mantissa, but does in exponents.
  double value = 0.0;
  const auto [end, status] = std::from_chars(buffer, buffer + length, value);
  if (status != std::errc() && status != std::errc::result_out_of_range) return std::nullopt;
  if (status == std::errc::result_out_of_range) {
    // Too small is zero; too large is no number. from_chars does not say which it was.
    const std::string_view digits(buffer, length);
    const std::size_t exponent = digits.find_first_of("eE");
    const bool small =
        exponent != std::string_view::npos && exponent + 1 < length && buffer[exponent + 1] == '-';
    if (!small) return std::nullopt;
    value = 0.0;
  }
  if (!std::isfinite(value)) return std::nullopt;
  if (rest != nullptr) {
    const std::size_t skipped = taken - length;
    *rest = text.substr(skipped + static_cast<std::size_t>(end - buffer));
  }
  return value;
}

std::string shortest(double value) {
  char buffer[40];
  const auto [end, status] = std::to_chars(buffer, buffer + sizeof buffer, value);
  return status == std::errc() ? std::string(buffer, end) : std::string("nan");
}

}  // namespace crg
