// What the report shows of comparisons, kerbs and roughness. Private to the report.
#pragma once

#include <string>
#include <vector>

#include "inspect/compare.h"
#include "inspect/height_map.h"
#include "inspect/kerb_strips.h"
#include "report/track_report.h"
#include "report_curves.h"

namespace road {

/// `key` and `reference` name what the road was compared with.
report::ComparisonView view_of(const Comparison& c, std::string key, std::string reference);

/// Every kerb with its profile, in the file and in all that it was compared with.
void add_kerbs(const HeightMap& map, const KerbStrips& kerbs, const Comparisons& comparisons,
               report::TrackReport& report);

/// v between the wheel paths, in metres: 0 where nearly all of the road has both, else the middle.
double middle_of_road(const HeightMap& map, const std::vector<RowExtent>& extents);

/// Spectrum, class and IRI of both wheel paths.
/// The tracks of the road before refinement are left out where they ride as those after it.
void add_roughness(const HeightMap& map, double middle_m, bool before, report::TrackReport& report);

}  // namespace road
