#include "explain/explain.h"

#include "analysis.h"
#include "explain/columns.h"
#include "explain/discs.h"
#include "explain/gyro_or_banking.h"
#include "explain/judge.h"
#include "explain/plausible_car.h"
#include "explain/short_waves.h"
#include "explain/wheels_say.h"
#include "mechanism.h"

namespace explain {
namespace {

/// Another car's file has other forces: what is named is what motion and sensors say without them.
void leave_out_forces(Findings& out, const Comparison& c, ExplainOptions options) {
  if (!out.doubtful_car) return;
  options.forces = false;
  Findings motion = explain_relations(c.logs, c.car, options);
  out.findings = std::move(motion.findings);
  out.unexplained = std::move(motion.unexplained);
  out.evidence = std::move(motion.evidence);
  out.traces = std::move(motion.traces);
  out.held_out = std::move(motion.held_out);
  out.threshold = motion.threshold;
  out.null_false_alarm = motion.null_false_alarm;
}

}  // namespace

Findings explain(const Comparison& c, const ExplainOptions& options) {
  const auto stage = [&](const char* name) {
    if (options.progress) options.progress(name, 0.0);
  };
  Findings out = explain_relations(c.logs, c.car, options);
  stage("short waves");
  add_short_waves(out, c.recordings, c.mapping, c.road, c.car);
  stage("brake discs");
  add_discs(out, c.recordings, c.mapping, c.car);
  doubt_the_car(out);
  leave_out_forces(out, c, options);
  tie_gain_with_banking(c.logs.front(), out);
  say_that_wheels_are_coupled(c.logs.front(), c.car, out);
  take_speeds_of_wheels_as_usual(c.logs.front(), out);
  name_late_columns(c.logs.front(), out);
  hold_back_beside_broken_columns(out);
  out.verdict = judge(out);
  return out;
}

Findings explain_relations(const std::vector<Signals>& logs, const vehicle::Vehicle& car,
                           const ExplainOptions& options) {
  Analysis a(logs, car, options);
  Findings out = a.begin();
  if (!a.enough_rows()) return out;
  if (!options.mechanisms) {
    a.refit(4);
    a.prove(out);
    return out;
  }
  a.find_banking_by_turning(out);
  a.find_road_profiles(out);
  a.refit(4);
  a.differentiate_candidates();
  a.free_parameters();
  a.name_by_score(out, Stage::kSensors);
  a.name_by_score(out, Stage::kForces);
  a.name_by_cost(out);
  a.free_what_was_kept_back();
  a.move_columns();
  a.drop_faded(out);
  a.free_what_is_beyond();
  a.list_untouched(out);
  a.describe(out);
  a.tell_banking_by_turning(out);
  a.find_leftovers(out);
  a.prove(out);
  join_components(out);
  a.list_untestable(out);
  if (options.progress) options.progress("done", 1.0);
  return out;
}

}  // namespace explain
