#include "make_steps.h"

#include "base/output_set.h"
#include "report/relief.h"

namespace road {

BuildResult paths_of(const Recipe& recipe, const base::OutputSet& outputs) {
  BuildResult paths;
  paths.crg_path = outputs.path(road_name(recipe));
  paths.stl_path = outputs.path(surface_name(recipe));
  paths.centreline_path = outputs.path(kCentrelineName);
  paths.summary_path = outputs.path(kSummaryName);
  paths.timing_path = outputs.path(kTimingName);
  paths.picture_path = outputs.path(picture_name(recipe));
  paths.classes_path = outputs.path(classes_name(recipe));
  if (recipe.friction.wanted) paths.friction_path = outputs.path(friction_name(recipe));
  return paths;
}

std::string plan_picture(const std::string& title, const crg::ReferenceLine& line,
                         const SampledGrid& sampled, unsigned threads) {
  static_assert(static_cast<int>(SurfaceClass::road) == 0 &&
                static_cast<int>(SurfaceClass::kerb) == 1 &&
                static_cast<int>(SurfaceClass::runoff) == 2 && sizeof(SurfaceClass) == 1);
  report::ReliefInput input;
  input.title = title;
  input.u_begin_m = line.u_begin_m;
  input.u_step_m = line.u_step_m;
  input.x_m = line.x_m;
  input.y_m = line.y_m;
  input.v_m = sampled.grid.v_m;
  input.z_m = sampled.grid.z_m;
  input.kind = {reinterpret_cast<const std::uint8_t*>(sampled.surface_class.data()),
                sampled.surface_class.size()};
  input.closed = line.closed;
  if (!line.z_m.empty()) input.z_offset_m = line.z_m.front();
  report::ReliefOptions options;
  options.threads = threads;
  return report::relief_png(input, options);
}

report::ClassMap class_picture(const Mesh& mesh,
                               const std::vector<SurfaceClass>& class_of_triangle) {
  static_assert(static_cast<int>(SurfaceClass::barrier) == 3 &&
                static_cast<int>(SurfaceClass::scenery) == 4);
  std::vector<report::ClassTriangle> triangles(mesh.triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d p = mesh.origin_m + mesh.vertex(i, k);
      triangles[i].x_m[static_cast<std::size_t>(k)] = p.x();
      triangles[i].y_m[static_cast<std::size_t>(k)] = p.y();
      triangles[i].z_m += p.z() / 3.0;
    }
    triangles[i].kind = static_cast<std::uint8_t>(class_of_triangle[i]);
  }
  return report::class_map(triangles);
}

}  // namespace road
