#include "suggest_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/statistics.h"
#include "road/centreline.h"
#include "road/error.h"
#include "road/read_mesh.h"

namespace road {
namespace {

constexpr std::size_t kMostTriangles = 100'000;  // about 3 s for each unit
// In its right unit a road is as wide as roads are, not only as wide as the tool can trace: from
// one lane on.
constexpr double kLeastWidth_m = 3.0, kMostWidth_m = 25.0, kShortest_m = 100.0;
constexpr double kTooWide_m = 60.0;

struct Trial {
  const char* unit;
  bool closed;
  double length_m, width_m;
};

std::optional<Centreline> road_in(Mesh mesh, double factor, const CleanOptions& options) {
  mesh.origin_m *= factor;
  for (Eigen::Vector3d& v : mesh.vertices_m) v *= factor;
  try {
    return trace_centreline(clean(mesh, options));
  } catch (const Error&) {
    return std::nullopt;
  }
}

double typical_width_m(const Centreline& line) { return 2.0 * base::median(line.half_width_m); }

}  // namespace

std::string unit_with_a_road(const Mesh& mesh, double metres_per_unit,
                             const CleanOptions& options) {
  CleanOptions anywhere = options;  // a place in metres is wrong in any other unit
  anywhere.near_m.reset();
  if (mesh.triangles.size() > kMostTriangles) return {};
  const auto as_it_is = road_in(mesh, 1.0, anywhere);
  if (as_it_is && typical_width_m(*as_it_is) <= kTooWide_m) return {};
  std::vector<Trial> trials;
  for (const NamedUnit& unit : kUnits) {
    if (std::abs(unit.metres - metres_per_unit) < 1e-6 * unit.metres) continue;
    const auto line = road_in(mesh, unit.metres / metres_per_unit, anywhere);
    if (!line) continue;
    const double width_m = typical_width_m(*line);
    if (width_m >= kLeastWidth_m && width_m <= kMostWidth_m && line->length_m >= kShortest_m)
      trials.push_back({unit.name, line->closed, line->length_m, width_m});
  }
  std::string text;
  for (const Trial& trial : trials) {
    text += fmt::format("{} with --unit {} there is {} road of {:.0f} m, {:.1f} m wide",
                        text.empty() ? ";" : ", and", trial.unit,
                        trial.closed ? "a closed" : "an open", trial.length_m, trial.width_m);
  }
  if (text.empty() && as_it_is) {
    return fmt::format(
        "; the road is {:.1f} m wide: if it is not, give the mesh's --unit, or --scale",
        typical_width_m(*as_it_is));
  }
  return text;
}

}  // namespace road
