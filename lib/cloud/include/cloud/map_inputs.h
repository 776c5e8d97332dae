// What `map` and `split` make of a request.
#pragma once

#include <string>
#include <vector>

#include "cloud/filter.h"
#include "cloud/map.h"
#include "cloud/refine.h"
#include "crg/file.h"

namespace cloud {

/// With their hashes.
std::vector<road::InputFile> inputs_of(const RefineRequest& request, bool in_map);

/// The base as a road file: read, or built from a mesh without kerb columns or smoothing; then the
/// files that the mesh refers to are added to the inputs.
crg::Crg read_base(const RefineRequest& request, std::vector<road::InputFile>& inputs);

MapOptions map_options(const RefineRequest& request);

/// Of outliers, and thinning. Throws Error where the former are no such numbers, or where they need
/// PCL and there is none.
FilterOptions filter_options(const std::vector<double>& outliers, double voxel_m);

/// What was seen in the scans and left out of them.
std::vector<std::string> remarks_of(const std::vector<std::string>& of_scans,
                                    const FilterOptions& filter, const FilterReport& left_out);

}  // namespace cloud
