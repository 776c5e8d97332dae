#include "make/make_reported.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/ending.h"
#include "base/json_text.h"
#include "base/output_set.h"
#include "base/shell_word.h"
#include "mesh/error.h"
#include "stage_json.h"

namespace road {
namespace {

const RecipeKey& key_called(const std::string& name) {
  const std::vector<RecipeKey>& keys = recipe_keys();
  const auto key =
      std::find_if(keys.begin(), keys.end(), [&](const RecipeKey& k) { return k.name == name; });
  if (key == keys.end())
    throw Error(fmt::format("there is no recipe key '{}'; docs/formats.md lists all", name));
  return *key;
}

/// By its name, or by the sections that it begins with.
bool is_road_file(const std::string& path) {
  if (base::ending_of(path) == ".crg") return true;
  if (!std::filesystem::is_regular_file(path)) return false;
  std::ifstream file(path, std::ios::binary);
  std::string begin(10, '\0');
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return begin.starts_with("$CT") || begin.starts_with("$ROAD_CRG");
}

/// Why a road must not be used, the first errors by their words; empty where there are none.
std::string not_usable(const std::string& crg_path, const std::vector<std::string>& errors,
                       const std::string& see) {
  if (errors.empty()) return "";
  constexpr std::size_t kTold = 3;
  std::string text = fmt::format("{}: not usable, {} error{}: ", crg_path, errors.size(),
                                 errors.size() == 1 ? "" : "s");
  for (std::size_t k = 0; k < std::min(kTold, errors.size()); ++k)
    text += (k > 0 ? "; " : "") + base::one_line(errors[k]);
  if (errors.size() > kTold) text += fmt::format("; {} more", errors.size() - kTold);
  return text + "; see " + see;
}

/// Where smoothing would have moved more than it may; empty where nowhere.
std::string smoothing_bound(const Json& s) {
  const auto held = s.at("smooth").at("nodes_at_bound").get<std::size_t>();
  if (held == 0) return "";
  return fmt::format(
      "smoothing was held at its bound at {} of {} nodes (smooth_max_change_road_m, "
      "smooth_max_change_kerb_m): there the road is rougher than the window makes it",
      held, s.at("grid").at("nodes_with_z").get<std::size_t>());
}

/// The report of a road that was just built, into the same set of files; the paths are those after
/// its commit.
ReportFiles report_build(const BuildRequest& order, const Recipe& recipe, const BuildResult& result,
                         const BuildEvidence& evidence, const base::OutputSet& outputs) {
  ReportRequest request;
  place_mesh(recipe, request);
  const auto staged = [&](const std::string& path) {
    return path.empty() ? "" : outputs.staged(std::filesystem::path(path).filename().string());
  };
  request.crg_path = staged(result.crg_path);
  request.shown_folder = order.output_dir;
  request.title = recipe.name;
  request.mesh = &evidence.mesh;
  request.provenance = &evidence.provenance;
  if (evidence.before) request.before = &*evidence.before;
  request.grip_path = staged(result.friction_path);
  RecipeValues told = order.values;
  std::erase_if(told, [](const auto& value) { return value.first == "threads"; });
  request.command_line = command_line("build", {{"", order.input}, {"-o", order.output_dir}}, told);
  const Json summary = base::parse_json<Json>(result.summary_json);
  request.remarks = remarks_of(result.summary_json);
  request.failures = result.validation_failures;
  const Json& align = summary.at("align");
  if (!align.is_null() &&
      (align["by"] == "trajectory" || align["by"] == "guide")) {  // by the build
    request.T_global_mesh.yaw_rad = align["yaw_deg"].get<double>() * M_PI / 180.0;
    for (int k = 0; k < 3; ++k)
      request.T_global_mesh.translation_m[k] =
          align["translation_m"][static_cast<std::size_t>(k)].get<double>();
  }
  request.validated = evidence.validate;
  request.kerbs = evidence.kerbs;
  request.edges = evidence.edges;
  request.limits = evidence.limits;
  request.road_width_m = evidence.road_width_m;
  const auto& read = summary.at("read");
  request.mesh_up = read.at("up").get<std::string>() + ", " + read.at("up_why").get<std::string>();
  request.mesh_unit = read.at("unit_why").get<std::string>();
  for (const auto& input : summary.at("inputs")) {
    if (input["role"] == "mesh" || input["sha256"] == "")
      continue;  // the report reads and hashes it itself; missing
    request.sources.push_back({input["role"].get<std::string>(), input["path"].get<std::string>(),
                               input["sha256"].get<std::string>()});
  }
  ReportFiles files = write_report(request, outputs.staged(""));
  for (std::string* path : {&files.json_path, &files.page_path})
    if (!path->empty()) *path = outputs.path(std::filesystem::path(*path).filename().string());
  return files;
}

}  // namespace

std::string flag_of(std::string key) {
  if (key == "start_near_m" || key == "start_object") return "--start-at";
  if (key == "guide_mapping") return "--mapping";
  std::replace(key.begin(), key.end(), '_', '-');
  return "--" + key;
}

bool is_switch(const RecipeKey& key) {
  return key.wanted == "true or false" && key.show(Recipe{}) == "false";
}

Recipe recipe_of(const std::string& input) {
  const std::string ending = base::ending_of(input);
  return ending == ".yaml" || ending == ".yml" ? read_recipe(input) : recipe_for_mesh(input);
}

void set_values(const RecipeValues& values, Recipe& recipe) {
  // A value for one way of alignment replaces the other way in the recipe.
  const auto given = [&](const char* name) {
    return std::any_of(values.begin(), values.end(),
                       [&](const auto& value) { return value.first == name; });
  };
  const bool by_points = given("control_points"), by_trajectory = given("trajectory"),
             by_values = given("yaw_deg") || given("translation_m");
  if ((by_points ? 1 : 0) + (by_trajectory ? 1 : 0) + (by_values ? 1 : 0) > 1)
    throw Error(
        "more than one of --control-points, --trajectory, and --yaw-deg with --translation-m seen; "
        "give one");
  if (by_points || by_trajectory) recipe.T_global_mesh.reset();
  if (by_values || by_trajectory) recipe.control_points_path.reset();
  if (by_values || by_points) recipe.trajectory_path.reset();
  for (const auto& [name, text] : values) {
    const RecipeKey& key = key_called(name);
    try {
      key.set(recipe, text);
    } catch (const Error& error) {
      throw Error(fmt::format("{}: {}", flag_of(name), error.what()));
    }
  }
}

std::string command_line(const std::string& subcommand, const RecipeValues& words,
                         const RecipeValues& values) {
  std::string text = "crgbuild " + subcommand;
  for (const auto& [flag, value] : words) {
    if (value.empty()) continue;
    text += (flag.empty() ? " " : " " + flag + " ") + base::shell_word(value);
  }
  for (const auto& [name, value] : values)
    text +=
        " " + flag_of(name) + (is_switch(key_called(name)) ? "" : " " + base::shell_word(value));
  return text;
}

void place_mesh(const Recipe& recipe, ReportRequest& request) {
  request.mesh_path = recipe.mesh_path;
  request.read = recipe.read;
  request.threads = recipe.sample.threads;
  request.align = recipe.align;
  request.validate = recipe.validate;
  request.published = recipe.published;
  if (recipe.control_points_path)
    request.control_points =
        read_control_point_file(*recipe.control_points_path, recipe.projection).points;
  if (recipe.T_global_mesh) request.T_global_mesh = *recipe.T_global_mesh;
}

ReportedBuild make_reported(const BuildRequest& request, const Progress& progress) {
  Recipe recipe = recipe_of(request.input);
  set_values(request.values, recipe);
  return make_reported(request, std::move(recipe), progress);
}

ReportedBuild make_reported(const BuildRequest& request, Recipe recipe, const Progress& progress) {
  if (is_road_file(request.input))
    throw Error(
        fmt::format("{0}: is an OpenCRG road already, a mesh or a recipe is wanted; 'crgbuild info "
                    "{0}' says what it holds, "
                    "'crgbuild report {0} -o DIR' what is wrong with it",
                    request.input));
  ReportedBuild out{std::move(recipe), {}, {}};
  BuildEvidence evidence;
  base::OutputSet outputs(request.output_dir, kBuildCommand);
  out.result = make_track(out.recipe, outputs, progress, request.report ? &evidence : nullptr,
                          request.force ? Reuse::nothing : Reuse::everything);
  if (request.report)
    out.report = out.result.reused
                     ? read_report(request.output_dir)
                     : report_build(request, out.recipe, out.result, evidence, outputs);
  commit_build(out.recipe, out.result, outputs);
  return out;
}

std::string why_not_usable(const ReportedBuild& build) {
  if (build.report) return not_usable(build.result.crg_path, *build.report);
  return not_usable(build.result.crg_path, build.result.validation_failures,
                    build.result.summary_path);
}

std::string validation_failed(const std::string& crg_path,
                              const std::vector<std::string>& failures) {
  std::string text = crg_path + ": validation failed: ";
  for (std::size_t i = 0; i < failures.size(); ++i) text += (i ? "; " : "") + failures[i];
  return text;
}

std::string not_usable(const std::string& crg_path, const ReportFiles& files) {
  return not_usable(crg_path, files.errors,
                    files.page_path.empty() ? files.json_path : files.page_path);
}

std::vector<std::string> remarks_of(const std::string& summary_json) {
  const Json s = base::parse_json<Json>(summary_json);
  std::vector<std::string> out;
  for (const char* stage : {"read", "clean", "sample", "validation"})
    for (const auto& remark : s.at(stage).at("remarks")) out.push_back(remark.get<std::string>());
  if (const std::string bound = smoothing_bound(s); !bound.empty()) out.push_back(bound);
  return out;
}

std::string with_input_named(const std::string& input, const std::string& what) {
  const std::string first_word = what.substr(0, what.find(' '));
  const bool names_a_file = first_word.ends_with(':') || what.find(input) != std::string::npos;
  return names_a_file ? what : input + ": " + what;
}

}  // namespace road
