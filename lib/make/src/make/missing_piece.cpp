#include "make/missing_piece.h"

#include <fmt/format.h>

#include <cmath>

namespace road {
namespace {

constexpr double kMostShare = 0.1;        // of the length, between the ends of what was a ring
constexpr double kSameDirection = 0.5;    // cosine between the line and the way over the gap
constexpr double kSteepest = 0.15;        // of the way over the gap, m/m
constexpr double kLongestBridge_m = 100;  // that the recipe takes
constexpr double kGapsTried_m[] = {40.0, 27.0, 17.0, 8.0};
constexpr double kGoesOn = 1.03;        // times as long
constexpr double kTrialsMargin = 1.05;  // over the distance of the middles: edges lie farther

/// Direction of the line over a stretch at its end; single stations may be cut askew.
Eigen::Vector2d direction(const Centreline& line, bool at_end) {
  const std::size_t n = line.points_m.size();
  const double over_m = 4.0 * line.half_width_m[at_end ? n - 1 : 0];
  const Eigen::Vector3d& tip = at_end ? line.points_m.back() : line.points_m.front();
  std::size_t k = 1;
  const auto inner = [&] { return line.points_m[at_end ? n - 1 - k : k]; };
  while (k + 1 < n && (inner() - tip).head<2>().norm() < over_m) ++k;
  const Eigen::Vector2d d = (tip - inner()).head<2>();
  return (at_end ? d : Eigen::Vector2d(-d)).normalized();
}

/// The line with gaps bridged up to `gap_m`; empty where none comes out.
std::optional<Centreline> bridged(const Mesh& mesh, CleanOptions options, double gap_m) {
  options.max_gap_m = gap_m;
  auto line = try_clean(mesh, options).and_then([](const RoadMesh& road) {
    return try_trace_centreline(road);
  });
  return line ? std::optional<Centreline>(*std::move(line)) : std::nullopt;
}

}  // namespace

std::optional<MissingPiece> missing_piece(const Centreline& line) {
  if (line.closed || line.points_m.size() < 3) return std::nullopt;
  const Eigen::Vector3d over = line.points_m.front() - line.points_m.back();
  const double gap_m = over.head<2>().norm();
  if (gap_m > kMostShare * line.length_m || gap_m == 0.0) return std::nullopt;
  if (std::abs(over.z()) > line.half_width_m.back() + kSteepest * gap_m) return std::nullopt;
  const Eigen::Vector2d along = over.head<2>() / gap_m;
  if (along.dot(direction(line, true)) < kSameDirection ||
      along.dot(direction(line, false)) < kSameDirection)
    return std::nullopt;
  return MissingPiece{gap_m, 0.5 * (line.points_m.front() + line.points_m.back())};
}

std::optional<LongerRoad> longer_road(const Centreline& line, const Mesh& mesh,
                                      const CleanOptions& options) {
  if (line.closed || options.guide || !options.route_m.empty()) return std::nullopt;
  std::optional<LongerRoad> found;
  if (const auto piece = missing_piece(line)) {
    const double bridge_m = std::ceil(kTrialsMargin * piece->length_m);
    if (bridge_m <= kLongestBridge_m)
      if (const auto closed = bridged(mesh, options, bridge_m); closed && closed->closed)
        found = {bridge_m, closed->length_m, true};
    return found;
  }
  for (const double gap_m : kGapsTried_m) {  // the shortest that helps is told
    if (gap_m <= options.max_gap_m) break;
    const auto longer = bridged(mesh, options, gap_m);
    if (!longer || (!longer->closed && longer->length_m < kGoesOn * line.length_m)) break;
    found = {gap_m, longer->length_m, longer->closed};
  }
  return found;
}

std::optional<std::string> doubt_about_ends(const Centreline& line, const Mesh& mesh,
                                            const CleanOptions& options) {
  if (options.guide || !options.route_m.empty()) return std::nullopt;
  const auto piece = missing_piece(line);
  const auto longer = longer_road(line, mesh, options);
  if (!piece && !longer) return std::nullopt;
  std::string text = fmt::format("the road is open, {:.0f} m long, and ", line.length_m);
  text += piece ? fmt::format(
                      "its ends face each other over {:.1f} m at ({:.1f}, {:.1f}): a piece "
                      "of a closed road seems to be missing; ",
                      piece->length_m, piece->middle_m.x(), piece->middle_m.y())
                : "goes on over a gap: ";
  text += longer ? fmt::format(
                       "with --bridge-gap-m {:.0f} it is {} road of {:.0f} m, drawn on over "
                       "the gap",
                       longer->bridge_m, longer->closed ? "a closed" : "an open", longer->length_m)
                 : "put it into the mesh";
  return text + (piece ? "; if it is open all the same, say so with --line-is-right"
                       : "; if it ends there, say so with --line-is-right");
}

}  // namespace road
