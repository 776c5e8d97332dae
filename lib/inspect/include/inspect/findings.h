// What is wrong with a road file, found from its heights alone or against a reference.
#pragma once

#include <string>
#include <vector>

#include "inspect/height_map.h"
#include "inspect/kerb_strips.h"
#include "road/road_edges.h"

namespace road {

enum class Severity { remark, error };  ///< error: the road is not usable as it is

/// One place where something is wrong. kind is one of: tile_step, hole, nan_stripe, fold,
/// wrong_seam, bump, pothole, kerb_loss, deviation, no_reference, file, validation
/// (docs/report.md).
struct Finding {
  std::string kind;
  double u_begin_m = 0.0, u_end_m = 0.0;
  double v_begin_m = 0.0,
         v_end_m = 0.0;  ///< where it lies across; the whole road where it does not matter
  double value = 0.0;    ///< how large, in `unit`
  std::string unit;      ///< "m", "1", ...
  Severity severity = Severity::remark;
  std::string text;  ///< one plain sentence with place and size
};

/// Each bound stands well above what clean roads show (measured in
/// tests/inspect/findings_test.cpp and docs/report.md) and well below what it must catch.
struct FindingOptions {
  /// Smallest step of z between two rows, median over v. A clean class C road stays below 0.2 mm.
  double min_tile_step_m = 0.005;
  double max_tile_step_m = 0.03;  ///< beyond: error; a tyre's deflection at rest
  double min_tile_share = 0.5;    ///< of the columns that step the same way
  /// Smallest height of a bump or depth of a pothole over the quadratic through the road 3 to 9 m
  /// before and behind, or 5.5 times the scatter of its own column, whichever is more. Patches and
  /// undulations of up to 30 mm are ordinary road.
  double min_bump_m = 0.04;
  double max_bump_m = 0.3;         ///< beyond: error; no wheel follows, it is a wrong layer ...
  double max_crest_slope = 0.35;   ///< ... but for four humps or more, as wide as the road
  double min_seam_step_m = 0.002;  ///< a written float32 file keeps 1 mm
  double max_seam_step_m = 0.01;   ///< beyond: error; as ValidateLimits
  double min_seam_heading_rad = 0.002;
  double max_seam_heading_rad = 0.02;
  double max_seam_gap_m = 0.05;    ///< in the plan; more is no closed road
  double max_hole_m = kMaxHole_m;  ///< larger holes are errors: a wheel falls in
  std::size_t max_per_kind = 200;  ///< the rest is told in one finding
  bool closed = false;             ///< the file says that the road is closed
  RoadEdges edges;                 ///< of the rows: what lies beyond is a remark, never an error
  unsigned threads = 0;
};

/// Everything that shows without a reference, by kind and then u.
/// `kerbs`: their ends and edges are no bumps.
std::vector<Finding> find_defects(const HeightMap& map, const KerbStrips& kerbs,
                                  const FindingOptions& options = {});

/// Errors that lie beyond the edges of the road become remarks, and say so.
void mark_beyond(const RoadEdges& edges, const HeightMap& map, std::vector<Finding>& findings);

enum class Verdict { usable, usable_with_remarks, not_usable };
Verdict verdict_of(const std::vector<Finding>& findings);
const char* to_string(Verdict verdict);
const char* to_string(Severity severity);

}  // namespace road
