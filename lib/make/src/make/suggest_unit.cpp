#include "suggest_unit.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/statistics.h"
#include "make/question.h"
#include "mesh/error.h"
#include "mesh/read_mesh.h"
#include "road/centreline.h"

namespace road {
namespace {

constexpr std::size_t kMostTriangles = 100'000;  // about 3 s for each unit
// In its right unit a road is as wide as roads are, not only as wide as the tool can trace: from
// one lane on.
constexpr double kLeastWidth_m = 3.0, kMostWidth_m = 25.0, kShortest_m = 100.0;
constexpr double kTooWide_m = 60.0;
constexpr double kLargestExtent_m = 40e3;  // that a mesh may have
// The ovals of TORCS are 30 m wide; the next that was met, 33 m, was a road in feet.
constexpr double kWidest_m = 31.0;

// Few are wider; in feet it is as wide as two lanes. Taken for metres, but not without a word.
constexpr double kWide_m = 16.4;

// Of several units the one in which the road is about as wide as most comes first.
constexpr double kUsualWidth_m = 11.0;

// Toys and games, whose unit is none of those with a name.
constexpr double kScales[] = {10.0, 100.0};

std::optional<Centreline> road_in(Mesh mesh, double factor, const CleanOptions& options) {
  mesh.origin_m *= factor;
  for (Eigen::Vector3d& v : mesh.vertices_m) v *= factor;
  auto line = try_clean(mesh, options).and_then([](const RoadMesh& road) {
    return try_trace_centreline(road);
  });
  return line ? std::optional<Centreline>(*std::move(line)) : std::nullopt;
}

double typical_width_m(const Centreline& line) { return 2.0 * base::median(line.half_width_m); }

double extent_m(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& v : mesh.vertices_m) box.extend(v);
  return box.sizes().head<2>().maxCoeff();
}

/// The road in the unit of each factor in which it is as wide as roads are, the likeliest first.
std::vector<Candidate> roads_in(const Mesh& mesh,
                                const std::vector<std::pair<std::string, double>>& flag_and_factor,
                                const CleanOptions& options) {
  std::vector<Candidate> found;
  double area = 0.0;  // of all faces: a road has no more
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    area += (mesh.vertex(t, 1) - mesh.vertex(t, 0))
                .cross(mesh.vertex(t, 2) - mesh.vertex(t, 0))
                .norm() /
            2.0;
  const double extent = extent_m(mesh);
  for (const auto& [flag, factor] : flag_and_factor) {
    if (area * factor * factor < kLeastWidth_m * kShortest_m || extent * factor > kLargestExtent_m)
      continue;
    const auto line = road_in(mesh, factor, options);
    if (!line) continue;
    const double width_m = typical_width_m(*line);
    if (width_m >= kLeastWidth_m && width_m <= kMostWidth_m && line->length_m >= kShortest_m)
      found.push_back({flag, line->points_m, line->length_m, width_m, line->closed});
  }
  const auto unusual = [](const Candidate& road) {
    return std::abs(std::log(road.width_m / kUsualWidth_m));
  };
  std::stable_sort(found.begin(), found.end(),
                   [&](const Candidate& a, const Candidate& b) { return unusual(a) < unusual(b); });
  return found;
}

/// The road in every other unit in which it is as wide as roads are; else enlarged.
std::vector<Candidate> other_units(const Mesh& mesh, double metres_per_unit,
                                   const CleanOptions& options) {
  std::vector<std::pair<std::string, double>> units, scales;
  for (const NamedUnit& unit : kUnits)
    if (std::abs(unit.metres - metres_per_unit) >= 1e-6 * unit.metres)
      units.emplace_back(fmt::format("--unit {}", unit.name), unit.metres / metres_per_unit);
  for (const double scale : kScales)
    scales.emplace_back(fmt::format("--scale {:.0f}", scale), scale);
  std::vector<Candidate> found = roads_in(mesh, units, options);
  if (found.empty()) found = roads_in(mesh, scales, options);
  return found;
}

/// Half of it within what rounding and noise leave.
bool is_as_wide_all_along(const Centreline& line) {
  std::vector<double> half_m = line.half_width_m;
  std::sort(half_m.begin(), half_m.end());
  const std::size_t n = half_m.size();
  return half_m[3 * n / 4] - half_m[n / 4] <= 2e-3 * half_m[n / 2];
}

/// A width that somebody has chosen.
bool is_round(double width_m) {
  constexpr double kStep_m = 0.25;
  return std::abs(std::remainder(width_m, kStep_m)) <= 5e-4 * width_m;
}

std::string described(const std::vector<Candidate>& found) {
  std::string text;
  for (const Candidate& road : found)
    text += fmt::format("{}with {} there is {} road of {:.0f} m, {:.1f} m wide",
                        text.empty() ? "" : ", and ", road.flags,
                        road.closed ? "a closed" : "an open", road.length_m, road.width_m);
  return text;
}

CleanOptions anywhere(CleanOptions options) {
  options.near_m.reset();  // a place in metres is wrong in any other unit
  return options;
}

}  // namespace

std::vector<Candidate> candidates_of_unit(const Recipe& recipe, const std::vector<Unit>& could_be) {
  Recipe first = recipe;
  first.read.unit = could_be.front();
  const Mesh mesh = read_mesh(recipe.mesh_path, read_to_clean(first.read, recipe.clean));
  if (mesh.triangles.size() > kMostTriangles) return {};
  std::vector<std::pair<std::string, double>> units;
  for (const NamedUnit& unit : kUnits)
    if (std::find(could_be.begin(), could_be.end(), unit.unit) != could_be.end())
      units.emplace_back(fmt::format("--unit {}", unit.name),
                         unit.metres / metres_per(could_be.front()));
  return roads_in(mesh, units, anywhere(recipe.clean));
}

void refuse_in_this_unit(const std::string& refused, const Mesh& mesh, double metres_per_unit,
                         const CleanOptions& options) {
  if (mesh.triangles.size() > kMostTriangles) return;
  const auto as_it_is = road_in(mesh, 1.0, anywhere(options));
  const double width_m = as_it_is ? typical_width_m(*as_it_is) : 0.0;
  if (width_m >= kLeastWidth_m && width_m <= kTooWide_m) return;
  auto found = other_units(mesh, metres_per_unit, anywhere(options));
  if (!found.empty()) throw Question(refused, std::move(found));
  if (as_it_is)
    throw Error(fmt::format(
        "{}; the road is {:.1f} m wide: if it is not, give the mesh's --unit, or --scale", refused,
        width_m));
}

std::optional<std::string> doubt_about_width(const Centreline& line, const Mesh& mesh,
                                             const MeshReadReport& read,
                                             const CleanOptions& options) {
  const double width_m = typical_width_m(line), feet_m = metres_per(Unit::ft);
  std::string text;
  if (width_m > kWidest_m)
    text = fmt::format("the road is {:.1f} m wide, and hardly any is wider than {:.0f} m", width_m,
                       kWidest_m);
  else if (read.unit_taken && width_m * feet_m >= kLeastWidth_m && is_as_wide_all_along(line) &&
           is_round(width_m * feet_m) && !is_round(width_m))
    text = fmt::format(
        "the file states no unit, and the road is {:.2f} wide all along: in feet that is {:.2f} m, "
        "in metres it is not round",
        width_m, width_m * feet_m);
  else
    return std::nullopt;
  // A guide or a route lies in the unit that the mesh was read in.
  const bool can_try =
      mesh.triangles.size() <= kMostTriangles && !options.guide && options.route_m.empty();
  std::vector<Candidate> found;
  if (can_try)
    found = width_m > kWidest_m ? other_units(mesh, read.metres_per_unit, anywhere(options))
                                : roads_in(mesh, {{"--unit ft", feet_m}}, anywhere(options));
  const std::string others = described(found);
  text += others.empty() ? "; if the mesh has another unit, give it (--unit or --scale)"
                         : "; " + others;
  if (options.guide && !options.guide_width_m)
    text += "; if nothing on the mesh shows the road's width, give it (--guide-width-m W)";
  return text + "; if it is as wide as that, say so with --line-is-right";
}

std::optional<std::string> remark_on_width(const Centreline& line, const MeshReadReport& read) {
  const double width_m = typical_width_m(line);
  if (!read.unit_taken || width_m <= kWide_m) return std::nullopt;
  return fmt::format(
      "the file states no unit: metres were taken, and the road is {:.1f} m wide; if they are feet "
      "it is {:.1f} m: --unit ft",
      width_m, width_m * metres_per(Unit::ft));
}

}  // namespace road
