#include "make/question.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/statistics.h"
#include "make/plausible.h"
#include "mesh/ray_surface.h"
#include "report/question_map.h"
#include "road/clean.h"
#include "road/roads_of.h"
#include "road/route.h"

namespace road {
namespace {

using Eigen::Vector2d;

constexpr double kShortestShare =
    0.1;  // of the longest way: shorter ones are no roads to ask about
constexpr std::size_t kMostTrianglesToTry = 1'000'000;  // some 30 s for each axis
constexpr double kSameShare = 0.97;  // of a way's branches shared with another: no other way

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
};

/// The road that a recipe leads to; nothing where it refuses, or something speaks against it.
std::optional<Found> road_with(const Mesh& mesh, const Recipe& recipe) {
  Found found;
  const auto road = try_clean(mesh, recipe.clean, &found.report);
  if (!road) return std::nullopt;
  auto line = try_trace_centreline(*road, recipe.centreline);
  if (!line || !try_fit_reference_line(*line, recipe.reference_line)) return std::nullopt;
  if (!doubts_about(*line, RaySurface(road->mesh), road->mesh, mesh, found.report).empty())
    return std::nullopt;
  found.line = *std::move(line);
  return found;
}

Candidate candidate_of(const std::string& flags, const Centreline& line) {
  return {flags, line.points_m, line.length_m, 2.0 * base::median(line.half_width_m), line.closed};
}

}  // namespace

std::vector<Candidate> candidates_of_up(const Recipe& recipe, const std::vector<UpAxis>& could_be) {
  std::vector<Candidate> found;
  Recipe tried = recipe;
  for (const UpAxis up : could_be) {
    tried.read.up = up;
    const Mesh mesh = read_mesh(tried.mesh_path, read_to_clean(tried.read, tried.clean));
    if (mesh.triangles.size() > kMostTrianglesToTry) return {};
    if (const auto road = road_with(mesh, tried))
      found.push_back(candidate_of(fmt::format("--up {}", name_of(up)), road->line));
  }
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
      found.push_back(
          candidate_of(flags_of(points, g > 0 && recipe.clean.use_names != UseNames::no), line));
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
