// What the report says in words: facts, the file, its header, what was looked for. Private to the
// report.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "crg/file.h"
#include "inspect/findings.h"
#include "inspect/height_map.h"
#include "inspect/kerb_strips.h"
#include "inspect/validate.h"
#include "inspect/write_report.h"
#include "report/track_report.h"
#include "report_curves.h"

namespace road {

/// The name of a file without its folder.
std::string file_name(const std::string& path);

/// As the reader of the report finds it.
std::string shown_path(const std::string& path, const ReportRequest& request);

/// Sections of the file's header, and its comment.
void add_header(const crg::Crg& file, report::TrackReport& report);

/// The road in a few numbers, and the file that it lies in.
void add_facts(const HeightMap& map, const AlongU& along, const crg::Crg& file,
               const ReportRequest& request, const KerbStrips& kerbs,
               const std::optional<ValidateReport>& validated, report::TrackReport& report);

/// The road beside what is published of it: a fact each, and a remark where they disagree.
void add_published(const HeightMap& map, const AlongU& along, const ReportRequest& request,
                   std::vector<Finding>& findings, report::TrackReport& report);

/// The rules of the verdict with their limits and the largest that was seen on the road.
void add_rules(const FindingOptions& options, const ValidateLimits& limits,
               const std::vector<Finding>& findings, const std::optional<ValidateReport>& validated,
               report::TrackReport& report);

/// What would have been a finding; a clean verdict says no more than that.
void add_looked_for(const FindingOptions& options, const Comparisons& comparisons,
                    report::TrackReport& report);

}  // namespace road
