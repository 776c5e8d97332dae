#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "base/parallel.h"
#include "base/write_file.h"
#include "commands.h"
#include "crg/file.h"
#include "make/make_track.h"
#include "make/place.h"
#include "make/road_mesh_file.h"
#include "make/summary.h"
#include "road/track_crg.h"

namespace crgbuild {
namespace {

/// A file as line and heights in the map frame: what the stages work on.
struct Track {
  crg::ReferenceLine line;
  crg::Grid grid;
};

Track read_track(const std::string& path) {
  crg::Crg file = crg::read(path);
  Track track;
  track.line = crg::integrate_reference_line(file);
  track.grid = std::move(file.grid);
  const std::size_t columns = track.grid.columns();
  for (std::size_t i = 0; i < track.grid.rows(); ++i) {
    const double z = track.line.z_m.empty() ? 0.0 : track.line.z_m[i];
    const double banking = track.line.banking.empty() ? 0.0 : track.line.banking[i];
    if (z == 0.0 && banking == 0.0) continue;
    for (std::size_t j = 0; j < columns; ++j)
      track.grid.at(i, j) += static_cast<float>(z + banking * track.grid.v_m[j]);
  }
  track.line.z_m.clear();
  track.line.banking.clear();
  return track;
}

void write_track(Track track, const std::string& path, crg::Format format) {
  base::write_file(path, crg::to_bytes(road::track_crg(track.line, std::move(track.grid)), format));
}

/// The class of each node is that of the mesh surface at its height.
road::SampledGrid classified(Track& track, const road::RoadMesh& mesh,
                             const road::RaySurface& surface, unsigned threads) {
  constexpr double kReach = 0.1;
  road::SampledGrid sampled;
  sampled.grid = std::move(track.grid);
  const std::size_t columns = sampled.grid.columns();
  sampled.provenance.assign(sampled.grid.z_m.size(), road::Provenance::none);
  sampled.surface_class.assign(sampled.grid.z_m.size(), road::SurfaceClass::road);
  base::parallel_for(sampled.grid.rows(), 64, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t j = 0; j < columns; ++j) {
        const float z = sampled.grid.at(i, j);
        if (std::isnan(z)) continue;
        const crg::Point2 p = crg::node_position(track.line, i, sampled.grid.v_m[j]);
        const auto hit = surface.nearest_hit(p.x_m, p.y_m, z, kReach);
        sampled.provenance[i * columns + j] =
            hit ? road::Provenance::mesh : road::Provenance::filled;
        if (hit) sampled.surface_class[i * columns + j] = mesh.class_of_triangle[hit->triangle];
      }
  });
  return sampled;
}

/// What the recipe says of kerbs, over what the mesh says.
std::vector<road::KerbZone> kerb_zones(const road::Recipe& recipe) {
  return recipe.kerb.zones_path ? road::read_kerb_zones(*recipe.kerb.zones_path)
                                : std::vector<road::KerbZone>{};
}

/// The recipe with its guide read, in the frame of the mesh.
road::Recipe with_guide(road::Recipe recipe) {
  road::set_guide(recipe, road::place_mesh(recipe));
  return recipe;
}

void report(Terminal& terminal, const std::string& json, const std::string& text) {
  terminal.progress_done();
  terminal.print(terminal.json ? json : text);
}

void report(Terminal& terminal, const nlohmann::ordered_json& numbers, const std::string& text) {
  report(terminal, base::json_text(numbers), text);
}

}  // namespace

int run_clean(const CleanCommand& command, Terminal& terminal) {
  const road::Recipe recipe = with_guide(make_recipe(command.input, command.flags));
  const road::Progress progress = terminal.progress();
  progress("read", 0.0);
  road::CleanReport clean_report;
  const road::Mesh mesh =
      road::read_mesh(recipe.mesh_path, road::read_to_clean(recipe.read, recipe.clean));
  progress("clean", 0.5);
  const road::RoadMesh road = road::clean(mesh, recipe.clean, &clean_report);
  road::write_road_mesh(road, command.output);
  std::string text = fmt::format("kept {} of {} triangles (by {})\n", clean_report.triangles_kept,
                                 clean_report.triangles_in, road::told_by(clean_report));
  for (const auto& [name, count] : clean_report.kept)
    text += fmt::format("  {}: {}\n", name, count);
  for (const auto& [reason, count] : clean_report.dropped)
    text += fmt::format("  dropped, {}: {}\n", reason, count);
  for (const std::string& remark : clean_report.remarks) text += "  " + one_line(remark) + "\n";
  report(terminal,
         {{"triangles_in", clean_report.triangles_in},
          {"triangles_kept", clean_report.triangles_kept},
          {"triangles_kept_by_class", clean_report.kept},
          {"triangles_dropped_by_reason", clean_report.dropped},
          {"by_names", clean_report.by_names},
          {"by_guide", clean_report.by_guide},
          {"told_by", road::told_by(clean_report)},
          {"vertices_welded", clean_report.vertices_welded},
          {"remarks", clean_report.remarks}},
         text + "surface  " + command.output + "\n");
  return kOk;
}

int run_preview(const PreviewCommand& command, Terminal& terminal) {
  terminal.start("reading the mesh");
  const road::Preview preview =
      road::preview(make_recipe(command.input, command.flags), command.most_triangles,
                    command.raw ? road::PreviewClasses::none : road::PreviewClasses::cleaned);
  base::write_file(command.output, road::glb_of(preview));
  std::map<std::string, double> area_m2;
  std::map<std::string, std::size_t> triangles;
  for (const road::PreviewPart& part : preview.parts) {
    area_m2[part.surface_class] += part.area_m2;
    triangles[part.surface_class] += part.triangles;
  }
  std::string text = fmt::format("{} of {} triangles, {} objects{}\n", preview.triangles_shown,
                                 preview.triangles_in, preview.objects.size(),
                                 preview.told_by.empty() ? "" : ", told by " + preview.told_by);
  for (const auto& [name, count] : triangles)
    text += fmt::format("  {}: {} triangles, {:.0f} m2\n", name, count, area_m2[name]);
  if (!preview.refusal.empty())
    terminal.remark("no road can be made of it as it is: " + preview.refusal);
  report(terminal,
         {{"triangles_in", preview.triangles_in},
          {"triangles_shown", preview.triangles_shown},
          {"objects", preview.objects.size()},
          {"triangles_by_class", triangles},
          {"area_by_class_m2", area_m2},
          {"told_by", preview.told_by},
          {"refusal", preview.refusal},
          {"remarks", preview.remarks},
          {"preview", command.output}},
         text + "preview  " + command.output + "\n");
  return kOk;
}

int run_centreline(const CentrelineCommand& command, Terminal& terminal) {
  const road::Recipe recipe = with_guide(make_recipe(command.input, command.flags));
  const road::Progress progress = terminal.progress();
  progress("read", 0.0);
  const road::RoadMesh mesh = road::read_road_mesh(recipe);
  progress("centreline", 0.5);
  const road::Centreline line = road::trace_centreline(mesh, recipe.centreline);
  road::write_centreline_csv(line, command.output);
  const road::CentrelineReport numbers = road::describe(line);
  report(terminal,
         {{"stations", numbers.stations},
          {"length_m", numbers.length_m},
          {"closed", numbers.closed},
          {"width_min_m", numbers.width_min_m},
          {"width_median_m", numbers.width_median_m},
          {"width_max_m", numbers.width_max_m}},
         fmt::format("{} road of {:.1f} m, {:.1f} to {:.1f} m wide\ncentreline  {}\n",
                     numbers.closed ? "closed" : "open", numbers.length_m, numbers.width_min_m,
                     numbers.width_max_m, command.output));
  return kOk;
}

int run_sample(const SampleCommand& command, Terminal& terminal) {
  const road::Recipe recipe = make_recipe(command.input, command.flags);
  const road::Progress progress = terminal.progress();
  progress("read", 0.0);
  const road::Centreline centreline = road::read_centreline_csv(command.centreline);
  const road::RoadMesh mesh = road::read_road_mesh(recipe);
  progress("reference_line", 0.3);
  road::ReferenceLineReport line_report;
  const crg::ReferenceLine line =
      road::fit_reference_line(centreline, recipe.reference_line, &line_report);
  const road::RaySurface surface(mesh.mesh);
  progress("sample", 0.4);
  road::SampleReport numbers;
  road::SampledGrid sampled =
      road::sample_grid(mesh, surface, line, centreline, recipe.sample, &numbers);
  progress("write", 0.9);
  write_track({line, std::move(sampled.grid)}, command.output, recipe.format);
  report(
      terminal,
      {{"length_m", line_report.length_m},
       {"closed", line_report.closed},
       {"nodes", numbers.nodes},
       {"nodes_with_z", numbers.nodes_with_z},
       {"filled", numbers.filled},
       {"holes", numbers.holes},
       {"folds", numbers.folds.size()},
       {"neighbours", numbers.neighbours.size()}},
      fmt::format("{} line of {:.3f} m; {} nodes, {} with height, {} filled, {} holes\nroad  {}\n",
                  line_report.closed ? "closed" : "open", line_report.length_m, numbers.nodes,
                  numbers.nodes_with_z, numbers.filled, numbers.holes, command.output));
  return kOk;
}

int run_kerb(const KerbCommand& command, Terminal& terminal) {
  road::Recipe recipe = make_recipe(command.mesh, command.flags);
  recipe.kerb.zones = kerb_zones(recipe);
  const road::Progress progress = terminal.progress();
  progress("read", 0.0);
  Track track = read_track(command.crg);
  const road::RoadMesh mesh = road::read_road_mesh(recipe);
  const road::RaySurface surface(mesh.mesh);
  progress("classify", 0.3);
  road::SampledGrid sampled = classified(track, mesh, surface, recipe.sample.threads);
  progress("kerb", 0.6);
  road::KerbReport numbers;
  sampled =
      road::refine_kerbs(std::move(sampled), surface, mesh, track.line, recipe.kerb, &numbers);
  write_track({track.line, std::move(sampled.grid)}, command.output, recipe.format);
  std::string text;
  for (const road::Kerb& kerb : numbers.kerbs)
    text += fmt::format("  u {:.1f} to {:.1f} m, v {:.2f} to {:.2f} m, {:.0f} mm high\n",
                        kerb.u_begin_m, kerb.u_end_m, kerb.v_begin_m, kerb.v_end_m,
                        1e3 * kerb.height_m);
  report(terminal,
         {{"kerbs", numbers.kerbs.size()},
          {"cells", numbers.cells},
          {"columns_added", numbers.columns_added}},
         fmt::format("{} kerbs, {} columns added\n{}road  {}\n", numbers.kerbs.size(),
                     numbers.columns_added, text, command.output));
  return kOk;
}

int run_smooth(const SmoothCommand& command, Terminal& terminal) {
  if (command.mesh.empty() && !command.ignore_kerbs)
    throw UsageError(
        "smoothing has to know where the kerbs are: give --mesh, or --ignore-kerbs for "
        "a road without kerbs");
  const road::Recipe recipe =
      command.mesh.empty() ? make_recipe(command.flags) : make_recipe(command.mesh, command.flags);
  if (!(recipe.smooth.window_u_m > 0.0) && !(recipe.smooth.window_v_m > 0.0))
    throw UsageError(
        "smooth_window_m and smooth_window_v_m are 0, which changes nothing; give "
        "--smooth-window-m in "
        "metres");
  const road::Progress progress = terminal.progress();
  progress("read", 0.0);
  Track track = read_track(command.crg);
  road::SampledGrid sampled;
  if (command.mesh.empty()) {
    sampled.grid = std::move(track.grid);
    sampled.surface_class.assign(sampled.grid.z_m.size(), road::SurfaceClass::road);
    for (const float z : sampled.grid.z_m)
      sampled.provenance.push_back(std::isnan(z) ? road::Provenance::none : road::Provenance::mesh);
  } else {
    const road::RoadMesh mesh = road::read_road_mesh(recipe);
    progress("classify", 0.3);
    sampled = classified(track, mesh, road::RaySurface(mesh.mesh), recipe.sample.threads);
    road::mark_kerb_zones(sampled, kerb_zones(recipe));
  }
  progress("smooth", 0.6);
  road::SmoothOptions options = recipe.smooth;
  options.closed = track.line.closed;
  road::SmoothReport numbers;
  road::smooth(sampled, options, &numbers);
  write_track({track.line, std::move(sampled.grid)}, command.output, recipe.format);
  const std::string waves =
      numbers.halved_waves_m
          ? fmt::format("waves of {:.1f} to {:.1f} m lost more than half of their power\n",
                        numbers.halved_waves_m->shortest_m, numbers.halved_waves_m->longest_m)
          : "";
  report(terminal, road::json_text(numbers, options),
         fmt::format("largest change {:.2f} mm on the road (u = {:.1f} m, v = {:.1f} m), {:.2f} mm "
                     "on kerbs; {} "
                     "nodes at the bound\n{}road  {}\n",
                     1e3 * numbers.largest_change_road_m, numbers.largest_change_u_m,
                     numbers.largest_change_v_m, 1e3 * numbers.largest_change_kerb_m,
                     numbers.nodes_at_bound, waves, command.output));
  return kOk;
}

int run_align(const AlignCommand& command, Terminal& terminal) {
  const road::Recipe recipe = make_recipe(command.flags);
  if (!recipe.control_points_path && !recipe.trajectory_path && !recipe.T_global_mesh)
    throw UsageError(
        "nothing to align with: give --control-points, --trajectory, or --yaw-deg and "
        "--translation-m");
  if (recipe.align.rotation != road::AlignOptions::Rotation::about_z || recipe.align.scale)
    throw UsageError(
        "a finished road can be turned about z and moved; what tilts or scales it has to be done "
        "to its mesh: build it "
        "with align_rotation: free or align_scale: true instead");
  Track track = read_track(command.crg);
  const auto placement = road::place_road(recipe, track.line);
  const road::AlignReport& numbers = placement->align;
  road::apply_alignment(numbers.T_global_mesh, track.line);
  crg::Crg file = road::track_crg(track.line, std::move(track.grid));
  road::write_projection(placement->projection, track.line, file);
  base::write_file(command.output, crg::to_bytes(file, recipe.format));
  for (const std::string& name : numbers.outliers)
    terminal.remark("control point left out, it contradicts the others: " + name);
  const Eigen::Vector3d& t = numbers.T_global_mesh.translation_m;
  const double yaw_deg = numbers.T_global_mesh.yaw_rad * 180.0 / M_PI;
  report(terminal, road::json_text(*placement),
         fmt::format(
             "turned by {:.6f} deg, moved by {:.4f}, {:.4f}, {:.4f} m; rms {:.4f} m\nroad  {}\n",
             yaw_deg, t.x(), t.y(), t.z(), numbers.rms_m, command.output));
  return kOk;
}

int run_validate(const ValidateCommand& command, Terminal& terminal) {
  const road::Recipe recipe = make_recipe(command.mesh, command.flags);
  const road::Progress progress = terminal.progress();
  progress("read", 0.0);
  road::Mesh mesh = road::read_mesh(recipe.mesh_path, recipe.read);
  progress("validate", 0.5);
  road::ValidateOptions options = recipe.validate;
  if (recipe.trajectory_path)
    throw UsageError(
        "a trajectory does not tell where the mesh of a finished road lies; give --yaw-deg and "
        "--translation-m "
        "as summary.json of the build has them under align");
  if (const auto placement = road::place_mesh(recipe)) {
    options.T_global_mesh = placement->align.T_global_mesh;
    road::apply_to_mesh(placement->align.tilt_and_scale, mesh);
  }
  const road::ValidateReport numbers = road::validate(command.crg, mesh, options);
  const std::vector<std::string> failures = road::validation_failures(numbers, recipe.limits);
  const road::ErrorQuantiles& z = numbers.z_error_m;
  std::string text = fmt::format(
      "{} points: half within {:.3f} mm, 95 % within {:.3f} mm, 99 % within {:.3f} mm, all within "
      "{:.3f} mm (worst at u = {:.2f} m, v = {:.2f} m)\n{} points without mesh; seam: {:.3f} mm, "
      "{:.3f} mrad\n",
      numbers.points, 1e3 * z.p50, 1e3 * z.p95, 1e3 * z.p99, 1e3 * z.max, numbers.worst_u_m,
      numbers.worst_v_m, numbers.points_without_mesh, 1e3 * numbers.seam_z_step_m,
      1e3 * numbers.seam_heading_step_rad);
  for (const std::string& remark : numbers.remarks) text += one_line(remark) + "\n";
  report(terminal, road::json_text(numbers, recipe.limits), text);
  if (!failures.empty()) throw NotValid(road::validation_failed(command.crg, failures));
  return kOk;
}

}  // namespace crgbuild
