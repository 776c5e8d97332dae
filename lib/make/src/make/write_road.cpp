#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "base/one_line.h"
#include "base/sha256.h"
#include "base/write_file.h"
#include "crg/file.h"
#include "crg/surface.h"
#include "make/make_road.h"
#include "make/place.h"
#include "make/road_mesh_file.h"
#include "make_steps.h"
#include "mesh/error.h"
#include "mesh/ray_surface.h"
#include "road/track_crg.h"

namespace road {

namespace {

/// Writes each patch and, last, the index that names them. The name of the index; empty without
/// patches.
std::string write_patches(std::vector<KerbPatch>& patches, const base::OutputSet& outputs,
                          BuildSummary& summary) {
  if (patches.empty()) return {};
  const Recipe& recipe = summary.recipe;
  // The index has its paths without blanks, a name may have some.
  if (recipe.name.find_first_of(" \t#") != std::string::npos)
    throw Error(
        fmt::format("name: '{}' has a blank or #, which the index of patches cannot hold; take "
                    "another --name, or leave patches out "
                    "(kerb_patch_error_m: 0)",
                    recipe.name));
  std::string index =
      fmt::format("# kerbs finer than the rows of the road\nbase {}.crg\n", recipe.name);
  for (std::size_t k = 0; k < patches.size(); ++k) {
    KerbPatch& patch = patches[k];
    const std::string file = fmt::format("{}.patch-{}.crg", recipe.name, k + 1);
    summary.patches.push_back({file, patch.u_begin_m, patch.u_end_m, patch.grid.v_m.front(),
                               patch.grid.v_m.back(), patch.line.u_step_m, patch.error_before_m,
                               patch.error_m});
    base::write_file(outputs.staged(file),
                     crg::to_bytes(track_crg(patch.line, std::move(patch.grid)), recipe.format));
    index += fmt::format("patch {} blend_m={}\n", file, kPatchBlend_m);
  }
  const std::string name = recipe.name + ".patches";
  base::write_file(outputs.staged(name), index);
  return name;
}

void write_pictures(const MadeRoad& built, const base::OutputSet& outputs) {
  const Recipe& recipe = built.summary.recipe;
  base::write_file(outputs.staged(picture_name(recipe)),
                   plan_picture(recipe.name, built.line, built.sampled, recipe.sample.threads));
  const report::ClassMap classes = class_picture(built.mesh, built.summary.clean.class_of_triangle);
  base::write_file(outputs.staged(classes_name(recipe)), classes.png);
  base::write_file(outputs.staged(recipe.name + ".classes.pgw"), classes.world_file);
}

void write_road(MadeRoad& built, const base::OutputSet& outputs) {
  BuildSummary& summary = built.summary;
  crg::Crg file = track_crg(built.line, std::move(built.sampled.grid));
  if (summary.placement) write_projection(summary.placement->projection, built.line, file);
  summary.wgs84 = geo_ends(file);
  file.comment = source_lines(summary.inputs);
  if (const auto& mesh = summary.recipe.published.mesh)
    file.comment.push_back(base::one_line("mesh by: " + *mesh));
  base::write_file(outputs.staged(road_name(summary.recipe)),
                   crg::to_bytes(file, summary.recipe.format));
}

void write_friction(MadeRoad& built, const base::OutputSet& outputs) {
  crg::ReferenceLine level = built.line;
  level.z_m.clear();  // the values are frictions as they stand
  base::write_file(
      outputs.staged(friction_name(built.summary.recipe)),
      crg::to_bytes(track_crg(level, std::move(*built.friction)), built.summary.recipe.format));
}

ValidateReport validate_written(const MadeRoad& built, const base::OutputSet& outputs) {
  const Recipe& recipe = built.summary.recipe;
  ValidateOptions options = recipe.validate;
  options.edges = built.edges;
  if (built.summary.placement) options.T_global_mesh = built.summary.placement->align.T_global_mesh;
  crg::Crg file = crg::read(outputs.staged(road_name(recipe)));
  for (std::size_t k = 0; k < built.added_m.size(); ++k) file.grid.z_m[k] -= built.added_m[k];
  ValidateReport report = validate(crg::Surface(std::move(file)), RaySurface(built.mesh), options);
  report.doubts = built.doubts;
  return report;
}

}  // namespace

BuildResult write(MadeRoad& built, base::OutputSet& outputs, const base::Progress& progress) {
  BuildSummary& summary = built.summary;
  const Recipe& recipe = summary.recipe;
  BuildResult result = paths_of(recipe, outputs);
  result.clean_reused = built.clean_reused;
  summary.centreline = describe(built.centreline);
  summary.grid = describe(built.sampled.grid, built.line);
  Stages stage(progress, built.seconds, kBuildStages);
  stage("picture", [&] { write_pictures(built, outputs); });
  std::string patches_index;
  stage("write", [&] {
    write_road_mesh(built.road, outputs.staged(surface_name(recipe)));
    write_centreline_csv(built.centreline, outputs.staged(kCentrelineName));
    write_road(built, outputs);
    patches_index = write_patches(built.patches, outputs, summary);
    if (built.friction) {
      summary.friction_file = friction_name(recipe);
      write_friction(built, outputs);
    }
  });
  stage("validate", [&] { summary.validate = validate_written(built, outputs); });
  result.validation_failures = validation_failures(summary.validate, limits_of(summary));
  if (!patches_index.empty()) result.patches_path = outputs.path(patches_index);
  for (const auto& [role, name] : {std::pair<const char*, std::string>{"road", road_name(recipe)},
                                   {"surface", surface_name(recipe)},
                                   {"centreline", kCentrelineName},
                                   {"picture", picture_name(recipe)},
                                   {"classes", classes_name(recipe)},
                                   {"friction", summary.friction_file},
                                   {"patches", patches_index}})
    if (!name.empty())
      summary.outputs.push_back({role, name, base::sha256_of_file(outputs.staged(name))});
  result.summary_json = summary_json(summary);
  base::write_file(outputs.staged(kSummaryName), result.summary_json);
  return result;
}

}  // namespace road
