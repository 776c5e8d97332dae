#include "road/build.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "build_steps.h"
#include "clean_cache.h"
#include "crg/file.h"
#include "files/output_set.h"
#include "files/read_file.h"
#include "files/sha256.h"
#include "files/write_file.h"
#include "report/track_report.h"
#include "road/error.h"
#include "road/gaps.h"
#include "road/place.h"
#include "road/plausible.h"
#include "road/question.h"
#include "road/ray_surface.h"
#include "road/road_mesh_file.h"
#include "road/summary.h"
#include "suggest_unit.h"

namespace road {

namespace {

constexpr std::size_t kTrianglesWorthKeeping = 50'000;  // smaller meshes are cleaned in 0.1 s

/// The line with the heights of the grid on it: what a trajectory is compared with.
crg::ReferenceLine line_with_heights(crg::ReferenceLine line, const SampledGrid& sampled) {
  const auto& v = sampled.grid.v_m;
  const auto at =
      std::min(static_cast<std::size_t>(std::lower_bound(v.begin(), v.end(), 0.0) - v.begin()),
               v.size() - 1);
  line.z_m.assign(line.size(), 0.0);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const float z = sampled.grid.at(i, at);
    line.z_m[i] = std::isnan(z) ? (i > 0 ? line.z_m[i - 1] : 0.0) : static_cast<double>(z);
  }
  return line;
}

/// Where a point in plan of the mesh goes when that is tilted and scaled; as high as the nearest
/// vertex.
Eigen::Vector2d moved(const Eigen::Vector2d& near_m, const Mesh& mesh, const TiltAndScale& change) {
  double best = std::numeric_limits<double>::infinity(), z_m = 0.0;
  for (const Eigen::Vector3d& p : mesh.vertices_m) {
    const double square = ((mesh.origin_m + p).head<2>() - near_m).squaredNorm();
    if (square < best) best = square, z_m = mesh.origin_m.z() + p.z();
  }
  return change({near_m.x(), near_m.y(), z_m}).head<2>();
}

/// Writes each patch and, last, the index that names them. The name of the index; empty without
/// patches.
std::string write_patches(std::vector<KerbPatch> patches, const files::OutputSet& outputs,
                          const Recipe& recipe, BuildSummary& summary) {
  if (patches.empty()) return {};
  // The index has its paths without blanks, a name may have some.
  if (recipe.name.find_first_of(" \t#") != std::string::npos)
    throw Error(
        fmt::format("name: '{}' has a blank or #, which the index of patches cannot hold; take "
                    "another --name, or leave patches out "
                    "(--kerb-patch-error-m 0)",
                    recipe.name));
  std::string index =
      fmt::format("# kerbs finer than the rows of the road\nbase {}.crg\n", recipe.name);
  for (std::size_t k = 0; k < patches.size(); ++k) {
    const std::string file = fmt::format("{}.patch-{}.crg", recipe.name, k + 1);
    summary.patches.push_back({file, patches[k].u_begin_m, patches[k].u_end_m,
                               patches[k].grid.v_m.front(), patches[k].grid.v_m.back(),
                               patches[k].line.u_step_m, patches[k].error_before_m,
                               patches[k].error_m});
    files::write_file(
        outputs.staged(file),
        crg::to_bytes(track_crg(patches[k].line, std::move(patches[k].grid)), recipe.format));
    index += fmt::format("patch {} blend_m={}\n", file, kPatchBlend_m);
  }
  const std::string name = recipe.name + ".patches";
  files::write_file(outputs.staged(name), index);
  return name;
}

/// Role and name of each file beside summary.json.
void add_output(const char* role, const std::string& name, const files::OutputSet& outputs,
                BuildSummary& summary) {
  if (!name.empty())
    summary.outputs.push_back({role, name, files::sha256_of_file(outputs.staged(name))});
}

/// Runs a stage that finds the road. Where it refuses, and nobody has said yet which road is meant,
/// says in which other unit there is a road; or asks, with a picture of the answers.
template <typename Body>
auto asking(const Mesh& mesh, double metres_per_unit, const Recipe& recipe,
            const std::string& picture_path, const Body& body) {
  try {
    return body();
  } catch (const Error& refused) {
    if (recipe.clean.guide || !recipe.clean.route_m.empty()) throw;
    const std::string other =
        recipe.read.scale == 1.0 ? unit_with_a_road(mesh, metres_per_unit, recipe.clean) : "";
    if (!other.empty()) throw Error(refused.what() + other);
    std::vector<Candidate> could_be = candidates(mesh, recipe);
    if (could_be.empty())
      throw Error(
          fmt::format("{}; or give a rough line along the road that is meant: --guide FILE (CSV, "
                      "GPX, KML, GeoJSON)",
                      refused.what()));
    files::write_file(picture_path,
                      question_picture(recipe.name + ": which road is meant?", mesh, could_be));
    const std::string question = fmt::format("{}; which road is meant? {} shows {} that could be",
                                             refused.what(), picture_path, could_be.size());
    throw Question(question, std::move(could_be));
  }
}

}  // namespace

crg::Crg track_crg(const crg::ReferenceLine& line, crg::Grid grid) {
  crg::Crg file = crg::make_crg(line, std::move(grid));
  crg::set_value(file.options, "BORDER_MODE_U", 0.0);
  crg::set_value(file.options, "BORDER_MODE_V", 0.0);
  return file;
}

BuildResult build_track(const Recipe& recipe, const std::string& output_dir,
                        const Progress& progress, BuildEvidence* evidence, Reuse reuse) {
  files::OutputSet outputs(output_dir, kBuildCommand);
  BuildResult result = build_track(recipe, outputs, progress, evidence, reuse);
  commit_build(recipe, result, outputs);
  return result;
}

void commit_build(const Recipe& recipe, const BuildResult& result, files::OutputSet& outputs) {
  if (!result.reused) outputs.commit(recipe.name, result.kept, {kTimingName});
}

BuildResult build_track(const Recipe& recipe, files::OutputSet& outputs, const Progress& progress,
                        BuildEvidence* evidence, Reuse reuse) {
  const Clock::time_point start = Clock::now();
  const std::string road_crg = recipe.name + ".crg", stl = recipe.name + ".stl",
                    picture = recipe.name + ".png", classes_png = recipe.name + ".classes.png",
                    world_file = recipe.name + ".classes.pgw",
                    friction_crg = recipe.name + ".friction.crg",
                    cache = recipe.name + ".clean.cache";
  BuildResult paths;
  paths.crg_path = outputs.path(road_crg);
  paths.stl_path = outputs.path(stl);
  paths.centreline_path = outputs.path(kCentrelineName);
  paths.summary_path = outputs.path(kSummaryName);
  paths.timing_path = outputs.path(kTimingName);
  paths.picture_path = outputs.path(picture);
  paths.classes_path = outputs.path(classes_png);
  if (recipe.friction.wanted) paths.friction_path = outputs.path(friction_crg);

  BuildSummary summary;
  summary.recipe = recipe;
  std::vector<StageSeconds> seconds;
  Stages stage(progress, seconds, 12);

  const auto add = [&](const char* role, const std::optional<std::string>& path) {
    if (path) summary.inputs.push_back({role, *path, files::sha256_of_file(*path)});
  };
  if (!recipe.recipe_path.empty()) add("recipe", recipe.recipe_path);
  add("mesh", recipe.mesh_path);
  std::vector<InputFile> mesh_files{summary.inputs.back()};
  add("guide", recipe.guide_path);
  add("control_points", recipe.control_points_path);
  add("trajectory", recipe.trajectory_path);
  if (recipe.friction.wanted) {
    add("friction_picture", recipe.friction.picture_path);
    if (recipe.friction.picture_path)
      add("friction_world_file", world_file_of(*recipe.friction.picture_path));
    add("friction_zones", recipe.friction.zones_path);
  }
  if (reuse == Reuse::everything) {
    const std::vector<std::string> there = outputs.confirmed({cache, kTimingName});
    const auto has = [&](const std::string& name) {
      return std::find(there.begin(), there.end(), name) != there.end();
    };
    const bool complete =
        has(road_crg) && has(kSummaryName) &&
        (!evidence || (has("report.json") && (has("report.html") || !report::page_available())));
    const auto text = complete ? unchanged_summary(paths.summary_path, summary) : std::nullopt;
    if (text) {
      paths.summary_json = *text;
      paths.validation_failures = failures_in_summary(*text);
      if (has(recipe.name + ".patches"))
        paths.patches_path = outputs.path(recipe.name + ".patches");
      if (has(kTimingName)) paths.timing_json = files::read_file(paths.timing_path);
      paths.reused = true;
      return paths;
    }
  }

  // Everything small first: a damaged one is refused before the mesh costs seconds.
  summary.placement = place_mesh(recipe);
  const TiltAndScale tilt_and_scale =
      summary.placement ? summary.placement->align.tilt_and_scale : TiltAndScale{};
  const std::optional<FrictionPaint> paint =
      recipe.friction.wanted ? std::optional(read_friction_paint(recipe.friction)) : std::nullopt;
  CleanOptions clean_options = recipe.clean;
  CentrelineOptions centreline_options = recipe.centreline;
  clean_options.guide = place_guide(recipe, summary.placement);
  Mesh mesh = stage("read", [&] {
    Mesh read = read_mesh(recipe.mesh_path, recipe.read, &summary.read);
    if (tilt_and_scale.is_identity()) return read;
    for (auto* near_m : {&clean_options.near_m, &centreline_options.start_near_m}) {
      if (*near_m) **near_m = moved(**near_m, read, tilt_and_scale);
    }
    apply_to_mesh(tilt_and_scale, read);
    return read;
  });
  for (const MeshFile& file : summary.read.files)
    mesh_files.push_back({kMeshFile, file.path, file.sha256});
  summary.inputs.insert(summary.inputs.end(), mesh_files.begin() + 1, mesh_files.end());
  Recipe asked = recipe;
  asked.clean = clean_options;
  asked.centreline = centreline_options;
  const auto finding = [&](const char* name, const auto& body) {
    return stage(name, [&] {
      return asking(mesh, summary.read.metres_per_unit, asked,
                    outputs.path(recipe.name + ".question.png"), body);
    });
  };
  const RoadMesh road = finding("clean", [&] {
    const std::string key =
        clean_key(recipe, clean_options.guide, tilt_and_scale,
                  program_name() + " " + files::sha256_of_program(), mesh_files);
    std::optional<Cleaned> cleaned =
        reuse == Reuse::nothing ? std::nullopt : read_clean_cache(key, outputs.path(cache));
    paths.clean_reused = cleaned.has_value();
    if (cleaned) paths.kept.push_back(cache);
    if (!cleaned) {
      cleaned.emplace();
      cleaned->road = clean(mesh, clean_options, &cleaned->report);
      if (mesh.triangles.size() >= kTrianglesWorthKeeping)
        write_clean_cache(*cleaned, key, outputs.staged(cache));
    }
    write_road_mesh(cleaned->road, outputs.staged(stl));
    summary.clean = std::move(cleaned->report);
    return std::move(cleaned->road);
  });
  const Centreline centreline = finding("centreline", [&] {
    Centreline traced = trace_centreline(road, centreline_options);
    write_centreline_csv(traced, outputs.staged(kCentrelineName));
    return traced;
  });
  summary.centreline = describe(centreline);
  crg::ReferenceLine line = finding("reference_line", [&] {
    return fit_reference_line(centreline, recipe.reference_line, &summary.reference_line);
  });
  const RaySurface surface(road.mesh);
  SampledGrid sampled = stage("sample", [&] {
    SampledGrid all = sample_grid(road, surface, line, centreline, recipe.sample, &summary.sample);
    close_cracks(all, surface, road, line, summary.sample);
    end_at_walls(all, line, mesh, recipe.sample.threads, summary.sample);
    return all;
  });
  std::optional<crg::Grid> before;
  if (evidence && sampled.grid.z_m.size() <= kMaxBeforeNodes) before = sampled.grid;
  sampled = stage("kerb", [&] {
    return refine_kerbs(std::move(sampled), surface, road, line, recipe.kerb, &summary.kerb);
  });
  stage("smooth", [&] {
    SmoothOptions options = recipe.smooth;
    options.closed = line.closed;
    smooth(sampled, options, &summary.smooth);
  });
  std::vector<KerbPatch> patches = stage("patch", [&] {
    return patch_kerbs(sampled, surface, road, line, summary.kerb.kerbs, recipe.patch);
  });
  std::optional<crg::Grid> friction;
  if (recipe.friction.wanted) {
    friction = stage("friction", [&] {
      return friction_grid(sampled, surface, road, line, recipe.friction, *paint,
                           recipe.sample.threads, &summary.friction);
    });
    summary.friction_file = friction_crg;
  }
  ValidateOptions validate_options = recipe.validate;
  stage("align", [&] {
    if (recipe.trajectory_path)
      summary.placement = place_road(recipe, line_with_heights(line, sampled));
    if (!summary.placement) return;
    validate_options.T_global_mesh = summary.placement->align.T_global_mesh;
    apply_alignment(validate_options.T_global_mesh, line);
    for (KerbPatch& patch : patches) apply_alignment(validate_options.T_global_mesh, patch.line);
  });
  summary.grid = describe(sampled.grid, line);
  stage("picture", [&] {
    files::write_file(outputs.staged(picture),
                      plan_picture(recipe.name, line, sampled, recipe.sample.threads));
    const report::ClassMap classes = class_picture(mesh, summary.clean.class_of_triangle);
    files::write_file(outputs.staged(classes_png), classes.png);
    files::write_file(outputs.staged(world_file), classes.world_file);
  });
  std::string patches_index;
  stage("write", [&] {
    crg::Crg file = track_crg(line, std::move(sampled.grid));
    if (summary.placement) write_projection(summary.placement->projection, line, file);
    summary.wgs84 = geo_ends(file);
    files::write_file(outputs.staged(road_crg), crg::to_bytes(file, recipe.format));
    patches_index = write_patches(std::move(patches), outputs, recipe, summary);
    if (!friction) return;
    crg::ReferenceLine level = line;
    level.z_m.clear();  // the values are frictions as they stand
    files::write_file(outputs.staged(friction_crg),
                      crg::to_bytes(track_crg(level, std::move(*friction)), recipe.format));
  });
  stage("validate", [&] {
    summary.validate = validate(outputs.staged(road_crg), mesh, validate_options);
    if (!recipe.line_is_right)
      summary.validate.doubts = doubts_about(centreline, surface, mesh, summary.clean);
  });
  paths.validation_failures = validation_failures(summary.validate, recipe.limits);
  if (evidence) {
    evidence->mesh = std::move(mesh);
    evidence->provenance = std::move(sampled.provenance);
    evidence->road_width_m = {summary.centreline.width_min_m, summary.centreline.width_median_m,
                              summary.centreline.width_max_m};
    evidence->kerbs = summary.kerb.kerbs;
    evidence->validate = summary.validate;
    if (before) evidence->before = track_crg(line, std::move(*before));
  }
  if (!patches_index.empty()) paths.patches_path = outputs.path(patches_index);
  for (const auto& [role, name] : {std::pair<const char*, std::string>{"road", road_crg},
                                   {"surface", stl},
                                   {"centreline", kCentrelineName},
                                   {"picture", picture},
                                   {"classes", classes_png},
                                   {"friction", summary.friction_file},
                                   {"patches", patches_index}})
    add_output(role, name, outputs, summary);
  std::filesystem::remove(outputs.path(recipe.name + ".question.png"));  // answered
  paths.summary_json = summary_json(summary);
  paths.timing_json = timing_json(seconds, seconds_since(start));
  files::write_file(outputs.staged(kSummaryName), paths.summary_json);
  files::write_file(outputs.staged(kTimingName), paths.timing_json);
  return paths;
}

}  // namespace road
