#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/statistics.h"
#include "make/place.h"
#include "make/question.h"
#include "mesh/error.h"
#include "road/centreline.h"
#include "road/clean.h"

namespace road {

namespace {

constexpr std::size_t kMostFitted = 500;  // of a line that is fitted: the fit is quadratic in them
// A guide is the way of a car on the road, and GNSS is metres off; more beside it is another road.
constexpr double kGuideOff_m = 4.0;
constexpr double kAlikeLengths = 0.8;
// Two roads of one mesh that put it less than this apart say the same.
constexpr double kSamePlace_m = 10.0;
constexpr const char* kWayOutOfGuide =
    "say where the mesh lies (--control-points FILE with latitudes and longitudes), or give the "
    "guide as x_m,y_m in the frame of the mesh";

std::vector<Eigen::Vector3d> thinned(const std::vector<Eigen::Vector3d>& points_m) {
  std::vector<Eigen::Vector3d> few;
  const std::size_t step = std::max<std::size_t>(1, points_m.size() / kMostFitted);
  for (std::size_t i = 0; i < points_m.size(); i += step) few.push_back(points_m[i]);
  return few;
}

double length_in_plan_m(const std::vector<Eigen::Vector3d>& points_m, bool closed) {
  double length_m = closed ? (points_m.front() - points_m.back()).head<2>().norm() : 0.0;
  for (std::size_t i = 1; i < points_m.size(); ++i)
    length_m += (points_m[i] - points_m[i - 1]).head<2>().norm();
  return length_m;
}

/// A way over the mesh that the guide may follow.
struct Way {
  std::vector<Eigen::Vector3d> points_m;
  double width_m = 0.0;
  bool closed = false;
};

struct Laid {
  AlignReport align;
  Eigen::Vector3d middle_m;  ///< where the middle of the mesh's way went
};

/// Empty when the guide is not the way of a car along `way`.
std::optional<Laid> laid_along(const Way& way, const Guide& guide, std::string& why_not) {
  if (guide.closed != way.closed) return std::nullopt;
  const double ratio =
      length_in_plan_m(guide.points_m, guide.closed) / length_in_plan_m(way.points_m, way.closed);
  if (!(ratio > kAlikeLengths && ratio < 1.0 / kAlikeLengths)) return std::nullopt;
  Laid laid;
  auto align = fit_guide(way.points_m, way.closed, guide);
  if (!align) {
    why_not = align.refusal().message;
    return std::nullopt;
  }
  laid.align = *std::move(align);
  if (!(laid.align.rms_m <= 0.5 * way.width_m + kGuideOff_m)) return std::nullopt;
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : way.points_m)
    middle_m += p / static_cast<double>(way.points_m.size());
  const RotoTranslation& T = laid.align.T_global_mesh;
  laid.middle_m =
      Eigen::AngleAxisd(T.yaw_rad, Eigen::Vector3d::UnitZ()) * middle_m + T.translation_m;
  return laid;
}

/// What the build finds without the guide first; it may be right, and then nothing else is tried.
std::vector<Way> way_without_guide(const Mesh& mesh, const Recipe& recipe) {
  const auto line = try_clean(mesh, recipe.clean).and_then([&](const RoadMesh& road) {
    return try_trace_centreline(road, recipe.centreline);
  });
  if (!line) return {};
  return {{line->points_m, 2.0 * base::median(line->half_width_m), line->closed}};
}

}  // namespace

base::Answer<AlignReport> fit_guide(const std::vector<Eigen::Vector3d>& middle_m, bool closed,
                                    const Guide& guide) {
  std::vector<Eigen::Vector3d> middle = thinned(middle_m), driven = thinned(guide.points_m);
  if (guide.closed) driven.push_back(driven.front());
  const bool heights = std::none_of(driven.begin(), driven.end(),
                                    [](const Eigen::Vector3d& p) { return std::isnan(p.z()); });
  if (!heights)
    for (auto* points : {&middle, &driven})
      for (Eigen::Vector3d& p : *points) p.z() = 0.0;
  auto report = fit_to_trajectory(middle, closed, driven);
  if (report) report->residual_m.clear();
  return report;
}

Placement place_by_guide(Recipe recipe, const Mesh& mesh) {
  const std::string& path = *recipe.guide_path;
  Placement placement;
  placement.by = "guide";
  const Guide guide = guide_on_the_earth(recipe, placement.projection);
  recipe.clean.guide.reset();
  std::vector<Laid> found;
  std::size_t tried = 0;
  std::string why_not;
  const auto try_ways = [&](const std::vector<Way>& ways) {
    tried += ways.size();
    for (const Way& way : ways)
      if (auto laid = laid_along(way, guide, why_not)) found.push_back(std::move(*laid));
  };
  try_ways(way_without_guide(mesh, recipe));
  if (found.empty()) {
    std::vector<Way> ways;
    for (Candidate& candidate : candidates(mesh, recipe))
      ways.push_back({std::move(candidate.points_m), candidate.width_m, candidate.closed});
    try_ways(ways);
  }
  if (found.empty())
    throw Error(fmt::format(
        "{}: has latitudes and longitudes, and its way ({:.0f} m, {}) does not lie on the mesh by "
        "its shape: {} road(s) tried{}{}; {}",
        path, length_in_plan_m(guide.points_m, guide.closed), guide.closed ? "closed" : "open",
        tried, why_not.empty() ? "" : ", ", why_not, kWayOutOfGuide));
  const auto best = std::min_element(found.begin(), found.end(), [](const Laid& a, const Laid& b) {
    return a.align.rms_m < b.align.rms_m;
  });
  for (const Laid& other : found)
    if ((other.middle_m - best->middle_m).head<2>().norm() > kSamePlace_m)
      throw Error(
          fmt::format("{}: has latitudes and longitudes, and its shape is that of two roads of the "
                      "mesh, {:.2f} "
                      "and {:.2f} m rms beside it; {}",
                      path, best->align.rms_m, other.align.rms_m, kWayOutOfGuide));
  placement.align = best->align;
  return placement;
}

}  // namespace road
