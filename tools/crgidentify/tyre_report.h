// A fitted tyre in words, as JSON and as curves.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "identify/drive_tyres.h"
#include "identify/tyre_conditions.h"
#include "identify/tyre_fit.h"
#include "identify/tyre_scan.h"

namespace crgidentify {

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
/// The page; `name` is the file's.
std::string tyre_page(const TyreResult& result, const vehicle::TyreCoefficients& reference,
                      const std::string& name);

}  // namespace crgidentify
