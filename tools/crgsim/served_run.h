// What serve and race share: a unit's options from what was said, and what is told of its run.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands.h"
#include "sim/serve_unit.h"

namespace crgsim {

/// Reads the files that it names; what is seen is not kept yet. Throws Error and UsageError.
sim::ServeOptions options_of(const ServeCommand& command);

std::string ending_of(const sim::ServeRun& run);  ///< "by a command"
nlohmann::ordered_json json_of(const sim::ServeRun& run);
std::string summary_of(const sim::ServeRun& run, double step_s);
/// It was driven to its end, which is no failure, and all that it recorded are numbers.
bool is_sound(const sim::ServeRun& run);
std::vector<std::string> remarks_of(const sim::ServeRun& run);

}  // namespace crgsim
