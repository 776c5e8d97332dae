// A fitted tyre in words, as JSON and as curves.
#pragma once

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "base/interval90.h"
#include "identify/drive_tyres.h"
#include "identify/tyre_fit.h"

namespace crgidentify {

using base::kNormal90;

inline constexpr double kDegree = std::numbers::pi / 180.0;

struct TyreResult {
  identify::TyreFit fit;
  identify::TyreConditions conditions;
  std::vector<identify::TyreFault> faults;  ///< within what was measured
  std::size_t rows_given = 0, rows_left_out = 0;
  // Of drives; no rows: a bench.
  identify::HeldOut held_fitted, held_reference;
  double tyre_k = 0.0;  ///< median of the treads
};

std::string tyre_text(const TyreResult& result);
nlohmann::ordered_json tyre_json(const TyreResult& result);
/// Curves with their bands, the rows beside them, what is left by condition, and of drives what was
/// kept back; `name` is the file's. `samples`: the rows that were fitted; `drives`: where from, no
/// rows of a bench.
std::string tyre_page(const TyreResult& result, const identify::TyreSamples& samples,
                      const identify::DriveTyres& drives,
                      const vehicle::TyreCoefficients& reference, const std::string& name);

/// An interval between edges in words.
template <std::size_t n>
std::string span_of(const std::array<double, n>& edges, std::size_t i) {
  return i + 1 < n ? fmt::format("{:g} to {:g}", edges[i], edges[i + 1])
                   : fmt::format("over {:g}", edges[i]);
}
/// What a coefficient or a cell is of.
const char* word(identify::SlipKind kind);

}  // namespace crgidentify
