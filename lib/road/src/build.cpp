#include "road/build.h"

#include <fmt/format.h>

#include <chrono>
#include <cstring>
#include <filesystem>

#include "crg/file.h"
#include "report/relief.h"
#include "road/atomic_file.h"
#include "road/error.h"
#include "road/ray_surface.h"
#include "road/road_mesh_file.h"
#include "road/summary.h"

namespace road {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Runs one stage, keeps its seconds.
class Stages {
 public:
  Stages(const Progress& progress, std::vector<StageSeconds>& seconds) : progress_(progress), seconds_(seconds) {}

  template <typename Body>
  auto operator()(const std::string& name, const Body& body) {
    if (progress_) progress_(name, static_cast<double>(seconds_.size()) / kStages);
    const Stopwatch stopwatch{name, seconds_};
    return body();
  }

 private:
  static constexpr double kStages = 11.0;
  struct Stopwatch {
    const std::string& name;
    std::vector<StageSeconds>& seconds;
    Clock::time_point start = Clock::now();
    ~Stopwatch() { seconds.push_back({name, seconds_since(start)}); }
  };
  const Progress& progress_;
  std::vector<StageSeconds>& seconds_;
};

void make_folder(const std::string& path) {
  std::error_code problem;
  std::filesystem::create_directories(path, problem);
  if (problem || !std::filesystem::is_directory(path)) {
    throw Error(fmt::format("{}: cannot make this folder: {}; give a folder that can be written with -o", path,
                            problem ? problem.message() : "a file of that name is in the way"));
  }
}

std::optional<AlignReport> alignment_of(const Recipe& recipe) {
  if (recipe.control_points_path) return fit_alignment(read_control_points(*recipe.control_points_path));
  if (!recipe.T_global_mesh) return std::nullopt;
  AlignReport given;
  given.T_global_mesh = *recipe.T_global_mesh;
  return given;
}

std::string picture_of(const Recipe& recipe, const crg::ReferenceLine& line, const SampledGrid& sampled) {
  static_assert(static_cast<int>(SurfaceClass::road) == 0 && static_cast<int>(SurfaceClass::kerb) == 1 &&
                static_cast<int>(SurfaceClass::runoff) == 2 && sizeof(SurfaceClass) == 1);
  report::ReliefInput input;
  input.title = recipe.name;
  input.u_begin_m = line.u_begin_m;
  input.u_step_m = line.u_step_m;
  input.x_m = line.x_m;
  input.y_m = line.y_m;
  input.v_m = sampled.grid.v_m;
  input.z_m = sampled.grid.z_m;
  input.kind = {reinterpret_cast<const std::uint8_t*>(sampled.surface_class.data()), sampled.surface_class.size()};
  input.closed = line.closed;
  if (!line.z_m.empty()) input.z_offset_m = line.z_m.front();
  report::ReliefOptions options;
  options.threads = recipe.sample.threads;
  return report::relief_png(input, options);
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
  Stages stage(progress, summary.seconds);

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
  stage("picture", [&] { write_file(paths.picture_path, picture_of(recipe, line, sampled)); });
  stage("write", [&] { crg::write(track_crg(line, std::move(sampled.grid)), paths.crg_path, recipe.format); });
  stage("validate", [&] { summary.validate = validate(paths.crg_path, mesh, validate_options); });
  paths.validation_failures = validation_failures(summary.validate, recipe.limits);
  summary.seconds_total = seconds_since(start);
  paths.summary_json = summary_json(summary);
  write_file(paths.summary_path, paths.summary_json);
  return paths;
}

}  // namespace road
