#include "road/build.h"

#include <fmt/format.h>

#include <filesystem>

#include "build_steps.h"
#include "crg/file.h"
#include "road/atomic_file.h"
#include "road/error.h"
#include "road/ray_surface.h"
#include "road/road_mesh_file.h"
#include "road/summary.h"

namespace road {

namespace {

std::optional<AlignReport> alignment_of(const Recipe& recipe) {
  if (recipe.control_points_path) return fit_alignment(read_control_points(*recipe.control_points_path));
  if (!recipe.T_global_mesh) return std::nullopt;
  AlignReport given;
  given.T_global_mesh = *recipe.T_global_mesh;
  return given;
}

}  // namespace

crg::Crg track_crg(const crg::ReferenceLine& line, crg::Grid grid) {
  crg::Crg file = crg::make_crg(line, std::move(grid));
  crg::set_value(file.options, "BORDER_MODE_U", 0.0);
  crg::set_value(file.options, "BORDER_MODE_V", 0.0);
  return file;
}

BuildResult build_track(const Recipe& recipe, const std::string& output_dir, const Progress& progress) {
  const Clock::time_point start = Clock::now();
  const std::filesystem::path dir(output_dir);
  BuildResult paths;
  paths.crg_path = (dir / (recipe.name + ".crg")).string();
  paths.stl_path = (dir / (recipe.name + ".stl")).string();
  paths.centreline_path = (dir / "centreline.csv").string();
  paths.summary_path = (dir / "summary.json").string();
  paths.picture_path = (dir / (recipe.name + ".png")).string();
  make_folder(output_dir);

  BuildSummary summary;
  summary.recipe = recipe;
  Stages stage(progress, summary.seconds, 11);

  const Mesh mesh = stage("read", [&] {
    if (!recipe.recipe_path.empty()) summary.inputs.push_back({"recipe", recipe.recipe_path, sha256_of_file(recipe.recipe_path)});
    summary.inputs.push_back({"mesh", recipe.mesh_path, sha256_of_file(recipe.mesh_path)});
    if (recipe.control_points_path) {
      summary.inputs.push_back({"control_points", *recipe.control_points_path, sha256_of_file(*recipe.control_points_path)});
    }
    return read_mesh(recipe.mesh_path, recipe.read, &summary.read);
  });
  const RoadMesh road = stage("clean", [&] {
    RoadMesh cleaned = clean(mesh, recipe.clean, &summary.clean);
    write_road_mesh(cleaned, paths.stl_path);
    return cleaned;
  });
  const Centreline centreline = stage("centreline", [&] {
    Centreline traced = trace_centreline(road, recipe.centreline);
    write_centreline_csv(traced, paths.centreline_path);
    return traced;
  });
  summary.centreline = describe(centreline);
  crg::ReferenceLine line = stage("reference_line", [&] {
    return fit_reference_line(centreline, recipe.reference_line, &summary.reference_line);
  });
  const RaySurface surface(road.mesh);
  SampledGrid sampled = stage("sample", [&] {
    return sample_grid(road, surface, line, centreline, recipe.sample, &summary.sample);
  });
  sampled = stage("kerb", [&] {
    return refine_kerbs(std::move(sampled), surface, road, line, recipe.kerb, &summary.kerb);
  });
  stage("smooth", [&] {
    SmoothOptions options = recipe.smooth;
    options.closed = line.closed;
    smooth(sampled, options, &summary.smooth);
  });
  ValidateOptions validate_options = recipe.validate;
  stage("align", [&] {
    summary.align = alignment_of(recipe);
    if (!summary.align) return;
    apply_alignment(summary.align->T_global_mesh, line);
    validate_options.T_global_mesh = summary.align->T_global_mesh;
  });
  summary.grid = describe(sampled.grid);
  stage("picture", [&] { write_file(paths.picture_path, plan_picture(recipe.name, line, sampled, recipe.sample.threads)); });
  stage("write", [&] { crg::write(track_crg(line, std::move(sampled.grid)), paths.crg_path, recipe.format); });
  stage("validate", [&] { summary.validate = validate(paths.crg_path, mesh, validate_options); });
  paths.validation_failures = validation_failures(summary.validate, recipe.limits);
  summary.seconds_total = seconds_since(start);
  paths.summary_json = summary_json(summary);
  write_file(paths.summary_path, paths.summary_json);
  return paths;
}

}  // namespace road
