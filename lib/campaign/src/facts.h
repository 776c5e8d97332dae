#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "campaign/results.h"

namespace campaign {

/// The facts that are kept of what a job's command printed with --json; what is not there or is no
/// number is left out. A kind that is not known has none.
std::vector<Fact> facts_of(const std::string& kind, const nlohmann::json& said);

/// Factor and unit in which a fact is easily read: (1e3, "mm") for errors in metres.
struct Shown {
  double factor = 1.0;
  std::string unit;
};
Shown shown(const std::string& kind, const Fact& fact);

}  // namespace campaign
