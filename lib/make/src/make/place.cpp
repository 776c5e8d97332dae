#include "make/place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mesh/error.h"

namespace road {

namespace {

// More points than this tell a fit of three numbers nothing new.
constexpr std::size_t kMostPoints = 2000;

template <class Body>
auto naming(const std::string& path, const Body& body) {
  try {
    return body();
  } catch (const Error& error) {
    const std::string text = error.what();
    throw Error(text.find(path) == std::string::npos ? path + ": " + text : text);
  }
}

/// Whether the points fit when their latitudes and longitudes are changed like this.
template <class Change>
bool fits_when(ControlPoints file, const AlignOptions& options, const Change& change) {
  for (std::size_t i = 0; i < file.points.size(); ++i) {
    const Eigen::Vector2d at = change(file.latitude_longitude_deg[i]);
    if (i == 0) {
      const auto projection = try_projection_at(file.projection.kind, at.x(), at.y());
      if (!projection) return false;
      file.projection = *projection;
    }
    const auto map_m = try_project(file.projection, at.x(), at.y());
    if (!map_m) return false;
    file.points[i].global_m.head<2>() = *map_m;
  }
  return static_cast<bool>(try_fit_alignment(file.points, options));
}

base::Answer<AlignReport> fit_naming_the_reason(const ControlPoints& file,
                                                const AlignOptions& options) {
  auto fitted = try_fit_alignment(file.points, options);
  if (fitted || file.latitude_longitude_deg.empty()) return fitted;
  using Degrees = Eigen::Vector2d;
  if (fits_when(file, options, [](const Degrees& at) { return Degrees(at.y(), at.x()); }))
    return base::Refusal(
        "no rotation and translation fits, but it does with latitude and longitude swapped; "
        "exchange the two columns");
  // North for south and east for west are the same mirror, half a turn apart.
  if (fits_when(file, options, [](const Degrees& at) { return Degrees(-at.x(), at.y()); }))
    return base::Refusal(
        "no rotation and translation fits, but it does in another hemisphere; check the signs of "
        "lat_deg and lon_deg");
  return fitted;
}

Placement by_control_points(const Recipe& recipe, const std::string& path) {
  Placement placement;
  placement.by = "control_points";
  const ControlPoints file = read_control_point_file(path, recipe.projection);
  placement.align =
      naming(path, [&] { return fit_naming_the_reason(file, recipe.align).or_throw(); });
  placement.projection = file.projection;
  for (const ControlPoint& point : file.points) placement.point_names.push_back(point.name);
  return placement;
}

Placement by_values(const RotoTranslation& T_global_mesh) {
  Placement placement;
  placement.by = "values";
  placement.align.T_global_mesh = T_global_mesh;
  return placement;
}

Placement by_trajectory(const Recipe& recipe, const std::string& path,
                        const crg::ReferenceLine& line) {
  Placement placement;
  placement.by = "trajectory";
  const Trajectory file = read_trajectory(path, recipe.projection);
  const auto thin = [](std::size_t count) { return std::max<std::size_t>(1, count / kMostPoints); };
  std::vector<Eigen::Vector3d> middle, driven;
  for (std::size_t i = 0; i < line.size(); i += thin(line.size()))
    middle.emplace_back(line.x_m[i], line.y_m[i], line.z_m.empty() ? 0.0 : line.z_m[i]);
  for (std::size_t i = 0; i < file.points_m.size(); i += thin(file.points_m.size()))
    driven.push_back(file.points_m[i]);
  placement.align =
      naming(path, [&] { return fit_to_trajectory(middle, line.closed, driven).or_throw(); });
  placement.align.residual_m.clear();
  placement.projection = file.projection;
  return placement;
}

/// What projected coordinates do not say themselves.
void set_zone(const Recipe& recipe, Placement& placement) {
  if (placement.projection.kind != Projection::Kind::none || !recipe.utm_zone) return;
  placement.projection.kind = Projection::Kind::utm;
  placement.projection.zone = *recipe.utm_zone;
}

}  // namespace

std::optional<Placement> place_mesh(const Recipe& recipe) {
  if (!recipe.control_points_path &&
      (recipe.align.rotation != AlignOptions::Rotation::about_z || recipe.align.scale))
    throw Error(
        "align_rotation and align_scale are fitted to control points, and there are none; give "
        "control_points too");
  std::optional<Placement> placement;
  if (recipe.control_points_path)
    placement = by_control_points(recipe, *recipe.control_points_path);
  if (recipe.T_global_mesh) placement = by_values(*recipe.T_global_mesh);
  if (placement) set_zone(recipe, *placement);
  // Refused here rather than after the mesh was cleaned.
  if (recipe.trajectory_path) read_trajectory(*recipe.trajectory_path, recipe.projection);
  return placement;
}

std::optional<Guide> place_guide(const Recipe& recipe, const std::optional<Placement>& placement) {
  if (!recipe.guide_path) {
    if (recipe.guide_mapping_path)
      throw Error(*recipe.guide_mapping_path +
                  ": a mapping of the guide, and there is no guide; give --guide FILE too");
    return std::nullopt;
  }
  const std::string& path = *recipe.guide_path;
  GuideFile file = read_guide(path, recipe.guide_mapping_path.value_or(""));
  if (!file.geographic) {
    if (placement)
      for (Eigen::Vector3d& p : file.points) {
        const double z_m = p.z();
        p = placement->align.tilt_and_scale({p.x(), p.y(), std::isnan(z_m) ? 0.0 : z_m});
        if (std::isnan(z_m)) p.z() = z_m;
      }
  } else {
    if (!placement || placement->projection.kind == Projection::Kind::none)
      throw Error(
          fmt::format("{}: has latitudes and longitudes, and nothing tells where the mesh lies on "
                      "the Earth; give control points "
                      "with latitudes and longitudes (--control-points FILE), or the guide as "
                      "x_m,y_m in the frame of the mesh; crgbuild build alone can lay a mesh on a "
                      "guide, where the recipe does not say how it lies",
                      path));
    const RotoTranslation& T = placement->align.T_global_mesh;
    const double cosine = std::cos(T.yaw_rad), sine = std::sin(T.yaw_rad);
    for (Eigen::Vector3d& p : file.points) {
      const Eigen::Vector2d d =
          project(placement->projection, p.x(), p.y()) - T.translation_m.head<2>();
      p = {cosine * d.x() + sine * d.y(), -sine * d.x() + cosine * d.y(),
           p.z() - T.translation_m.z()};
    }
  }
  return naming(path, [&] { return guide_along(file.points); });
}

bool guide_lays_mesh(const Recipe& recipe, const std::optional<Placement>& placement) {
  if (!recipe.guide_path || placement) return false;
  return read_guide(*recipe.guide_path, recipe.guide_mapping_path.value_or("")).geographic;
}

Guide guide_on_the_earth(const Recipe& recipe, Projection& projection) {
  const std::string& path = *recipe.guide_path;
  GuideFile file = read_guide(path, recipe.guide_mapping_path.value_or(""));
  projection = projection_at(recipe.projection, file.points[0].x(), file.points[0].y());
  for (Eigen::Vector3d& p : file.points) p.head<2>() = project(projection, p.x(), p.y());
  return naming(path, [&] { return guide_along(file.points); });
}

void set_guide(Recipe& recipe, const std::optional<Placement>& placement) {
  recipe.clean.guide = place_guide(recipe, placement);
}

base::Answer<CleanReport> report_of_cleaning(Recipe recipe, const Mesh& mesh) {
  try {
    set_guide(recipe, place_mesh(recipe));
  } catch (const Error& error) {  // a file beside the mesh: that can be looked at all the same
    return base::Refusal(error.what());
  }
  CleanReport report;
  const auto road = try_clean(mesh, recipe.clean, &report);
  return road ? base::Answer<CleanReport>(std::move(report)) : road.refusal();
}

std::optional<Placement> place_road(const Recipe& recipe, const crg::ReferenceLine& line) {
  if (!recipe.trajectory_path) return place_mesh(recipe);
  Placement placement = by_trajectory(recipe, *recipe.trajectory_path, line);
  set_zone(recipe, placement);
  return placement;
}

}  // namespace road
