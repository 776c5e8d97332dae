// The whole of `crgexplain run`: from files to a folder of files.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.h"
#include "explain/findings.h"
#include "explain/mapping.h"
#include "explain/page.h"

namespace explain {

constexpr double kMostFuelKg = 500.0;
constexpr std::size_t kLeastNulls = 100, kMostNulls = 100'000;

/// What is compared, by path, and how. Empty paths: not given.
struct ExplainRequest {
  std::string track_path, friction_path, vehicle_path, mapping_path, out_path;
  std::vector<std::string> recording_paths;
  std::vector<int> hold_out;     ///< laps, from 0 over all recordings, used only to judge
  unsigned threads = 0;          ///< 0: all; never changes the result
  std::size_t nulls = 1000;      ///< null replicates that set the thresholds
  double fuel_kg = 0.0;          ///< at the begin of each log, where none is logged; 0: not given
  bool skip_simulation = false;  ///< do not drive the whole simulated car before and after
};

/// What a simulation is to take from now on: corrected where something was found, as given
/// elsewhere.
struct CorrectedFiles {
  std::string track_path, friction_path, vehicle_path, mapping_path;
  std::optional<Mapping> mapping;  ///< of the recorded columns, if it was corrected
  double fuel_kg = 0.0;            ///< at the begin of the logs, given or found
};

struct ExplainedFiles {
  Findings findings;
  std::string findings_json;  ///< the text of OUT/findings.json
  std::string json_path, page_path;
  CorrectedFiles corrected;
  bool fuel_logged = false;    ///< in the recordings themselves
  std::vector<NextStep> next;  ///< as on the page
};

/// Reads, explains, drives the whole simulated car with what was found, and writes findings.json,
/// report.html and the corrected inputs into `out_path` (docs/crgexplain.md). A run that was
/// stopped is taken up where it was; `remark` is told so. Throws vehicle::Error, crg::Error.
ExplainedFiles explain_files(const ExplainRequest& request, const base::Progress& progress = {},
                             const std::function<void(const std::string&)>& remark = {});

}  // namespace explain
