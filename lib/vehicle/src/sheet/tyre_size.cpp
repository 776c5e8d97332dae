#include "tyre_size.h"

#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <vector>

namespace vehicle {
namespace {

constexpr double kInch_m = 0.0254;

/// The three numbers of a size and what stands before the second; nothing where it has others.
struct SizeParts {
  std::vector<double> numbers;
  char between = ' ';
};

SizeParts parts_of(const std::string& name) {
  SizeParts out;
  const char *at = name.data(), *const end = at + name.size();
  while (at != end) {
    double number = 0.0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error == std::errc()) {
      out.numbers.push_back(number < 0.0 ? -number : number);
      at = next;
      continue;
    }
    if (out.numbers.size() == 1)
      out.between = static_cast<char>(std::tolower(static_cast<unsigned char>(*at)));
    ++at;
  }
  return out;
}

}  // namespace

base::Answer<TyreSize> tyre_size(const std::string& name) {
  const base::Refusal refusal(
      fmt::format("'{}' is no size of a tyre; wanted 215/40R18 (mm, %, inch), 325/705R18 (mm, mm, "
                  "inch) or 18x7.5-10 (inch: outer diameter, width, rim)",
                  name.substr(0, 40)));
  const SizeParts parts = parts_of(name);
  if (parts.numbers.size() < 3) return refusal;  // a load index may follow
  const double first = parts.numbers[0], second = parts.numbers[1];
  TyreSize out;
  out.rim_m = parts.numbers[2] * kInch_m;
  if (parts.between == 'x') {
    out.radius_m = 0.5 * first * kInch_m;
    out.width_m = second * kInch_m;
  } else if (parts.between == '/' && first < 100.0) {
    out.width_m = 0.01 * first;
    out.radius_m = 0.005 * second;
  } else if (parts.between == '/') {
    out.width_m = 0.001 * first;
    out.radius_m = second > 120.0 ? 0.0005 * second : 0.5 * out.rim_m + 0.01 * second * out.width_m;
  } else {
    return refusal;
  }
  const bool can_be = out.radius_m > 0.08 && out.radius_m < 0.8 && out.width_m > 0.05 &&
                      out.width_m < 0.6 && out.rim_m > 0.08 && out.rim_m < 1.9 * out.radius_m;
  if (!can_be) return refusal;
  return out;
}

}  // namespace vehicle
