#include "suggest_unit.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
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
constexpr double kUsualWidth_m = 9.5, kUsualLength_m = 2000.0;
constexpr double kLengthTells = 0.15;  // less than widths do

// Toys and games, whose unit is none of those with a name.
constexpr double kScales[] = {10.0, 100.0};

Mesh enlarged(Mesh mesh, double factor) {
  mesh.origin_m *= factor;
  for (Eigen::Vector3d& v : mesh.vertices_m) v *= factor;
  return mesh;
}

struct FoundRoad {
  Centreline line;
  bool by_shape = false;  ///< alone
  bool is_doubted = false;
};

std::optional<FoundRoad> road_in(const Mesh& mesh, double factor, const CleanOptions& options) {
  CleanReport report;
  auto line =
      try_clean(enlarged(mesh, factor), options, &report).and_then([](const RoadMesh& road) {
        return try_trace_centreline(road);
      });
  if (!line) return std::nullopt;
  return FoundRoad{*std::move(line), !report.by_names && !report.by_colour, !report.doubts.empty()};
}

double typical_width_m(const Centreline& line) { return 2.0 * base::median(line.half_width_m); }

/// Whether a mesh, times a factor, has ground for a road, and is no larger than meshes may be.
bool could_be_road(const Mesh& mesh, double factor) {
  double area = 0.0;  // of all faces: a road has no more
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    area += (mesh.vertex(t, 1) - mesh.vertex(t, 0))
                .cross(mesh.vertex(t, 2) - mesh.vertex(t, 0))
                .norm() /
            2.0;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& v : mesh.vertices_m) box.extend(v);
  return area * factor * factor >= kLeastWidth_m * kShortest_m &&
         box.sizes().head<2>().maxCoeff() * factor <= kLargestExtent_m;
}

bool has_size_of_road(const Candidate& road) {
  return road.width_m >= kLeastWidth_m && road.width_m <= kMostWidth_m &&
         road.length_m >= kShortest_m;
}

using Candidates = std::vector<Candidate>;

/// All of these, those of the likeliest unit first: where the first of them is as wide and long as
/// most roads.
Candidates likeliest_first(std::vector<Candidates> of_units) {
  const auto unusual = [](const Candidates& roads) {
    return std::abs(std::log(roads[0].width_m / kUsualWidth_m)) +
           kLengthTells * std::abs(std::log(roads[0].length_m / kUsualLength_m));
  };
  std::stable_sort(of_units.begin(), of_units.end(), [&](const Candidates& a, const Candidates& b) {
    return unusual(a) < unusual(b);
  });
  Candidates all;
  for (Candidates& roads : of_units)
    all.insert(all.end(), std::move_iterator(roads.begin()), std::move_iterator(roads.end()));
  return all;
}

CleanOptions anywhere(CleanOptions options) {
  options.near_m.reset();  // a place in metres is wrong in any other unit
  return options;
}

/// The road in the unit of each factor in which it is as wide as roads are, the likeliest first;
/// those that something speaks against last.
std::vector<Candidate> roads_in(const Mesh& mesh,
                                const std::vector<std::pair<std::string, double>>& flag_and_factor,
                                const Recipe& recipe) {
  std::vector<Candidates> found, doubted;
  const CleanOptions options = anywhere(recipe.clean);
  for (const auto& [flag, factor] : flag_and_factor) {
    if (!could_be_road(mesh, factor)) continue;
    auto road = road_in(mesh, factor, options);
    if (!road) continue;
    Centreline& line = road->line;
    Candidate candidate{flag, std::move(line.points_m), line.length_m, typical_width_m(line),
                        line.closed};
    if (!has_size_of_road(candidate)) continue;
    Candidates here;
    if (road->is_doubted && road->by_shape) {
      Recipe anew = recipe;
      anew.clean = options;
      here = candidates_of_strips(enlarged(mesh, factor), anew);
      std::erase_if(here, [](const Candidate& strip) { return !has_size_of_road(strip); });
      for (Candidate& strip : here) strip.flags = flag + " " + strip.flags;
    }
    here.push_back(std::move(candidate));
    (road->is_doubted ? doubted : found).push_back(std::move(here));
  }
  Candidates all = likeliest_first(std::move(found)), rest = likeliest_first(std::move(doubted));
  all.insert(all.end(), std::move_iterator(rest.begin()), std::move_iterator(rest.end()));
  return all;
}

/// The road in every other unit in which it is as wide as roads are; else enlarged.
std::vector<Candidate> other_units(const Mesh& mesh, double metres_per_unit, const Recipe& recipe) {
  std::vector<std::pair<std::string, double>> units, scales;
  for (const NamedUnit& unit : kUnits)
    if (std::abs(unit.metres - metres_per_unit) >= 1e-6 * unit.metres)
      units.emplace_back(fmt::format("--unit {}", unit.name), unit.metres / metres_per_unit);
  for (const double scale : kScales)
    scales.emplace_back(fmt::format("--scale {:.0f}", scale), scale);
  std::vector<Candidate> found = roads_in(mesh, units, recipe);
  if (found.empty()) found = roads_in(mesh, scales, recipe);
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

/// In the units of a mesh of which nothing tells which axis points up either.
std::vector<Candidate> in_units_and_ways_up(Recipe recipe, const std::vector<Unit>& could_be,
                                            const std::vector<UpAxis>& ups) {
  std::vector<Candidates> found;
  for (const NamedUnit& unit : kUnits) {
    if (std::find(could_be.begin(), could_be.end(), unit.unit) == could_be.end()) continue;
    recipe.read.unit = unit.unit;
    Candidates here = candidates_of_up(recipe, ups).candidates;
    std::erase_if(here, [](const Candidate& road) { return !has_size_of_road(road); });
    for (Candidate& road : here) road.flags = fmt::format("--unit {} {}", unit.name, road.flags);
    if (!here.empty()) found.push_back(std::move(here));
  }
  return likeliest_first(std::move(found));
}

}  // namespace

std::vector<Candidate> candidates_of_unit(const Recipe& recipe, const std::vector<Unit>& could_be) {
  Recipe first = recipe;
  first.read.unit = could_be.front();
  Mesh mesh;
  try {
    mesh = read_mesh(recipe.mesh_path, read_to_clean(first.read, recipe.clean));
  } catch (const UnknownUp& unknown) {
    return in_units_and_ways_up(recipe, could_be, unknown.could_be());
  }
  if (mesh.triangles.size() > kMostTriangles) return {};
  std::vector<std::pair<std::string, double>> units;
  for (const NamedUnit& unit : kUnits)
    if (std::find(could_be.begin(), could_be.end(), unit.unit) != could_be.end())
      units.emplace_back(fmt::format("--unit {}", unit.name),
                         unit.metres / metres_per(could_be.front()));
  return roads_in(mesh, units, recipe);
}

std::vector<Candidate> likelier_units(const Recipe& recipe, const std::vector<UpAxis>& ups,
                                      std::vector<Candidate> found) {
  if (recipe.read.unit != Unit::automatic || recipe.read.scale != 1.0 ||
      std::any_of(found.begin(), found.end(), has_size_of_road))
    return found;
  Recipe first = recipe;
  first.read.up = ups.front();
  MeshReadReport report;
  const Mesh mesh = read_mesh(recipe.mesh_path, read_to_clean(first.read, recipe.clean), &report);
  if (mesh.triangles.size() > kMostTriangles) return found;
  std::vector<Unit> could_be;
  for (const NamedUnit& unit : kUnits)
    if (const double factor = unit.metres / report.metres_per_unit; could_be_road(mesh, factor))
      could_be.push_back(unit.unit);
  std::vector<Candidate> likely = in_units_and_ways_up(recipe, could_be, ups);
  likely.insert(likely.end(), std::move_iterator(found.begin()), std::move_iterator(found.end()));
  return likely;
}

void refuse_in_this_unit(const std::string& refused, const Mesh& mesh, double metres_per_unit,
                         const Recipe& recipe) {
  if (mesh.triangles.size() > kMostTriangles) return;
  const auto as_it_is = road_in(mesh, 1.0, anywhere(recipe.clean));
  const double width_m = as_it_is ? typical_width_m(as_it_is->line) : 0.0;
  if (width_m >= kLeastWidth_m && width_m <= kTooWide_m) return;
  auto found = other_units(mesh, metres_per_unit, recipe);
  if (!found.empty()) throw Question(refused, std::move(found));
  if (as_it_is)
    throw Error(fmt::format(
        "{}; the road is {:.1f} m wide: if it is not, give the mesh's --unit, or --scale", refused,
        width_m));
}

std::optional<std::string> doubt_about_width(const Centreline& line, const Mesh& mesh,
                                             const MeshReadReport& read, const Recipe& recipe) {
  const CleanOptions& options = recipe.clean;
  const double width_m = typical_width_m(line), feet_m = metres_per(Unit::ft);
  std::string text;
  if (width_m > kWidest_m)
    text = fmt::format("the road is {:.1f} m wide, and hardly any is wider than {:.0f} m", width_m,
                       kWidest_m);
  else if (read.unit_taken && width_m * feet_m >= kLeastWidth_m && is_as_wide_all_along(line) &&
           !is_round(width_m) && (width_m > kWide_m || is_round(width_m * feet_m)))
    text = fmt::format(
        "the file states no unit, and the road is {:.2f} wide all along: in feet that is {:.2f} m, "
        "in metres it is not round{}",
        width_m, width_m * feet_m, width_m > kWide_m ? " and wider than most" : "");
  else
    return std::nullopt;
  // A guide or a route lies in the unit that the mesh was read in.
  const bool can_try =
      mesh.triangles.size() <= kMostTriangles && !options.guide && options.route_m.empty();
  std::vector<Candidate> found;
  if (can_try)
    found = width_m > kWidest_m ? other_units(mesh, read.metres_per_unit, recipe)
                                : roads_in(mesh, {{"--unit ft", feet_m}}, recipe);
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
