#include "suggest_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/statistics.h"
#include "mesh/read_mesh.h"
#include "road/centreline.h"

namespace road {
namespace {

constexpr std::size_t kMostTriangles = 100'000;  // about 3 s for each unit
// In its right unit a road is as wide as roads are, not only as wide as the tool can trace: from
// one lane on.
constexpr double kLeastWidth_m = 3.0, kMostWidth_m = 25.0, kShortest_m = 100.0;
constexpr double kTooWide_m = 60.0;
// The ovals of TORCS are 30 m wide; the next that was met, 33 m, was a road in feet.
constexpr double kWidest_m = 31.0;

struct Trial {
  const char* unit;
  bool closed;
  double length_m, width_m;
};

std::optional<Centreline> road_in(Mesh mesh, double factor, const CleanOptions& options) {
  mesh.origin_m *= factor;
  for (Eigen::Vector3d& v : mesh.vertices_m) v *= factor;
  auto line = try_clean(mesh, options).and_then([](const RoadMesh& road) {
    return try_trace_centreline(road);
  });
  return line ? std::optional<Centreline>(*std::move(line)) : std::nullopt;
}

double typical_width_m(const Centreline& line) { return 2.0 * base::median(line.half_width_m); }

/// The road in every other unit in which it is as wide as roads are.
std::vector<Trial> other_units(const Mesh& mesh, double metres_per_unit,
                               const CleanOptions& options) {
  std::vector<Trial> trials;
  for (const NamedUnit& unit : kUnits) {
    if (std::abs(unit.metres - metres_per_unit) < 1e-6 * unit.metres) continue;
    const auto line = road_in(mesh, unit.metres / metres_per_unit, options);
    if (!line) continue;
    const double width_m = typical_width_m(*line);
    if (width_m >= kLeastWidth_m && width_m <= kMostWidth_m && line->length_m >= kShortest_m)
      trials.push_back({unit.name, line->closed, line->length_m, width_m});
  }
  return trials;
}

std::string described(const std::vector<Trial>& trials) {
  std::string text;
  for (const Trial& trial : trials)
    text += fmt::format("{}with --unit {} there is {} road of {:.0f} m, {:.1f} m wide",
                        text.empty() ? "" : ", and ", trial.unit,
                        trial.closed ? "a closed" : "an open", trial.length_m, trial.width_m);
  return text;
}

CleanOptions anywhere(CleanOptions options) {
  options.near_m.reset();  // a place in metres is wrong in any other unit
  return options;
}

}  // namespace

std::string unit_with_a_road(const Mesh& mesh, double metres_per_unit,
                             const CleanOptions& options) {
  if (mesh.triangles.size() > kMostTriangles) return {};
  const auto as_it_is = road_in(mesh, 1.0, anywhere(options));
  if (as_it_is && typical_width_m(*as_it_is) <= kTooWide_m) return {};
  const std::string text = described(other_units(mesh, metres_per_unit, anywhere(options)));
  if (!text.empty()) return "; " + text;
  if (!as_it_is) return {};
  return fmt::format(
      "; the road is {:.1f} m wide: if it is not, give the mesh's --unit, or --scale",
      typical_width_m(*as_it_is));
}

std::optional<std::string> doubt_about_width(const Centreline& line, const Mesh& mesh,
                                             double metres_per_unit, const CleanOptions& options) {
  const double width_m = typical_width_m(line);
  if (width_m <= kWidest_m) return std::nullopt;
  std::string text = fmt::format("the road is {:.1f} m wide, and hardly any is wider than {:.0f} m",
                                 width_m, kWidest_m);
  // A guide or a route lies in the unit that the mesh was read in.
  const bool can_try =
      mesh.triangles.size() <= kMostTriangles && !options.guide && options.route_m.empty();
  const std::string others =
      can_try ? described(other_units(mesh, metres_per_unit, anywhere(options))) : "";
  text += others.empty() ? "; if the mesh has another unit, give it (--unit or --scale)"
                         : "; " + others;
  if (options.guide && !options.guide_width_m)
    text += "; if nothing on the mesh shows the road's width, give it (--guide-width-m W)";
  return text + "; if it is as wide as that, say so with --line-is-right";
}

}  // namespace road
