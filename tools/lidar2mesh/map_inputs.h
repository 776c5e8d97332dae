// What `map` and `split` make of their command line.
#pragma once

#include <string>
#include <vector>

#include "cloud/filter.h"
#include "cloud/map.h"
#include "commands.h"
#include "crg/file.h"

namespace lidar2mesh {

/// With their hashes.
std::vector<road::InputFile> inputs_of(const MapCommand& command, bool in_map);

/// The base as a road file: read, or built from a mesh without kerb columns or smoothing; then the
/// files that the mesh refers to are added to the inputs.
crg::Crg read_base(const MapCommand& command, std::vector<road::InputFile>& inputs);

cloud::MapOptions map_options(const MapCommand& command);

/// What was seen in the scans and left out of them.
std::vector<std::string> remarks_of(const std::vector<std::string>& of_scans,
                                    const cloud::FilterOptions& filter,
                                    const cloud::FilterReport& left_out);

}  // namespace lidar2mesh
