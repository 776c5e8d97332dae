// Errors over the whole road as a map of cells, and what it says. Private to the comparison.
#pragma once

#include <span>
#include <vector>

#include "inspect/compare.h"
#include "inspect/height_map.h"

namespace road {

/// Sets the cells of `result`.
void make_error_map(const HeightMap& map, const ReferenceHeights& reference,
                    const CompareOptions& options, Comparison& result);

/// Sets quantiles, mean, shares and the histogram from the cells.
void make_statistics(Comparison& result);

/// Those of `known` that their cells now show.
std::vector<PlaceError> show_known(std::span<const PlaceError> known, Comparison& result);

/// Sets the worst places, `shown` where they lie in a cell.
void find_worst(const HeightMap& map, const ReferenceHeights& reference,
                const CompareOptions& options, const std::vector<PlaceError>& shown,
                Comparison& result);

}  // namespace road
