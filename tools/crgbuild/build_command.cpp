#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/ending.h"
#include "base/output_set.h"
#include "commands.h"
#include "road/build.h"
#include "road/error.h"
#include "road/question.h"

namespace crgbuild {
namespace {

void apply(const RecipeFlags& flags, road::Recipe& recipe) {
  // A flag for one way of alignment replaces the other way in the recipe.
  const auto given = [&](const char* name) {
    return std::any_of(flags.begin(), flags.end(), [&](const auto& f) { return f.first == name; });
  };
  const bool by_points = given("control_points"), by_trajectory = given("trajectory"),
             by_values = given("yaw_deg") || given("translation_m");
  if ((by_points ? 1 : 0) + (by_trajectory ? 1 : 0) + (by_values ? 1 : 0) > 1)
    throw UsageError(
        "more than one of --control-points, --trajectory, and --yaw-deg with --translation-m seen; "
        "give one");
  if (by_points || by_trajectory) recipe.T_global_mesh.reset();
  if (by_values || by_trajectory) recipe.control_points_path.reset();
  if (by_values || by_points) recipe.trajectory_path.reset();
  for (const auto& [name, text] : flags) {
    const auto& keys = road::recipe_keys();
    const auto key = std::find_if(keys.begin(), keys.end(),
                                  [&, n = name](const auto& k) { return k.name == n; });
    try {
      key->set(recipe, text);
    } catch (const road::Error& error) {
      throw UsageError(fmt::format("{}: {}", flag_of(name), error.what()));
    }
  }
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

/// What smoothing took, so that nobody loses the bumps of a braking zone without knowing.
std::string smoothed_waves(const nlohmann::json& smooth) {
  const nlohmann::json& waves = smooth.at("halved_waves_m");
  if (!waves.is_array()) return "";
  return fmt::format(
      " (u = {:.1f} m, v = {:.1f} m); waves of {:.1f} to {:.1f} m lost more than half of their "
      "power",
      smooth.at("largest_change_u_m").get<double>(), smooth.at("largest_change_v_m").get<double>(),
      waves.at(0).get<double>(), waves.at(1).get<double>());
}

}  // namespace

std::string smoothing_bound(const nlohmann::json& s) {
  const auto held = s.at("smooth").at("nodes_at_bound").get<std::size_t>();
  if (held == 0) return "";
  return fmt::format(
      "smoothing was held at its bound at {} of {} nodes (--smooth-max-change-road-m, "
      "--smooth-max-change-kerb-m): there the road is rougher than the window makes it",
      held, s.at("grid").at("nodes_with_z").get<std::size_t>());
}

namespace {

/// How well the road was laid on its control points or trajectory; nothing where none were given.
std::string alignment_text(const nlohmann::json& align) {
  if (align.is_null() || align.at("by") == "values") return "";
  const auto& names = align.at("points");
  const auto& outliers = align.at("outliers");
  std::string text =
      fmt::format("aligned  by {}: rms {:.1f} mm",
                  align.at("by") == "trajectory" ? "the trajectory"
                  : align.at("by") == "guide"
                      ? "the guide"
                      : fmt::format("{} control points", names.size() - outliers.size()),
                  1e3 * align.at("rms_m").get<double>());
  std::string worst, left_out;
  double largest_m = -1.0;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto name = names[k].get<std::string>();
    const double residual_m = align.at("residual_m").at(k).get<double>();
    if (std::find(outliers.begin(), outliers.end(), name) != outliers.end())
      left_out += fmt::format("{}{} ({:.3f} m)", left_out.empty() ? "" : ", ", name, residual_m);
    else if (residual_m > largest_m)
      largest_m = residual_m, worst = name;
  }
  if (!worst.empty()) text += fmt::format(", the largest {:.1f} mm at {}", 1e3 * largest_m, worst);
  if (!left_out.empty()) text += "; left out, as they contradict the others: " + left_out;
  return one_line(text) + "\n";
}

/// Seconds and memory of the build; nothing where timing.json was removed or changed since.
std::string timing_text(const std::string& timing_json) {
  try {
    const auto timing = nlohmann::json::parse(timing_json);
    return fmt::format("{:.2f} s, {:.0f} MB", timing.at("seconds").at("total").get<double>(),
                       timing.at("peak_memory_mb").get<double>());
  } catch (const nlohmann::json::exception&) {
    return "";
  }
}

std::string cost_text(const road::BuildResult& result) {
  std::string text = timing_text(result.timing_json);
  const char* why = result.reused ? "reused: nothing has changed since then (--force builds again)"
                    : result.clean_reused
                        ? "the mesh was cleaned before and has not changed (--force cleans again)"
                        : "";
  if (!text.empty() && *why != '\0') text += "; ";
  return fmt::format("  {}{}\n", text, why);
}

/// What a build tells its user.
std::string build_text(const road::Recipe& recipe, const road::BuildResult& result) {
  const auto s = nlohmann::json::parse(result.summary_json);
  const auto number = [](const nlohmann::json& j) { return j.is_number() ? j.get<double>() : 0.0; };
  const nlohmann::json &line = s.at("reference_line"), &width = s.at("centreline"),
                       &clean = s.at("clean"), &grid = s.at("grid"), &sample = s.at("sample"),
                       &validation = s.at("validation");
  std::string text = fmt::format(
      "{}: {} road of {:.1f} m, {:.1f} to {:.1f} m wide, with kerbs and run-off {:.1f} to {:.1f} "
      "m\n"
      "  kept {} of {} triangles (by {})\n"
      "  grid {} x {} nodes, {:.4g} x {:.4g} m; {} holes, {} filled, {} folds trimmed\n"
      "  {} kerbs; smoothing moved the road by at most {:.2f} mm{}\n"
      "  against the mesh at {} points: 99 % within {:.2f} mm, the largest error {:.2f} mm\n"
      "{}"
      "road     {}\npicture  {}\nnumbers  {}\n",
      recipe.name, line.at("closed").get<bool>() ? "closed" : "open", number(line.at("length_m")),
      number(width.at("width_min_m")), number(width.at("width_max_m")),
      number(grid.at("width_min_m")), number(grid.at("width_max_m")),
      clean.at("triangles_kept").get<std::size_t>(), clean.at("triangles_in").get<std::size_t>(),
      clean.at("told_by").get<std::string>(), grid.at("rows").get<std::size_t>(),
      grid.at("columns").get<std::size_t>(), number(grid.at("u_step_m")),
      number(grid.at("v_step_max_m")), grid.at("holes").get<std::size_t>(),
      sample.at("filled").get<std::size_t>(), sample.at("folds").size(),
      s.at("kerb").at("kerbs").size(), 1e3 * number(s.at("smooth").at("largest_change_road_m")),
      smoothed_waves(s.at("smooth")), validation.at("points").get<std::size_t>(),
      1e3 * number(validation.at("z_error_m").at("p99")),
      1e3 * number(validation.at("z_error_m").at("max")), cost_text(result), result.crg_path,
      result.picture_path, result.summary_path);
  text += alignment_text(s.at("align"));
  if (!result.patches_path.empty())
    text += fmt::format("patches  {} ({} kerbs finer than the rows)\n", result.patches_path,
                        s.at("patches").size());
  if (!result.friction_path.empty()) text += fmt::format("friction {}\n", result.friction_path);
  for (const char* stage : {"read", "clean", "sample", "validation"})
    for (const auto& remark : s.at(stage).at("remarks"))
      text += fmt::format("remark   {}\n", one_line(remark.get<std::string>()));
  const std::string bound = smoothing_bound(s);
  if (!bound.empty()) text += "remark   " + bound + "\n";
  return text;
}

/// One line for each answer, with the command that takes it.
void print_answers(const BuildCommand& command, const road::Question& question,
                   Terminal& terminal) {
  terminal.progress_done();
  std::string text;
  auto answers = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < question.candidates().size(); ++k) {
    const road::Candidate& road = question.candidates()[k];
    std::string run = "crgbuild build " + command::shell_word(command.input);
    for (const auto& [name, value] : command.flags) {
      std::string flag = name;
      std::replace(flag.begin(), flag.end(), '_', '-');
      if (name != "use_names") run += fmt::format(" --{} {}", flag, command::shell_word(value));
    }
    run += fmt::format(" {} -o {}", road.flags, command::shell_word(command.output_dir));
    text += fmt::format("{}  {} road, {:.0f} m long, {:.1f} m wide: {}\n", k + 1,
                        road.closed ? "closed" : "open", road.length_m, road.width_m, run);
    answers.push_back({{"closed", road.closed},
                       {"length_m", road.length_m},
                       {"width_m", road.width_m},
                       {"flags", road.flags},
                       {"command", run}});
  }
  terminal.print(
      terminal.json
          ? nlohmann::ordered_json{{"question", question.what()}, {"answers", answers}}.dump(
                2, ' ', false, nlohmann::json::error_handler_t::replace) +
                "\n"
          : text);
}

}  // namespace

std::string flag_of(std::string key) {
  std::replace(key.begin(), key.end(), '_', '-');
  return "--" + key;
}

bool is_switch(const road::RecipeKey& key) {
  return key.wanted == "true or false" && key.show(road::Recipe{}) == "false";
}

road::Recipe make_recipe(const std::string& input, const RecipeFlags& flags) {
  const std::string ending = base::ending_of(input);
  road::Recipe recipe = ending == ".yaml" || ending == ".yml" ? road::read_recipe(input)
                                                              : road::recipe_for_mesh(input);
  apply(flags, recipe);
  return recipe;
}

road::Recipe make_recipe(const RecipeFlags& flags) {
  road::Recipe recipe;
  apply(flags, recipe);
  return recipe;
}

int run_build(const BuildCommand& command, Terminal& terminal) {
  if (base::ending_of(command.input) == ".crg")
    throw UsageError(
        fmt::format("{0} is a road already: crgbuild info {0} says what it holds, crgbuild report "
                    "{0} -o {1} what is wrong with it",
                    command::shell_word(command.input), command::shell_word(command.output_dir)));
  if (is_road_file(command.input))
    throw road::Error(
        fmt::format("{0}: is an OpenCRG road already, a mesh or a recipe is wanted; 'crgbuild info "
                    "{0}' says what it holds, "
                    "'crgbuild report {0} -o DIR' what is wrong with it",
                    command.input));
  const road::Recipe recipe = make_recipe(command.input, command.flags);
  road::BuildEvidence evidence;
  base::OutputSet outputs(command.output_dir, road::kBuildCommand);
  const road::BuildResult result = [&] {
    try {
      return road::build_track(recipe, outputs, terminal.progress(),
                               command.no_report ? nullptr : &evidence,
                               command.force ? road::Reuse::nothing : road::Reuse::everything);
    } catch (const road::Question& question) {
      print_answers(command, question, terminal);
      throw;
    }
  }();
  std::optional<road::ReportFiles> report;
  if (!command.no_report)
    report = result.reused ? road::read_report(command.output_dir)
                           : report_build(command, recipe, result, evidence, outputs);
  road::commit_build(recipe, result, outputs);
  terminal.progress_done();
  terminal.print(terminal.json ? result.summary_json : build_text(recipe, result));
  if (report) print_report(*report, terminal);
  if (!result.validation_failures.empty())
    throw_validation_failed(result.crg_path, result.validation_failures);
  if (report) refuse_if_not_usable(result.crg_path, *report);
  return kOk;
}

}  // namespace crgbuild
