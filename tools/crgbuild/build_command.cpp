#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/ending.h"
#include "base/json_text.h"
#include "commands.h"
#include "make/question.h"
#include "mesh/error.h"

namespace crgbuild {
namespace {

/// A flag that cannot be meant is a wrong command line.
void apply(const RecipeFlags& flags, road::Recipe& recipe) {
  try {
    road::set_values(flags, recipe);
  } catch (const road::Error& error) {
    throw UsageError(error.what());
  }
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
    const auto timing = base::parse_json<nlohmann::json>(timing_json);
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

/// Which way round a closed road runs. Along a guide or a route it is theirs.
std::string direction_text(const road::Recipe& recipe, bool closed) {
  if (!closed || recipe.clean.guide || recipe.guide_path || !recipe.clean.route_m.empty())
    return "";
  return recipe.centreline.reverse ? "  u runs clockwise, as told\n"
                                   : "  u runs counter-clockwise (--reverse turns it round)\n";
}

/// What a build tells its user.
std::string build_text(const road::Recipe& recipe, const road::BuildResult& result) {
  const auto s = base::parse_json<nlohmann::json>(result.summary_json);
  const auto number = [](const nlohmann::json& j) { return j.is_number() ? j.get<double>() : 0.0; };
  const nlohmann::json &line = s.at("reference_line"), &width = s.at("centreline"),
                       &clean = s.at("clean"), &grid = s.at("grid"), &sample = s.at("sample"),
                       &validation = s.at("validation"), &read = s.at("read");
  std::string text = fmt::format(
      "{}: {} road of {:.1f} m, {:.1f} to {:.1f} m wide, with kerbs and run-off {:.1f} to {:.1f} "
      "m\n"
      "{}"
      "  up {}, {}{}{}\n"
      "  kept {} of {} triangles (by {})\n"
      "  grid {} x {} nodes, {:.4g} x {:.4g} m; {} holes, {} filled, {} folds trimmed\n"
      "  {} kerbs; smoothing moved the road by at most {:.2f} mm{}\n"
      "  against the mesh at {} points: 99 % within {:.2f} mm, the largest error {:.2f} mm\n"
      "{}"
      "road     {}\npicture  {}\nnumbers  {}\n",
      recipe.name, line.at("closed").get<bool>() ? "closed" : "open", number(line.at("length_m")),
      number(width.at("width_min_m")), number(width.at("width_max_m")),
      number(grid.at("width_min_m")), number(grid.at("width_max_m")),
      direction_text(recipe, line.at("closed").get<bool>()), read.at("up").get<std::string>(),
      read.at("up_why").get<std::string>(),
      read.at("mirrored").get<bool>() ? "; mirrored, as told" : "",
      read.at("unit_taken").get<bool>() ? "; " + read.at("unit_why").get<std::string>() : "",
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
  for (const std::string& remark : road::remarks_of(result.summary_json))
    text += fmt::format("remark   {}\n", one_line(remark));
  return text;
}

/// One line for each answer, with the command that takes it.
void print_answers(const BuildCommand& command, const road::Question& question,
                   Terminal& terminal) {
  terminal.progress_done();
  std::string text;
  auto answers = nlohmann::ordered_json::array();
  RecipeFlags told = command.values;
  std::erase_if(told, [](const auto& value) { return value.first == "use_names"; });
  for (std::size_t k = 0; k < question.candidates().size(); ++k) {
    const road::Candidate& road = question.candidates()[k];
    const std::string run =
        road::command_line("build", {{"", command.input}}, told) +
        fmt::format(" {} -o {}", road.flags, command::shell_word(command.output_dir));
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

road::Recipe make_recipe(const std::string& input, const RecipeFlags& flags) {
  road::Recipe recipe = road::recipe_of(input);
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
  const road::ReportedBuild build = [&] {
    try {
      return road::make_reported(command, make_recipe(command.input, command.values),
                                 terminal.progress());
    } catch (const road::Question& question) {
      print_answers(command, question, terminal);
      throw;
    }
  }();
  terminal.progress_done();
  terminal.print(terminal.json ? build.result.summary_json
                               : build_text(build.recipe, build.result));
  if (!build.result.validation_failures.empty())
    print_objects_in_short(command.input, command.values, terminal);
  if (build.report) print_report(*build.report, terminal);
  if (const std::string why = road::why_not_usable(build); !why.empty()) throw NotValid(why);
  return kOk;
}

}  // namespace crgbuild
