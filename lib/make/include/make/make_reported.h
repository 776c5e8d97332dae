// A build as it is ordered: a file, recipe keys as text, a folder. With the report of the road.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/progress.h"
#include "inspect/write_report.h"
#include "make/make_track.h"
#include "make/recipe.h"

namespace road {

/// Recipe keys as text, in the order in which they were given: {"u_step_m", "0.05"}.
using RecipeValues = std::vector<std::pair<std::string, std::string>>;

/// The flag of a recipe key: --u-step-m of u_step_m.
std::string flag_of(std::string key);

/// Whether the flag stands alone, "--reverse", and takes no value.
bool is_switch(const RecipeKey& key);

/// A recipe (.yaml, .yml), or the defaults for a bare mesh.
Recipe recipe_of(const std::string& input);

/// Sets these keys on top of what the recipe says; one way of alignment replaces another. Throws
/// Error naming the flag.
void set_values(const RecipeValues& values, Recipe& recipe);

/// A command of crgbuild as a shell takes it; `words`: flag (or nothing) and value, those without a
/// value are left out.
std::string command_line(const std::string& subcommand, const RecipeValues& words,
                         const RecipeValues& values);

/// How the mesh of a recipe is read and where it lies, for a report.
void place_mesh(const Recipe& recipe, ReportRequest& request);

struct BuildRequest {
  std::string input;       ///< a mesh or track.yaml
  std::string output_dir;  ///< made if missing
  bool report = true;      ///< report.html and report.json too
  bool force = false;      ///< build even when nothing has changed
  RecipeValues values;     ///< on top of the recipe
};

struct ReportedBuild {
  Recipe recipe;
  BuildResult result;
  std::optional<ReportFiles> report;
};

/// `crgbuild build`. Throws Error, Question where it cannot be told which road is meant.
ReportedBuild make_reported(const BuildRequest& request, const Progress& progress = {});

/// The same with the keys set already; those of the request are words for the report.
ReportedBuild make_reported(const BuildRequest& request, Recipe recipe, const Progress& progress);

/// Why the road must not be used, in one sentence; empty: it may be.
std::string why_not_usable(const ReportedBuild& build);
std::string validation_failed(const std::string& crg_path,
                              const std::vector<std::string>& failures);
std::string not_usable(const std::string& crg_path, const ReportFiles& files);

/// What the stages remarked, and where smoothing would have moved more than it may.
std::vector<std::string> remarks_of(const std::string& summary_json);

/// Stages know no files: what they refuse gets the name of the input in front.
std::string with_input_named(const std::string& input, const std::string& what);

}  // namespace road
