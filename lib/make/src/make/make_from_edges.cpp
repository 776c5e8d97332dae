#include <algorithm>
#include <cctype>
#include <filesystem>

#include "base/output_set.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "make_steps.h"
#include "road/track_crg.h"

namespace road {

std::string name_of_edges(const std::string& left_path, const std::string& right_path) {
  if (right_path.empty()) return std::filesystem::path(left_path).stem().string();
  const std::string left = std::filesystem::path(left_path).stem().string(),
                    right = std::filesystem::path(right_path).stem().string();
  std::string name(left.begin(),
                   std::mismatch(left.begin(), left.end(), right.begin(), right.end()).first);
  if (left == right) name = left;
  // "track_inner" and "track_inlet" share "track_in": a name ends between words.
  const std::size_t cut = left == right ? name.size() : name.find_last_of("_- .");
  name.resize(cut == std::string::npos ? 0 : cut);
  while (!name.empty() && std::string_view("_- .").find(name.back()) != std::string_view::npos)
    name.pop_back();
  return name.empty() || name.front() == '.' || name.front() == '-' ? "road" : name;
}

BuildResult make_from_edges(const EdgeRecipe& recipe, const std::string& output_dir,
                            const Progress& progress) {
  const Clock::time_point start = Clock::now();
  base::OutputSet outputs(output_dir, "crgbuild from-edges");
  const std::string road_crg = recipe.name + ".crg", picture = recipe.name + ".png";
  BuildResult paths;
  paths.crg_path = outputs.path(road_crg);
  paths.centreline_path = outputs.path(kCentrelineName);
  paths.summary_path = outputs.path(kSummaryName);
  paths.timing_path = outputs.path(kTimingName);
  paths.picture_path = outputs.path(picture);

  EdgesSummary summary;
  summary.recipe = recipe;
  std::vector<StageSeconds> seconds;
  Stages stage(progress, seconds, 4);
  EdgePlaces edges = stage("read", [&] {
    if (recipe.right_path.empty()) {
      summary.inputs = {{"line", recipe.left_path, base::sha256_of_file(recipe.left_path)}};
      auto [left, right] = read_edges_of_line(recipe.left_path);
      return EdgePlaces{std::move(left), std::move(right), {}};
    }
    summary.inputs = {{"left", recipe.left_path, base::sha256_of_file(recipe.left_path)},
                      {"right", recipe.right_path, base::sha256_of_file(recipe.right_path)}};
    return read_edges(recipe.left_path, recipe.right_path);
  });
  edges.left.keep_open = edges.right.keep_open = recipe.keep_open;
  EdgeRoad road = stage("edges", [&] {
    return road_between_edges(edges.left, edges.right, recipe.options, &summary.edges);
  });
  summary.grid = describe(road.sampled.grid, road.line);
  stage("picture", [&] {
    base::write_file(outputs.staged(picture),
                     plan_picture(recipe.name, road.line, road.sampled, recipe.threads));
  });
  stage("write", [&] {
    write_centreline_csv(road.centreline, outputs.staged(kCentrelineName));
    crg::Crg file = track_crg(road.line, std::move(road.sampled.grid));
    file.comment = source_lines(summary.inputs);
    write_projection(edges.projection, road.line, file);
    base::write_file(outputs.staged(road_crg), crg::to_bytes(file, recipe.format));
  });
  summary.line_length_m = road.line.u_step_m * static_cast<double>(road.line.size() - 1);
  paths.summary_json = edges_summary_json(summary);
  paths.timing_json = timing_json(seconds, seconds_since(start));
  base::write_file(outputs.staged(kSummaryName), paths.summary_json);
  base::write_file(outputs.staged(kTimingName), paths.timing_json);
  outputs.commit(recipe.name, {}, {kTimingName});
  return paths;
}

}  // namespace road
