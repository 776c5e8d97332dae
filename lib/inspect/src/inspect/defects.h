// What find_defects() looks for, one file each. Private to the findings.
#pragma once

#include <string>
#include <vector>

#include "inspect/findings.h"

namespace road {

/// A finding over the whole width of the road.
Finding finding(const HeightMap& map, const char* kind, double u_begin_m, double u_end_m,
                double value, const char* unit, Severity severity, std::string text);

/// tile_step: places where most of the width steps at once.
std::vector<Finding> find_tile_steps(const HeightMap& map, const FindingOptions& options);

/// hole: pieces without height between others; nan_stripe goes to `stripes`, also where `road`,
/// what lies between the edges of the map, loses most of its width.
std::vector<Finding> find_missing(const HeightMap& map, const HeightMap& road,
                                  const FindingOptions& options, std::vector<Finding>& stripes);

/// fold: bends that are tighter than the road is wide.
std::vector<Finding> find_folds(const HeightMap& map);

/// wrong_seam: steps, kinks and gaps where the road closes.
std::vector<Finding> find_seam_faults(const HeightMap& map, const FindingOptions& options);

/// bump, pothole: heights over what lies before and behind, but for kerbs and echoes of `steps`.
std::vector<Finding> find_bumps(const HeightMap& map, const KerbStrips& kerbs,
                                const FindingOptions& options, const std::vector<Finding>& steps);

}  // namespace road
