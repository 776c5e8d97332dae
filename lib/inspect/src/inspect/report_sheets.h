// The sheets of the report: heights in space and what colours them. Private to the report.
#pragma once

#include <vector>

#include "crg/surface.h"
#include "inspect/findings.h"
#include "inspect/height_map.h"
#include "inspect/kerb_strips.h"
#include "report/track_report.h"
#include "report_curves.h"
#include "road/sample.h"

namespace road {

/// The whole road as a coarse grid in space, with a field for everything that is known of it.
/// `grip` and `provenance` may be null.
report::Sheet whole_road(const HeightMap& map, const AlongU& along, const Comparisons& comparisons,
                         const crg::Surface* grip, const std::vector<Provenance>* provenance);

/// Full detail around findings first, then kerbs from high to low.
void add_windows(const HeightMap& map, const std::vector<Finding>& findings,
                 const KerbStrips& kerbs, report::TrackReport& report);

/// Heights at every v, in rows about 0.25 m apart or as close as 3 MB of the page allow.
void add_detail(const HeightMap& map, report::TrackReport& report);

}  // namespace road
