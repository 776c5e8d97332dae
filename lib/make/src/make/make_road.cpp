#include "make/make_road.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/sha256.h"
#include "base/write_file.h"
#include "clean_cache.h"
#include "grid_stage.h"
#include "make/missing_piece.h"
#include "make/place.h"
#include "make/plausible.h"
#include "make/question.h"
#include "make_steps.h"
#include "mesh/error.h"
#include "mesh/ray_surface.h"
#include "right_way_up.h"
#include "road/gaps.h"
#include "road/road_edges.h"
#include "road/stretch.h"
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

/// What is read beside the mesh, and the recipe in the frame that the mesh has once it is read.
struct Prepared {
  Recipe recipe;
  TiltAndScale tilt_and_scale;
  std::optional<FrictionPaint> paint;
  bool guide_lays_mesh = false;  ///< then the guide comes after the mesh
};

/// Everything small first: a damaged one is refused before the mesh costs seconds.
Prepared prepare(const Recipe& recipe, BuildSummary& summary) {
  Prepared prepared{recipe, {}, {}};
  summary.placement = place_mesh(recipe);
  if (summary.placement) prepared.tilt_and_scale = summary.placement->align.tilt_and_scale;
  if (recipe.friction.wanted) prepared.paint = read_friction_paint(recipe.friction);
  if (recipe.kerb.zones_path) prepared.recipe.kerb.zones = read_kerb_zones(*recipe.kerb.zones_path);
  prepared.guide_lays_mesh = guide_lays_mesh(recipe, summary.placement);
  if (!prepared.guide_lays_mesh)
    prepared.recipe.clean.guide = place_guide(recipe, summary.placement);
  return prepared;
}

/// Of all objects of that name: a line over the road, or a gantry that nobody drives on.
Eigen::Vector2d middle_of_object(const Mesh& mesh, const std::string& name) {
  Eigen::AlignedBox2d box;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (mesh.objects[mesh.object_of_triangle[t]].name == name)
      for (int k = 0; k < 3; ++k) box.extend((mesh.origin_m + mesh.vertex(t, k)).head<2>());
  if (box.isEmpty())
    throw Error(
        fmt::format("no object named '{}'; 'crgbuild objects MESH' lists them; give one of these "
                    "as start_object, or a point as start_near_m",
                    name));
  return box.center();
}

Mesh read(Prepared& prepared, BuildSummary& summary) {
  Recipe& recipe = prepared.recipe;
  Mesh mesh = read_mesh(recipe.mesh_path, read_to_clean(recipe.read, recipe.clean), &summary.read);
  for (const MeshFile& file : summary.read.files)
    summary.inputs.push_back({kMeshFile, file.path, file.sha256});
  if (!prepared.tilt_and_scale.is_identity()) {
    for (auto* near_m : {&recipe.clean.near_m, &recipe.centreline.start_near_m})
      if (*near_m) **near_m = moved(**near_m, mesh, prepared.tilt_and_scale);
    apply_to_mesh(prepared.tilt_and_scale, mesh);
  }
  std::optional<Eigen::Vector2d>& start_m = recipe.centreline.start_near_m;
  if (recipe.start_object && !start_m) start_m = middle_of_object(mesh, *recipe.start_object);
  return mesh;
}

/// Reads the mesh. Where nothing tells which axis points up, the road itself may; else asks, as for
/// the unit of a mesh that is no road's size, with the roads that were found.
Mesh read_or_ask(Prepared& prepared, BuildSummary& summary) {
  UpAnswers answers;
  try {
    return read(prepared, summary);
  } catch (const UnknownUp& unknown) {
    if (prepared.guide_lays_mesh || !prepared.tilt_and_scale.is_identity()) throw;
    answers = candidates_of_up(prepared.recipe, unknown.could_be());
    // Where the road contradicts the faces, the plan may be mirrored.
    const bool is_told = answers.told && (is_minus(*answers.told) || prepared.recipe.read.mirror);
    if (!is_told)
      answers.candidates =
          likelier_units(prepared.recipe, unknown.could_be(), std::move(answers.candidates));
    if (!is_told && answers.candidates.empty()) throw;
    if (!is_told) throw Question(unknown.what(), std::move(answers.candidates));
  } catch (const UnknownUnit& unknown) {
    if (prepared.recipe.guide_path || !prepared.recipe.clean.route_m.empty()) throw;
    answers.candidates = candidates_of_unit(prepared.recipe, unknown.could_be());
    if (answers.candidates.empty()) throw;
    throw Question(unknown.what(), std::move(answers.candidates));
  }
  prepared.recipe.read.up = *answers.told;
  Mesh mesh = read(prepared, summary);
  summary.read.up_why =
      "because this way up the road is crowned, banked inwards or above other ground";
  return mesh;
}

[[noreturn]] void ask(const std::string& why, const Mesh& mesh, const Recipe& recipe,
                      std::vector<Candidate> could_be, const std::string& picture_path) {
  base::write_file(picture_path,
                   question_picture(recipe.name + ": which road is meant?", mesh, could_be));
  const std::string question = fmt::format("{}; which road is meant? {} shows {} that could be",
                                           why, picture_path, could_be.size());
  throw Question(question, std::move(could_be));
}

/// What a stage has found of the road. Where it refuses, and nobody has said yet which road is
/// meant, says in which other unit there is a road; or asks, with a picture of the answers.
template <typename Found>
Found found_or_asked(base::Answer<Found> found, const Mesh& mesh, double metres_per_unit,
                     const Recipe& recipe, const std::string& picture_path) {
  if (found || recipe.clean.guide || !recipe.clean.route_m.empty())
    return std::move(found).or_throw();
  const std::string& refused = found.refusal().message;
  if (recipe.read.scale == 1.0) refuse_in_this_unit(refused, mesh, metres_per_unit, recipe);
  std::vector<Candidate> could_be = candidates(mesh, recipe);
  if (could_be.empty())
    throw Error(
        fmt::format("{}; or give a rough line along the road that is meant: --guide FILE (CSV, "
                    "GPX, KML, GeoJSON)",
                    refused));
  ask(refused, mesh, recipe, std::move(could_be), picture_path);
}

/// Where shape alone told the road, and something speaks against it: asks which of the
/// strips; where an open one is the only one, whether it is the road. A way up that the road told
/// is part of the answer: another strip may not tell it.
void ask_for_strip(const std::vector<std::string>& doubts, const MadeRoad& built,
                   const Recipe& recipe, const std::string& picture_path) {
  const CleanReport& report = built.summary.clean;
  if (doubts.empty() || report.by_names || report.by_colour || report.by_guide ||
      recipe.clean.near_m)
    return;
  std::vector<Candidate> could_be = candidates_of_strips(built.mesh, recipe);
  if (recipe.read.up != built.summary.recipe.read.up)
    for (Candidate& strip : could_be)
      strip.flags = fmt::format("--up {} {}", name_of(recipe.read.up), strip.flags);
  // A closed road that is doubted and has no rival is another doubt than which of several.
  if (could_be.size() > (built.centreline.closed ? 1u : 0u))
    ask(doubts.front(), built.mesh, recipe, std::move(could_be), picture_path);
}

/// Cleans the mesh, or takes what was kept of the last time.
base::Answer<RoadMesh> cleaned_mesh(const Recipe& recipe, const Prepared& prepared,
                                    const MakeOptions& options, MadeRoad& built) {
  std::vector<InputFile> mesh_files;
  for (const InputFile& input : built.summary.inputs)
    if (input.role == "mesh" || input.role == kMeshFile) mesh_files.push_back(input);
  const std::string key = clean_key(recipe, prepared.recipe.clean.guide, prepared.tilt_and_scale,
                                    program_name() + " " + base::sha256_of_program(), mesh_files);
  std::optional<Cleaned> cleaned = options.clean_cache_path.empty()
                                       ? std::nullopt
                                       : read_clean_cache(key, options.clean_cache_path);
  built.clean_reused = cleaned.has_value();
  if (!cleaned) {
    cleaned.emplace();
    auto road = try_clean(built.mesh, prepared.recipe.clean, &cleaned->report);
    if (!road) return road;
    cleaned->road = *std::move(road);
    if (built.mesh.triangles.size() >= kTrianglesWorthKeeping && !options.clean_staged_path.empty())
      write_clean_cache(*cleaned, key, options.clean_staged_path);
  }
  built.summary.clean = std::move(cleaned->report);
  return std::move(cleaned->road);
}

/// Of the whole road, or of a stretch; then the line is its own.
SampledGrid sampled_grid(const Recipe& recipe, const std::optional<URange>& stretch,
                         const RaySurface& surface, MadeRoad& built) {
  SampleReport& report = built.summary.sample;
  std::optional<RowRange> rows;
  if (stretch) rows = rows_between(built.line, stretch->u_begin_m, stretch->u_end_m);
  SampledGrid sampled =
      rows ? sample_rows(built.road, surface, built.line, *rows, built.centreline, recipe.sample,
                         &report)
           : sample_grid(built.road, surface, built.line, built.centreline, recipe.sample, &report);
  if (rows) built.line = line_of_rows(built.line, *rows);
  close_cracks(sampled, surface, built.road, built.line, report);
  end_at_walls(sampled, built.line, built.mesh, recipe.sample.threads, report);
  if (!rows) {
    built.edges = road_edges(sampled, built.line, built.centreline, report);
    end_where_whole(sampled, built.edges, built.line, report);
    built.summary.road_edges = built.edges;
  }
  return sampled;
}

void put_on_the_earth(const Recipe& recipe, MadeRoad& built) {
  std::optional<Placement>& placement = built.summary.placement;
  if (recipe.trajectory_path)
    placement = place_road(recipe, line_with_heights(built.line, built.sampled));
  else if (placement && placement->by == "guide") {
    const crg::ReferenceLine line = line_with_heights(built.line, built.sampled);
    std::vector<Eigen::Vector3d> middle_m;
    for (std::size_t i = 0; i < line.size(); ++i)
      middle_m.emplace_back(line.x_m[i], line.y_m[i], line.z_m[i]);
    placement->align =
        fit_guide(middle_m, line.closed, guide_on_the_earth(recipe, placement->projection))
            .or_throw();
  }
  if (!placement) return;
  apply_alignment(placement->align.T_global_mesh, built.line);
  for (KerbPatch& patch : built.patches)
    apply_alignment(placement->align.T_global_mesh, patch.line);
}

}  // namespace

std::vector<InputFile> inputs_of(const Recipe& recipe) {
  std::vector<InputFile> inputs;
  const auto add = [&](const char* role, const std::optional<std::string>& path) {
    if (path) inputs.push_back({role, *path, base::sha256_of_file(*path)});
  };
  if (!recipe.recipe_path.empty()) add("recipe", recipe.recipe_path);
  add("mesh", recipe.mesh_path);
  add("guide", recipe.guide_path);
  add("guide_mapping", recipe.guide_mapping_path);
  add("control_points", recipe.control_points_path);
  add("trajectory", recipe.trajectory_path);
  add("kerb_zones", recipe.kerb.zones_path);
  if (!recipe.friction.wanted) return inputs;
  add("friction_picture", recipe.friction.picture_path);
  if (recipe.friction.picture_path)
    add("friction_world_file", world_file_of(*recipe.friction.picture_path));
  add("friction_zones", recipe.friction.zones_path);
  return inputs;
}

MadeRoad make_road(const Recipe& recipe, const std::vector<InputFile>& inputs,
                   const MakeOptions& options) {
  MadeRoad built;
  BuildSummary& summary = built.summary;
  summary.recipe = recipe;
  summary.inputs = inputs;
  Stages stage(options.progress, built.seconds, kBuildStages);
  Prepared prepared = prepare(recipe, summary);
  if (options.stretch && (recipe.trajectory_path || prepared.guide_lays_mesh))
    throw Error(
        "a stretch of a road that a trajectory or its guide lays on the Earth: the whole road is "
        "needed to tell where it lies; build it, and give its yaw_deg and translation_m (align in "
        "summary.json)");
  const auto finding = [&](const char* name, const auto& body) {
    return stage(name, [&] {
      return found_or_asked(body(), built.mesh, summary.read.metres_per_unit, prepared.recipe,
                            options.question_path);
    });
  };
  built.mesh = stage("read", [&] { return read_or_ask(prepared, summary); });
  if (prepared.guide_lays_mesh)
    stage("lay_on_guide", [&] {
      summary.placement = place_by_guide(prepared.recipe, built.mesh);
      prepared.recipe.clean.guide = place_guide(recipe, summary.placement);
    });
  built.road = finding("clean", [&] { return cleaned_mesh(recipe, prepared, options, built); });
  built.centreline = finding(
      "centreline", [&] { return try_trace_centreline(built.road, prepared.recipe.centreline); });
  built.line = finding("reference_line", [&] {
    return try_fit_reference_line(built.centreline, recipe.reference_line, &summary.reference_line);
  });
  const RaySurface surface(built.road.mesh);
  built.sampled =
      stage("sample", [&] { return sampled_grid(recipe, options.stretch, surface, built); });
  if (options.keep_before && built.sampled.grid.z_m.size() <= kMaxBeforeNodes)
    built.before = built.sampled.grid;
  for (const GridStage& grid_stage : grid_stages())
    if (grid_stage.wanted == nullptr || grid_stage.wanted(recipe))
      stage(grid_stage.name, [&] {
        grid_stage.run({prepared.recipe, prepared.paint, surface, built});
      });
  if (!recipe.line_is_right && !options.stretch)
    built.doubts = stage("doubt", [&] {
      auto doubts =
          doubts_about(built.centreline, surface, built.road.mesh, built.mesh, summary.clean);
      const std::size_t of_strips = doubts.size();
      if (doubts.empty() &&
          prepared.recipe.read.up == UpAxis::automatic)  // of a verge it says nothing
        if (auto up = doubt_about_up(built.centreline, surface, up_called(summary.read.up)))
          doubts.push_back(std::move(*up));
      if (auto ends = doubt_about_ends(built.centreline, built.mesh, prepared.recipe.clean))
        doubts.push_back(std::move(*ends));
      if (prepared.recipe.read.unit == Unit::automatic && prepared.recipe.read.scale == 1.0 &&
          prepared.tilt_and_scale.is_identity()) {
        if (auto width =
                doubt_about_width(built.centreline, built.mesh, summary.read, prepared.recipe))
          doubts.push_back(std::move(*width));
        else if (auto wide = remark_on_width(built.centreline, summary.read))
          summary.read.remarks.push_back(std::move(*wide));
      }
      // A missing piece and another unit come first: they change the strips.
      if (doubts.size() == of_strips)
        ask_for_strip(doubts, built, prepared.recipe, options.question_path);
      return doubts;
    });
  stage("align", [&] { put_on_the_earth(recipe, built); });
  return built;
}

}  // namespace road
