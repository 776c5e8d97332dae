#include "make/question.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/statistics.h"
#include "make/missing_piece.h"
#include "make/plausible.h"
#include "mesh/ray_surface.h"
#include "report/question_map.h"
#include "right_way_up.h"
#include "road/clean.h"
#include "road/roads_of.h"
#include "road/route.h"

namespace road {
namespace {

using Eigen::Vector2d;

constexpr double kShortestShare =
    0.1;  // of the longest way: shorter ones are no roads to ask about
constexpr std::size_t kMostTrianglesToTry = 1'000'000;  // some 30 s for each axis
constexpr std::size_t kMostStrips = 5;
constexpr double kShortestOpen_m = 30.0;  // an arena has shorter strips
constexpr double kSameHalf = 0.06, kSameLane = 0.005;
constexpr double kGapStep_m = 0.25, kLongestBridged_m = 15.0;
constexpr double kWholeWidth_m = 99.0;  // wider than any strip: all of the ground
constexpr double kSameShare = 0.97;     // of a way's branches shared with another: no other way

double shared(const RoadWay& a, const RoadWay& b, const RoadGraph& graph) {
  double shared_m = 0.0;
  for (const std::uint32_t branch : a.branches)
    if (std::find(b.branches.begin(), b.branches.end(), branch) != b.branches.end())
      shared_m += graph.branches[branch].length_m;
  return shared_m / std::max(a.length_m, 1e-9);
}

std::string flags_of(const std::vector<Vector2d>& points, bool by_shape) {
  std::string flags = "--route";
  for (const Vector2d& p : points) flags += fmt::format(" {:.1f},{:.1f}", p.x(), p.y());
  return flags + (by_shape ? " --use-names false" : "");
}

struct Found {
  CleanReport report;
  Centreline line;
  std::vector<std::string> doubts;
  WayUp way_up;       ///< where it was asked
  std::string flags;  ///< that it takes beside those of the recipe, with a space before them
};

/// The longest stretch of a line without surface.
double longest_gap_m(const Centreline& line, const RaySurface& surface) {
  double longest_m = 0.0, gap_m = 0.0;
  for (std::size_t i = 0; i + 1 < line.points_m.size(); ++i) {
    const Eigen::Vector3d &p = line.points_m[i], d = line.points_m[i + 1] - p;
    const int pieces = 1 + static_cast<int>(d.head<2>().norm() / kGapStep_m);
    for (int k = 0; k < pieces; ++k) {
      const Eigen::Vector3d at = p + (k + 0.5) / pieces * d;
      const bool is_there =
          surface.nearest_hit(at.x(), at.y(), at.z(), 1.0 + 0.5 * line.half_width_m[i]).has_value();
      gap_m = is_there ? 0.0 : gap_m + d.head<2>().norm() / pieces;
      longest_m = std::max(longest_m, gap_m);
    }
  }
  return longest_m;
}

/// The road that a recipe leads to, with what speaks against it; nothing where it refuses. Its gaps
/// are bridged where that leads to it, too.
std::optional<Found> doubted_road_with(const Mesh& mesh, const Recipe& recipe, bool ask_for_up) {
  Found found;
  const auto road = try_clean(mesh, recipe.clean, &found.report);
  if (!road) return std::nullopt;
  auto line = try_trace_centreline(*road, recipe.centreline);
  if (!line || !try_fit_reference_line(*line, recipe.reference_line)) return std::nullopt;
  const RaySurface surface(road->mesh);
  const double gap_m = longest_gap_m(*line, surface);
  Recipe bridging = recipe;
  if (gap_m > recipe.clean.max_gap_m && gap_m <= kLongestBridged_m)
    bridging.clean.max_gap_m = std::ceil(gap_m) + 1.0;
  else if (const auto longer = longer_road(*line, mesh, recipe.clean))
    bridging.clean.max_gap_m = longer->bridge_m;
  if (bridging.clean.max_gap_m > recipe.clean.max_gap_m) {
    auto bridged = doubted_road_with(mesh, bridging, ask_for_up);
    if (bridged) {
      bridged->flags += fmt::format(" --bridge-gap-m {:.0f}", bridging.clean.max_gap_m);
      return bridged;
    }
  }
  found.doubts = doubts_about(*line, surface, road->mesh, mesh, found.report);
  if (ask_for_up) {
    const RaySurface everything(mesh);
    found.way_up = right_way_up(*line, surface, &everything);
  }
  found.line = *std::move(line);
  return found;
}

/// The same; nothing where something speaks against it, too.
std::optional<Found> road_with(const Mesh& mesh, const Recipe& recipe) {
  auto found = doubted_road_with(mesh, recipe, false);
  if (found && !found->doubts.empty()) return std::nullopt;
  return found;
}

/// As `mirror` of MeshReadOptions makes it.
Centreline mirrored(Centreline line) {
  for (Eigen::Vector3d& p : line.points_m) p.y() = -p.y();
  return line;
}

Candidate candidate_of(const std::string& flags, const Centreline& line) {
  return {flags, line.points_m, line.length_m, 2.0 * base::median(line.half_width_m), line.closed};
}

struct Tried {
  UpAxis up;
  Found found;
};

UpAxis back_of(UpAxis up) { return up_along(line_of(up), !is_minus(up)); }

bool has(const std::vector<UpAxis>& ups, UpAxis up) {
  return std::find(ups.begin(), ups.end(), up) != ups.end();
}

/// The one way up that a road tells: by being right so, or wrong the other way.
std::optional<UpAxis> told_up(const std::vector<Tried>& tried,
                              const std::vector<UpAxis>& could_be) {
  std::vector<UpAxis> told;
  for (const auto& [up, found] : tried) {
    if (found.way_up.told == 0) continue;
    const UpAxis right = found.way_up.told > 0 ? up : back_of(up);
    if (has(could_be, right) && !has(told, right)) told.push_back(right);
  }
  return told.size() == 1 ? std::optional(told.front()) : std::nullopt;
}

/// The roads that a build with these flags leads to, without another question: where shape alone
/// told it and something speaks against it, its strips.
std::vector<Candidate> without_doubt(const std::string& flags, const Mesh& mesh,
                                     const Recipe& recipe, const Found& found) {
  if (found.doubts.empty()) return {candidate_of(flags + found.flags, found.line)};
  if (found.report.by_names || found.report.by_colour || recipe.clean.near_m) return {};
  std::vector<Candidate> strips = candidates_of_strips(mesh, recipe);
  for (Candidate& strip : strips) strip.flags = flags + " " + strip.flags;
  return strips;
}

/// Whether another of the roads is as wide, and none is what both are together.
bool has_twin(const Candidate& road, const std::vector<Candidate>& roads) {
  const auto wide_as = [&](double width_m, double share) {
    return std::count_if(roads.begin(), roads.end(), [&](const Candidate& other) {
      return std::abs(other.width_m - width_m) < share * width_m;
    });
  };
  return wide_as(road.width_m, kSameLane) > 1 && wide_as(2.0 * road.width_m, kSameHalf) == 0;
}

}  // namespace

UpAnswers candidates_of_up(const Recipe& recipe, const std::vector<UpAxis>& could_be) {
  UpAnswers answers;
  std::vector<Tried> tried;
  for (const UpAxis up : could_be) {
    Recipe with_up = recipe;
    with_up.read.up = up;
    const Mesh mesh = read_mesh(recipe.mesh_path, read_to_clean(with_up.read, recipe.clean));
    if (mesh.triangles.size() > kMostTrianglesToTry) return {};
    if (auto found = doubted_road_with(mesh, with_up, true))
      tried.push_back({up, *std::move(found)});
  }
  answers.told = told_up(tried, could_be);
  std::stable_partition(tried.begin(), tried.end(), [&](const Tried& one) {
    return answers.told ? one.up == answers.told : one.found.way_up.likely > 0;
  });
  const auto add = [&](const std::string& flags, UpAxis up, bool mirror, Found found) {
    Recipe with = recipe;
    with.read.up = up;
    with.read.mirror = mirror;
    if (mirror != recipe.read.mirror) found.line = mirrored(std::move(found.line));
    const Mesh mesh = found.doubts.empty()
                          ? Mesh{}
                          : read_mesh(recipe.mesh_path, read_to_clean(with.read, recipe.clean));
    for (Candidate& road : without_doubt(flags, mesh, with, found))
      answers.candidates.push_back(std::move(road));
  };
  for (const auto& [up, found] : tried) {
    const std::string flag = fmt::format("--up {}", name_of(up));
    // Faces that look down are those of a mirrored plan, or were wound the other way round.
    if (!is_minus(up) && !recipe.read.mirror && has(could_be, back_of(up)))
      add(flag + " --mirror", up, true, found);
    add(flag, up, recipe.read.mirror, found);
  }
  return answers;
}

std::vector<Candidate> candidates_of_strips(const Mesh& mesh, const Recipe& recipe) {
  std::vector<Candidate> found;
  if (mesh.triangles.size() > kMostTrianglesToTry) return found;
  const auto try_at = [&](const Eigen::Vector2d& place_m, std::optional<double> width_m) {
    // As they are printed.
    const auto rounded = [](double value) { return std::round(10.0 * value) / 10.0; };
    Recipe tried = recipe;
    tried.clean.near_m = {rounded(place_m.x()), rounded(place_m.y())};
    const std::string flags =
        fmt::format("--near-m {:.1f},{:.1f}", tried.clean.near_m->x(), tried.clean.near_m->y());
    tried.clean.guide_width_m = width_m;
    const auto road = road_with(mesh, tried);
    if (!road || !road->report.by_place) return;
    if (!road->line.closed && road->line.length_m < kShortestOpen_m) return;
    Candidate candidate = candidate_of(flags, road->line);
    if (width_m) candidate.flags += fmt::format(" --guide-width-m {:.1f}", candidate.width_m);
    candidate.flags += road->flags;
    if (std::any_of(found.begin(), found.end(), [&](const Candidate& other) {
          return std::abs(other.length_m - candidate.length_m) < 0.5 &&
                 std::abs(other.width_m - candidate.width_m) < 0.5;
        }))
      return;  // the same road
    found.push_back(std::move(candidate));
  };
  const std::vector<PlaceOfRoad> places = places_that_may_be_road(mesh, recipe.clean);
  for (const PlaceOfRoad& place : places)
    if (found.size() < kMostStrips) try_at(place.near_m, place.width_m);
  const std::size_t count = found.size();
  if (!places.empty()) try_at(places.front().near_m, kWholeWidth_m);
  // Two that are alike, rather than what lies between them with one of them.
  if (found.size() > 2 && found[0].flags.find("--guide-width-m") != std::string::npos &&
      has_twin(found[1], found))
    std::rotate(found.begin(), found.begin() + 1, found.end());
  // Two halves of a road, rather than a road and a verge.
  if (count == 2 && found.size() == 3 &&
      std::abs(found[0].width_m - found[1].width_m) < kSameHalf * found[0].width_m &&
      std::abs(found[0].width_m + found[1].width_m - found[2].width_m) <
          kSameHalf * found[2].width_m)
    std::rotate(found.begin(), found.end() - 1, found.end());
  // Pieces of a road that goes round come after it.
  std::stable_partition(found.begin(), found.end(),
                        [](const Candidate& road) { return road.closed; });
  return found;
}

std::vector<Candidate> candidates(const Mesh& mesh, const Recipe& recipe, std::size_t most) {
  std::vector<Candidate> found;
  std::vector<Centreline> lines;
  const std::vector<Roads> roads = roads_of(mesh, recipe.clean);
  for (std::size_t g = 0; g < roads.size(); ++g) {
    const RoadGraph& graph = roads[g].graph;
    std::vector<RoadWay> taken;
    for (const RoadWay& way : road_ways(graph, 0.0, 4 * most)) {
      const bool known = std::any_of(taken.begin(), taken.end(), [&](const RoadWay& other) {
        return shared(way, other, graph) > kSameShare;
      });
      if (known || taken.size() == most ||
          (!taken.empty() && way.length_m < kShortestShare * taken.front().length_m))
        continue;
      taken.push_back(way);
      const std::vector<Vector2d> points = points_that_tell(graph, way);
      if (points.empty()) continue;
      Recipe tried = recipe;
      tried.clean.route_m = points;
      if (g > 0) tried.clean.use_names = UseNames::no;
      const auto road = road_with(mesh, tried);
      if (!road) continue;
      const Centreline& line = road->line;
      if (!line.closed && same_material_elsewhere(line, mesh, road->report)) continue;
      const auto is_this = [&](const Centreline& other) {
        return other.closed == line.closed && goes_along(line, other) && goes_along(other, line);
      };
      if (std::any_of(lines.begin(), lines.end(), is_this))
        continue;  // names and shape may find one road
      lines.push_back(line);
      found.push_back(candidate_of(
          flags_of(points, g > 0 && recipe.clean.use_names != UseNames::no) + road->flags, line));
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
    return a.closed != b.closed ? a.closed : a.length_m > b.length_m;
  });
  if (found.size() > most) found.resize(most);
  return found;
}

std::string question_picture(const std::string& title, const Mesh& mesh,
                             const std::vector<Candidate>& candidates) {
  std::vector<std::array<std::array<double, 2>, 3>> ground;
  ground.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<std::array<double, 2>, 3> corners{};
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d p = mesh.origin_m + mesh.vertex(t, k);
      corners[static_cast<std::size_t>(k)] = {p.x(), p.y()};
    }
    ground.push_back(corners);
  }
  std::vector<report::QuestionLine> lines;
  for (const Candidate& candidate : candidates) {
    report::QuestionLine line;
    line.text =
        fmt::format("{} road, {:.0f} m long, {:.1f} m wide", candidate.closed ? "closed" : "open",
                    candidate.length_m, candidate.width_m);
    line.closed = candidate.closed;
    for (const Eigen::Vector3d& p : candidate.points_m) line.points_m.push_back({p.x(), p.y()});
    lines.push_back(std::move(line));
  }
  return report::question_map(title, ground, lines);
}

}  // namespace road
