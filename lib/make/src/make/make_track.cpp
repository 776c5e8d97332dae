#include "make/make_track.h"

#include <algorithm>
#include <filesystem>

#include "base/output_set.h"
#include "base/read_file.h"
#include "base/write_file.h"
#include "crg/file.h"
#include "make/make_road.h"
#include "make_steps.h"
#include "report/track_report.h"
#include "road/track_crg.h"

namespace road {

namespace {

/// The set of the last run, where it is what this run would write.
std::optional<BuildResult> unchanged(const Recipe& recipe, const std::vector<InputFile>& inputs,
                                     bool with_report, const base::OutputSet& outputs) {
  const std::vector<std::string> there = outputs.confirmed({clean_cache_name(recipe), kTimingName});
  const auto has = [&](const std::string& name) {
    return std::find(there.begin(), there.end(), name) != there.end();
  };
  if (!has(road_name(recipe)) || !has(kSummaryName)) return std::nullopt;
  if (with_report && !(has("report.json") && (has("report.html") || !report::page_available())))
    return std::nullopt;
  BuildResult result = paths_of(recipe, outputs);
  BuildSummary fresh;
  fresh.recipe = recipe;
  fresh.inputs = inputs;
  const auto text = unchanged_summary(result.summary_path, fresh);
  if (!text) return std::nullopt;
  result.summary_json = *text;
  result.validation_failures = failures_in_summary(*text);
  if (const std::string name = recipe.name + ".patches"; has(name))
    result.patches_path = outputs.path(name);
  if (has(kTimingName)) result.timing_json = base::read_file(result.timing_path);
  result.reused = true;
  return result;
}

BuildEvidence evidence_of(MadeRoad built) {
  BuildEvidence evidence;
  if (built.before) evidence.before = track_crg(built.line, std::move(*built.before));
  evidence.mesh = std::move(built.mesh);
  evidence.provenance = std::move(built.sampled.provenance);
  const CentrelineReport& line = built.summary.centreline;
  evidence.road_width_m = {line.width_min_m, line.width_median_m, line.width_max_m};
  evidence.kerbs = std::move(built.summary.kerb.kerbs);
  evidence.edges = std::move(built.edges);
  evidence.limits = limits_of(built.summary);
  evidence.validate = std::move(built.summary.validate);
  return evidence;
}

}  // namespace

std::string clean_cache_name(const Recipe& recipe) { return recipe.name + ".clean.cache"; }

BuildResult make_track(const Recipe& recipe, const std::string& output_dir,
                       const Progress& progress, BuildEvidence* evidence, Reuse reuse) {
  base::OutputSet outputs(output_dir, kBuildCommand);
  BuildResult result = make_track(recipe, outputs, progress, evidence, reuse);
  commit_build(recipe, result, outputs);
  return result;
}

void commit_build(const Recipe& recipe, const BuildResult& result, base::OutputSet& outputs) {
  if (!result.reused) outputs.commit(recipe.name, result.kept, {kTimingName});
}

BuildResult make_track(const Recipe& recipe, base::OutputSet& outputs, const Progress& progress,
                       BuildEvidence* evidence, Reuse reuse) {
  const Clock::time_point start = Clock::now();
  const std::vector<InputFile> inputs = inputs_of(recipe);
  if (reuse == Reuse::everything)
    if (auto result = unchanged(recipe, inputs, evidence != nullptr, outputs)) return *result;

  const std::string question = outputs.path(recipe.name + ".question.png");
  MakeOptions options;
  options.progress = progress;
  options.question_path = question;
  if (reuse != Reuse::nothing) options.clean_cache_path = outputs.path(clean_cache_name(recipe));
  options.clean_staged_path = outputs.staged(clean_cache_name(recipe));
  options.keep_before = evidence != nullptr;
  MadeRoad built = make_road(recipe, inputs, options);
  BuildResult result = write(built, outputs, progress);
  if (result.clean_reused) result.kept.push_back(clean_cache_name(recipe));
  std::filesystem::remove(question);  // answered
  result.timing_json = timing_json(built.seconds, seconds_since(start));
  base::write_file(outputs.staged(kTimingName), result.timing_json);
  if (evidence) *evidence = evidence_of(std::move(built));
  return result;
}

}  // namespace road
