// Pieces of road that lie off the reference, or where it has nothing. Private to the comparison.
#pragma once

#include <string>

#include "inspect/compare.h"
#include "kerb_losses.h"

namespace road {

/// Findings of the kinds deviation, no_reference, and kerb_loss where a ridge is lost that was not
/// recognised as a kerb. `map`: of the file. Places on kerbs are left to find_kerb_losses().
void find_deviations(const HeightMap& map, const ReferenceKerbs& reference, const std::string& name,
                     const CompareOptions& options, Comparison& result);

}  // namespace road
