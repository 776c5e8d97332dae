#pragma once

#include <string>
#include <vector>

#include "base/output_set.h"
#include "cloud/map.h"
#include "commands.h"
#include "crg/file.h"
#include "road/summary.h"

namespace lidar2mesh {

/// Writes roads, surfaces, trajectory, timing and the summary, report.html too where the command
/// wants it, and prints the same in a few lines. `remarks` are added to those of the result. Throws
/// NotValid, after that, where the road must not be used.
int hand_out_map(const MapCommand& command, const crg::Crg& base, const cloud::MapResult& result,
                 const std::vector<std::string>& remarks,
                 const std::vector<road::InputFile>& inputs, base::OutputSet& outputs,
                 Terminal& terminal);

}  // namespace lidar2mesh
