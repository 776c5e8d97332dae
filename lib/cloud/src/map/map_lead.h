// What a map did to a road: where it was measured, how well, and where not.
#pragma once

#include "cloud/map.h"
#include "report/track_report.h"

namespace cloud {

/// For the top of the page. `u_begin_m`, `u_step_m`: of the grid's rows.
std::vector<report::Fact> lead_of(const MapResult& result, double u_begin_m, double u_step_m);

/// The sheet coloured by it: measured, beside measured, base only.
report::SheetField completeness_of(const report::Sheet& sheet, const crg::Grid& source,
                                   double u_begin_m);

}  // namespace cloud
