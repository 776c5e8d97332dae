// The data of a report as JSON: all of report.json, and what the page shares with it. Private to
// track_report.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "report/track_report.h"

namespace report {

using Json = nlohmann::ordered_json;

/// A list; null for what is not finite.
template <typename Values>
Json numbers(const Values& values) {
  Json list = Json::array();
  for (const auto value : values) {
    if (std::isfinite(value))
      list.push_back(value);
    else
      list.push_back(nullptr);
  }
  return list;
}

/// What both forms have in common.
Json common_json(const TrackReport& report);

/// Text that need not be UTF-8; `indent` -1 puts all on one line.
std::string dump(const Json& json, int indent);

}  // namespace report
