#include "fmu/unit_definition.h"

#include <fmt/format.h>

#include <cctype>

#include "base/error.h"

namespace fmu {
namespace {

struct Symbol {
  std::string_view name;
  UnitDefinition unit;
};
constexpr Symbol kSymbols[] = {{"1", {}},
                               {"kg", {.kg = 1}},
                               {"m", {.m = 1}},
                               {"s", {.s = 1}},
                               {"K", {.K = 1}},
                               {"rad", {.rad = 1}},
                               {"N", {.kg = 1, .m = 1, .s = -2}},
                               {"Pa", {.kg = 1, .m = -1, .s = -2}},
                               {"J", {.kg = 1, .m = 2, .s = -2}},
                               {"W", {.kg = 1, .m = 2, .s = -3}},
                               {"MJ", {.kg = 1, .m = 2, .s = -2, .factor = 1e6}}};

/// Multiplies by the unit of a word such as "m2", or divides by it.
bool apply(std::string_view word, bool below, UnitDefinition& out) {
  int exponent = 1;
  if (word.size() > 1 && std::isdigit(static_cast<unsigned char>(word.back())) != 0) {
    exponent = word.back() - '0';
    word.remove_suffix(1);
  }
  if (below) exponent = -exponent;
  for (const Symbol& symbol : kSymbols) {
    if (symbol.name != word) continue;
    out.kg += exponent * symbol.unit.kg;
    out.m += exponent * symbol.unit.m;
    out.s += exponent * symbol.unit.s;
    out.K += exponent * symbol.unit.K;
    out.rad += exponent * symbol.unit.rad;
    for (int i = 0; i < exponent; ++i) out.factor *= symbol.unit.factor;
    for (int i = 0; i > exponent; --i) out.factor /= symbol.unit.factor;
    return true;
  }
  return false;
}

}  // namespace

UnitDefinition define_unit(std::string_view unit) {
  UnitDefinition out;
  bool below = false, good = !unit.empty();
  std::string word;
  const auto finish = [&] {
    if (!word.empty()) good = good && apply(word, below, out);
    word.clear();
  };
  for (const char c : unit) {
    if (c == ' ' || c == '.' || c == '(' || c == ')') {
      finish();
    } else if (c == '/') {
      finish();
      good = good && !below;
      below = true;
    } else {
      word += c;
    }
  }
  finish();
  if (!good)
    throw base::Error(fmt::format(
        "unit '{}' is not known; wanted a product of kg m s K rad N Pa J W MJ, say kg m/s2", unit));
  return out;
}

}  // namespace fmu
