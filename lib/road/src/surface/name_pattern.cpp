#include "road/name_pattern.h"

#include <fmt/format.h>
#include <re2/re2.h>

#include <cctype>

#include "mesh/error.h"

namespace road {
namespace {

/// Lower case outside escapes: \S must not become \s. RE2's own way to ignore case would take bytes
/// of other letters' encodings for one another.
std::string lower_case_pattern(std::string pattern) {
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] == '\\') {
      ++i;
    } else {
      pattern[i] = static_cast<char>(std::tolower(static_cast<unsigned char>(pattern[i])));
    }
  }
  return pattern;
}

}  // namespace

NamePattern::NamePattern(const std::string& pattern) {
  re2::RE2::Options options;
  options.set_encoding(re2::RE2::Options::EncodingLatin1);
  options.set_log_errors(false);
  options.set_never_capture(true);
  pattern_ = std::make_shared<const re2::RE2>(lower_case_pattern(pattern), options);
  if (!pattern_->ok()) {
    throw Error(fmt::format(
        "'{}' seen, a regular expression wanted, without look-ahead and back references ({})",
        pattern, pattern_->error()));
  }
}

bool NamePattern::is_in(std::string_view lower_case_name) const {
  return re2::RE2::PartialMatch(re2::StringPiece(lower_case_name.data(), lower_case_name.size()),
                                *pattern_);
}

}  // namespace road
