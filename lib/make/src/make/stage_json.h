// What the stages report, as JSON. Private to the summary.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "make/summary.h"

namespace road {

using Json = nlohmann::ordered_json;

Json json_of(const Recipe& recipe);
Json json_of(const std::vector<InputFile>& inputs);
Json json_of(const MeshReadReport& report);
Json json_of(const CleanReport& report);
Json json_of(const CentrelineReport& report);
Json json_of(const ReferenceLineReport& report);
Json json_of(const std::vector<URange>& ranges);
Json json_of(const SampleReport& report);
Json json_of(const RoadEdges& edges, double u_step_m);  ///< every row that is about 1 m on
Json json_of(const Placement& placement);
Json json_of(const GridReport& report);
Json json_of(const GeoEnds& ends);
Json json_of(const ValidateReport& report, const ValidateLimits& limits);

}  // namespace road
