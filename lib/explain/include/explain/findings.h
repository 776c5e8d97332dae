// What an analysis says, as plain values, and its JSON (docs/formats.md).
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "explain/unknowns.h"

namespace explain {

struct Place {
  double u_begin_m = 0.0, u_end_m = 0.0;
  std::vector<int> laps;
};
struct Mismatch {
  std::string channel, regime, unit;
  std::vector<Place> where;
  double size = 0.0, p_adjusted = 1.0, share_of_residual = 0.0;
};
struct ParameterValue {
  std::string id, name, unit;
  double stated = 0.0, value = 0.0, low = 0.0, high = 0.0;
  bool beyond_prior = false;
  bool at_limit = false;  ///< of the refit: these recordings do not determine it
  bool unsure = false;    ///< the recordings ask for it outside its prior width, not surely beyond
};
struct FoundParameter {
  std::string name, unit;
  double value = 0.0, low = 0.0, high = 0.0;
};
struct ProfilePoint {
  double u_m = 0.0, value = 0.0, ci90 = 0.0;
};
struct Rival {
  std::string mechanism, channel, separating_experiment;
  double cv_gain = 0.0;
  bool separable = true;
};
struct HeldOut {
  std::string channel, unit;
  double horizon_s = 0.6, rmse_before = 0.0, rmse_after = 0.0, drop_low = 0.0, drop_high = 0.0,
         trivial_rmse = 0.0;
  bool whole_car = false;  ///< lib/vehicle driving the recorded commands; else the relation alone
  /// Of the whole car alone: what goes on as it went last, and the drop with 90 % for all rows
  /// together. NaN: not measured.
  double trend_rmse = std::numeric_limits<double>::quiet_NaN(), sure_low = trend_rmse,
         sure_high = trend_rmse;
};
/// Heights to add to a road, in bins from its begin and `right_m`; bin (i, j) at i * columns + j.
struct HeightPatch {
  double u_step_m = 0.0, v_step_m = 0.0, right_m = 0.0;
  std::size_t columns = 0;
  std::vector<double> dz_m;
};
struct Finding {
  std::string mechanism, kind, channel, physics, equation;
  std::vector<Place> where;
  std::vector<FoundParameter> parameters;
  std::vector<ProfilePoint> profile;
  HeightPatch patch;  ///< of road.kerb_or_roughness; not in the JSON, it is in track.crg
  std::vector<Rival> rivals;
  double stability =
      std::numeric_limits<double>::quiet_NaN();  ///< share of half samples with the same sign, for
                                                 ///< discs of laps left out that fit better; NaN:
                                                 ///< not measured
  double cv_gain = 0.0, statistic = 0.0, threshold = 0.0;
  std::vector<HeldOut> held_out;
  std::size_t unknown = 0;  ///< place in the inventory
  std::string not_used;     ///< why it is not in the corrected inputs; empty: it is
};
struct Unexplained {
  std::string channel, locked_to, unit;
  std::vector<Place> where;
  double share = 0.0, p_adjusted = 1.0;
  double size = 0.0;  ///< mean of the residual there
};
/// One line of the evidence table: everything that was tried at the first step.
struct Evidence {
  std::string mechanism, channel, detail;
  double amount = 0.0, statistic = 0.0, cv_gain = 0.0;
  std::string unit;
  std::string place{};  ///< of a stretch of road: what detail goes on with
  double least = 0.0;   ///< smaller amounts are not worth a finding
};
/// Something that stands out of the noise of these recordings and is not named, and why not.
struct Seen {
  std::string mechanism, channel, detail, unit, why;
  double amount = 0.0, low = 0.0, high = 0.0;  ///< 90 %, by the score alone
  double statistic = 0.0;                      ///< standard deviations
};

/// Whether an item of an analysis (finding, rival, untestable) is about this mechanism.
template <class Item>
bool is_about(const Item& item, std::string_view id) {
  return id == item.mechanism;
}

/// Whether an item of an analysis (finding, rival, evidence) is about this unknown's mechanism in
/// its channel.
template <class Item>
bool is_of(const Item& item, const Unknown& u) {
  return std::tie(item.mechanism, item.channel) == std::tie(u.id, u.channel);
}
/// A relation along one recording, for the page.
struct Trace {
  std::string channel, unit;
  std::vector<double> u_m, before, after;
  std::vector<int> lap;
};
/// One lap of the whole simulated car on recorded commands, restarted from the recording every 8 s
/// (NaN between); for the page. Recorded: as the mapping of that side has it.
struct DrivenTrace {
  struct Side {
    std::vector<double> u_m, recorded, simulated;
  };
  std::string channel, unit;
  int lap = 0;
  Side before, after;
};

/// What an analysis says as a whole, from the weakest claim to the strongest doubt.
enum class Verdict {
  kNone,       ///< nothing is missing that these recordings can show
  kExplained,  ///< what was found explains everything significant
  kTie,        ///< something is missing, and two explanations cannot be told apart
  kUnknown,    ///< something is missing that no mechanism explains
  kNotJudged   ///< a column is broken: what hangs on it could not be looked at
};
/// As in findings.json: "none", "explained", "tie", "unknown", "not judged".
const char* name_of(Verdict verdict);

/// A sentence about the recordings, the car or the analysis.
struct Remark {
  enum class About {
    kAnalysis,  ///< stands under the verdict
    kRefit      ///< what the whole car was refitted to: stands beside its errors
  };
  std::string text;
  About about = About::kAnalysis;
  Remark(std::string sentence = {}, About of = About::kAnalysis)  // NOLINT: most are sentences
      : text(std::move(sentence)), about(of) {}
};

struct Findings {
  Verdict verdict = Verdict::kNone;  ///< of judge() alone
  std::vector<Mismatch> mismatches;
  std::vector<ParameterValue> parameters;
  std::vector<Finding> findings;
  std::vector<Untestable> untestable;
  std::vector<Unexplained> unexplained;
  std::vector<Evidence> evidence;
  std::vector<Trace> traces;
  std::vector<DrivenTrace> driven;
  std::vector<HeldOut> held_out;  ///< as in every finding; there without findings too
  std::vector<Remark> remarks;
  double null_false_alarm =
      0.0;  ///< share of null replicates that the thresholds would have let through
  std::size_t null_replicates = 0;
  double threshold = 0.0;              ///< of the first step, in standard deviations
  std::size_t laps = 0;                ///< counted at the line, begun ones too
  double rounds = 0.0;                 ///< driven in all; 0: the road is not closed
  bool doubtful_car = false;           ///< see doubt_the_car()
  bool broken_columns = false;         ///< Signals::broken, of any recording
  std::vector<double> recorded_lap_s;  ///< whole laps
  double simulated_lap_before_s = 0.0,
         simulated_lap_after_s = 0.0;  ///< of the built-in driver; 0: not driven
};

/// Of what was tried at the first step and is neither found nor a rival of what was: all whose
/// score is beyond what its own noise gives in one of a thousand, the most telling first. A stretch
/// of road is the best of many places: it stands out beyond the threshold only.
std::vector<Seen> seen_and_not_named(const Findings& findings);

/// findings.json. Numbers are rounded to 7 digits; the same findings give the same bytes.
std::string findings_json(const Findings& findings);

}  // namespace explain
