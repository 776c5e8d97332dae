#include "wkt.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <vector>

namespace cloud {
namespace {

constexpr int kDeepest = 32;  // real ones: 8

/// A keyword with what its brackets hold, or a number, a word, a string.
struct Part {
  std::string word;  ///< in capitals but for strings
  std::vector<Part> parts;

  bool is(std::initializer_list<const char*> words) const {
    return !parts.empty() && std::find(words.begin(), words.end(), word) != words.end();
  }
};

void drop(std::string_view& rest, std::string_view any_of) {
  rest.remove_prefix(std::min(rest.find_first_not_of(any_of), rest.size()));
}

/// Between quotes; two of them stand for one.
std::string quoted_text(std::string_view& rest) {
  std::string text;
  for (rest.remove_prefix(1); !rest.empty(); rest.remove_prefix(1)) {
    if (rest.starts_with("\"\""))
      rest.remove_prefix(1);
    else if (rest.front() == '"') {
      rest.remove_prefix(1);
      break;
    }
    text += rest.front();
  }
  return text;
}

Part next_part(std::string_view& rest, int depth) {
  constexpr std::string_view kSpace = " \t\r\n", kBetween = " \t\r\n,";
  Part out;
  drop(rest, kBetween);
  if (rest.starts_with('"')) {
    out.word = quoted_text(rest);
    return out;
  }
  const std::size_t end = std::min(rest.find_first_of(" \t\r\n,\"[]()"), rest.size());
  for (const char c : rest.substr(0, end))
    out.word += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  rest.remove_prefix(end);
  drop(rest, kSpace);
  if (!rest.starts_with('[') && !rest.starts_with('(')) return out;
  rest.remove_prefix(1);
  if (depth == kDeepest) rest = {};
  for (drop(rest, kBetween); !rest.empty(); drop(rest, kBetween)) {
    if (rest.starts_with(']') || rest.starts_with(')')) {
      rest.remove_prefix(1);
      break;
    }
    out.parts.push_back(next_part(rest, depth + 1));
  }
  return out;
}

/// The first such, the part itself or below it.
const Part* find(const Part& in, std::initializer_list<const char*> words) {
  if (in.is(words)) return &in;
  for (const Part& part : in.parts)
    if (const Part* const found = find(part, words)) return found;
  return nullptr;
}

/// Directly in this part.
std::optional<LengthUnit> unit_in(const Part& system) {
  for (const Part& part : system.parts) {
    if (!part.is({"UNIT", "LENGTHUNIT"}) || part.parts.size() < 2) continue;
    const std::string& factor = part.parts[1].word;
    double metres = 0.0;
    const auto [end, problem] =
        std::from_chars(factor.data(), factor.data() + factor.size(), metres);
    if (problem == std::errc() && end == factor.data() + factor.size() && metres > 0.0 &&
        std::isfinite(metres))
      return length_unit(part.parts[0].word, metres);
  }
  return std::nullopt;
}

std::optional<LengthUnit> unit_of_axis(const Part& system, std::ptrdiff_t axis) {
  for (const Part& part : system.parts)
    if (part.is({"AXIS"}) && axis-- == 0) return unit_in(part);
  return std::nullopt;
}

/// Of all axes together, else of this one.
std::optional<LengthUnit> unit_of(const Part& system, std::ptrdiff_t axis) {
  const std::optional<LengthUnit> of_all = unit_in(system);
  return of_all ? of_all : unit_of_axis(system, axis);
}

}  // namespace

LengthUnit length_unit(const std::string& name, double metres) {
  // Texts round: 0.3048006 is the US survey foot, 2e-6 from the other.
  for (const LengthUnit& known :
       {LengthUnit{"m", 1.0}, {"ft", 0.3048}, {"US survey ft", 1200.0 / 3937.0}})
    if (std::abs(metres / known.metres - 1.0) < 1e-7) return known;
  return {name, metres};
}

CoordinateSystem read_wkt(std::string_view text) {
  // Heights may stand beside the plan; a mark of byte order may stand before it.
  Part whole{"ALL", {}};
  const auto to_next = [&] {
    while (!text.empty() && std::isalpha(static_cast<unsigned char>(text.front())) == 0)
      text.remove_prefix(1);
    return !text.empty();
  };
  while (to_next()) whole.parts.push_back(next_part(text, 0));
  CoordinateSystem out;
  if (const Part* const plan = find(whole, {"PROJCS", "PROJCRS", "PROJECTEDCRS", "DERIVEDPROJCRS",
                                            "LOCAL_CS", "ENGCRS", "ENGINEERINGCRS"})) {
    out.name = plan->parts[0].word;
    out.plan = unit_of(*plan, 0);
    out.height = unit_of_axis(*plan, 2);
  } else {
    out.in_degrees =
        find(whole, {"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS", "GEODCRS", "GEODETICCRS"}) != nullptr;
  }
  if (const Part* const height = find(whole, {"VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"}))
    out.height = unit_of(*height, 0);
  return out;
}

}  // namespace cloud
