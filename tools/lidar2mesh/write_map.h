#pragma once

#include <string>
#include <vector>

#include "base/output_set.h"
#include "cloud/map.h"
#include "commands.h"
#include "crg/file.h"
#include "road/summary.h"

namespace lidar2mesh {

/// Roads, surfaces, trajectory, timing and the summary in `outputs`; report.html too where the
/// command wants it. `facts`: the report of `result` with every remark. Returns what summary.json
/// holds.
std::string write_map(const MapCommand& command, const crg::Crg& base,
                      const cloud::MapResult& result, const cloud::MapReport& facts,
                      const std::vector<road::InputFile>& inputs, const base::OutputSet& outputs,
                      Terminal& terminal);

/// The same in a few lines.
void print_result(const MapCommand& command, const cloud::MapReport& facts,
                  const base::OutputSet& outputs, Terminal& terminal);

}  // namespace lidar2mesh
