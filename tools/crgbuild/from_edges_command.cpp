#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "commands.h"
#include "make/make_track.h"

namespace crgbuild {

int run_from_edges(const FromEdgesCommand& command, Terminal& terminal) {
  RecipeFlags flags = command.flags;
  flags.emplace_back("name", command.name.empty() ? road::name_of_edges(command.left, command.right)
                                                  : command.name);
  const road::Recipe from_flags = make_recipe(flags);
  road::EdgeRecipe recipe;
  recipe.left_path = command.left;
  recipe.right_path = command.right;
  recipe.keep_open = command.open;
  recipe.name = from_flags.name;
  recipe.options.u_step_m = from_flags.reference_line.u_step_m.value_or(recipe.options.u_step_m);
  recipe.options.v_step_m = from_flags.sample.v_step_m.value_or(recipe.options.v_step_m);
  recipe.format = from_flags.format;
  recipe.threads = from_flags.sample.threads;
  const road::BuildResult result =
      road::make_from_edges(recipe, command.output_dir, terminal.progress());
  terminal.progress_done();
  if (terminal.json) {
    terminal.print(result.summary_json);
    return kOk;
  }
  const auto s = base::parse_json<nlohmann::json>(result.summary_json);
  const auto timing = base::parse_json<nlohmann::json>(result.timing_json);
  const auto& edges = s["edges"];
  terminal.print(fmt::format(
      "{}: {} road of {:.1f} m, {:.2f} to {:.2f} m wide, from {} and {} points\n"
      "  grid {} x {} nodes; the outermost nodes lie at most {:.0f} mm inside the edges\n"
      "  given points within {:.1f} mm of the edges (99 %), {:.1f} mm (all); {} folds trimmed\n"
      "  {:.2f} s, {:.0f} MB\n"
      "road     {}\npicture  {}\nnumbers  {}\n",
      recipe.name, s["reference_line"]["closed"].get<bool>() ? "closed" : "open",
      s["reference_line"]["length_m"].get<double>(), edges["width_min_m"].get<double>(),
      edges["width_max_m"].get<double>(), edges["left_points"].get<std::size_t>(),
      edges["right_points"].get<std::size_t>(), s["grid"]["rows"].get<std::size_t>(),
      s["grid"]["columns"].get<std::size_t>(), 1e3 * edges["edge_gap_max_m"].get<double>(),
      1e3 * edges["point_error_p99_m"].get<double>(),
      1e3 * edges["point_error_max_m"].get<double>(), edges["folds"].size(),
      timing["seconds"]["total"].get<double>(), timing["peak_memory_mb"].get<double>(),
      result.crg_path, result.picture_path, result.summary_path));
  for (const auto& remark : edges["remarks"])
    terminal.print(fmt::format("remark   {}\n", one_line(remark.get<std::string>())));
  return kOk;
}

}  // namespace crgbuild
