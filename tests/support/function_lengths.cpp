#include "support/function_lengths.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

namespace support {
namespace {

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool is_blank(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

/// Where what begins at `at` ends: a comment, a literal or a line of the preprocessor. `at`: none
/// of them begins there.
std::size_t end_of_aside(std::string_view s, std::size_t at, bool line_begins) {
  const auto after = [&](std::string_view end, std::size_t from) {
    const std::size_t found = s.find(end, from);
    return found == std::string_view::npos ? s.size() : found + end.size();
  };
  const std::string_view rest = s.substr(at);
  if (rest.starts_with("//")) return std::min(s.find('\n', at), s.size());
  if (rest.starts_with("/*")) return after("*/", at + 2);
  if (rest.starts_with("R\"") && (at == 0 || !is_word(s[at - 1]))) {
    const std::size_t open = std::min(s.find('(', at), s.size());
    return after(")" + std::string(s.substr(at + 2, open - at - 2)) + "\"", open);
  }
  const bool in_number = at > 0 && is_word(s[at - 1]);  // 1'000
  if (s[at] == '"' || (s[at] == '\'' && !in_number)) {
    std::size_t k = at + 1;
    while (k < s.size() && s[k] != s[at]) k += s[k] == '\\' ? 2 : 1;
    return std::min(k + 1, s.size());
  }
  if (s[at] != '#' || !line_begins) return at;
  std::size_t end = std::min(s.find('\n', at), s.size());
  while (end < s.size() && s[end - 1] == '\\') end = std::min(s.find('\n', end + 1), s.size());
  return end;
}

/// The source with blanks in place of comments and the preprocessor's lines, and '0' in place of
/// literals; lines stay where they are.
std::string without_asides(std::string_view s) {
  std::string out(s);
  bool line_begins = true;
  for (std::size_t at = 0; at < s.size();) {
    const std::size_t end = end_of_aside(s, at, line_begins);
    if (end == at) {
      line_begins = s[at] == '\n' || (line_begins && is_blank(s[at]));
      ++at;
      continue;
    }
    const bool is_literal = s[at] != '/' && s[at] != '#';
    for (; at < end; ++at)
      if (s[at] != '\n') out[at] = is_literal ? '0' : ' ';
  }
  return out;
}

enum class Brace { kScope, kFunction, kOther };

/// The text before a brace without what stands in parentheses and after "template <".
struct Head {
  std::string flat;  ///< "int add()const"
  bool has_parentheses = false, is_assigned = false, has_initialisers = false;
};

Head head_of(std::string_view text) {
  Head head;
  int depth = 0;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k], next = k + 1 < text.size() ? text[k + 1] : ' ';
    const char last = k > 0 ? text[k - 1] : ' ';
    if (c == '(' || c == '[') ++depth;
    if (depth == 0) {
      const bool compares =
          next == '=' || std::string_view("=<>!").find(last) != std::string_view::npos;
      head.is_assigned |= c == '=' && !compares &&
                          head.flat.find("operator") == std::string::npos &&
                          !head.flat.starts_with("template");
      head.has_initialisers |= c == ':' && next != ':' && last != ':' && head.has_parentheses;
      head.flat += c;
    }
    if (c == ')' || c == ']') {
      --depth;
      if (c == ')' && depth == 0) head.has_parentheses = true, head.flat += "()";
    }
  }
  while (!head.flat.empty() && is_blank(head.flat.back())) head.flat.pop_back();
  return head;
}

Brace kind_of(std::string_view text) {
  const Head head = head_of(text);
  const auto has_word = [&](std::string_view word) {
    for (std::size_t at = head.flat.find(word); at != std::string::npos;
         at = head.flat.find(word, at + 1)) {
      const std::size_t end = at + word.size();
      if ((at == 0 || !is_word(head.flat[at - 1])) &&
          (end == head.flat.size() || !is_word(head.flat[end])))
        return true;
    }
    return false;
  };
  const bool is_extern = head.flat.starts_with("extern") && head.flat.ends_with("0");
  if (is_extern || has_word("namespace")) return Brace::kScope;
  if (!head.has_parentheses || has_word("alignas"))
    for (const char* word : {"class", "struct", "union", "enum"})
      if (has_word(word)) return Brace::kScope;
  if (!head.has_parentheses || head.is_assigned) return Brace::kOther;
  // "Shape() : width_{1}, height_(2) {": only after ")" or "}" the body begins.
  const char last = head.flat.back();
  return !head.has_initialisers || last == ')' || last == '}' ? Brace::kFunction : Brace::kOther;
}

std::string name_of(std::string_view text) {
  const std::size_t call = text.find("operator()");
  std::size_t open = text.find('(', call == std::string_view::npos ? 0 : call + 10);
  open = std::min(open, text.size());
  std::size_t begin = open;
  while (begin > 0 && is_blank(text[begin - 1])) --begin;
  const std::size_t end = begin;
  const auto is_part = [](char c) { return !is_blank(c) && c != '*' && c != '&'; };
  while (begin > 0 && is_part(text[begin - 1])) --begin;
  return std::string(text.substr(begin, end - begin));
}

}  // namespace

std::vector<FunctionLength> function_lengths(std::string_view source) {
  const std::string text = without_asides(source);
  struct Open {
    Brace kind;
    std::size_t begin;  // of its head
    std::string name;
  };
  std::vector<Open> open;
  std::vector<FunctionLength> found;
  std::size_t begin = 0;  // of what may be a head
  int depth = 0;          // of parentheses
  const auto is_inside = [&](Brace kind) {
    return std::any_of(open.begin(), open.end(), [&](const Open& o) { return o.kind == kind; });
  };
  const auto line_of = [&](std::size_t at) {
    return 1 + static_cast<std::size_t>(
                   std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
  };
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    depth += c == '(' || c == '[' ? 1 : c == ')' || c == ']' ? -1 : 0;
    const bool is_free = depth == 0 && !is_inside(Brace::kFunction) && !is_inside(Brace::kOther);
    while (is_free && begin < at && is_blank(text[begin])) ++begin;
    if (c == ';' && is_free) begin = at + 1;
    if (c == '{') {
      const std::string_view head = std::string_view(text).substr(begin, at - begin);
      const Brace kind = is_free ? kind_of(head) : Brace::kOther;
      open.push_back({kind, begin, kind == Brace::kFunction ? name_of(head) : ""});
      if (kind == Brace::kScope) begin = at + 1;
    }
    if (c != '}') continue;
    if (open.empty()) throw std::runtime_error("a brace is closed that was not opened");
    const Open last = open.back();
    open.pop_back();
    if (last.kind == Brace::kFunction) {
      const std::size_t line = line_of(last.begin);
      found.push_back({last.name, line, line_of(at) - line + 1});
    }
    if (last.kind != Brace::kOther) begin = at + 1;
  }
  if (!open.empty()) throw std::runtime_error("a brace is not closed");
  return found;
}

}  // namespace support
