#include "classify_by_guide.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <unordered_map>

#include "guide_rows.h"
#include "road/error.h"
#include "road/ray_surface.h"
#include "stations.h"
#include "wide_places.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRoadInside = 0.02;  // a look that is rarer under the guide is paint or a mistake
constexpr double kRoadOutside = 2.0;  // the road's look is so many times rarer beside it
constexpr double kBesideMain = 0.1;   // more of the places beside than the road's main look has
constexpr double kNotPaint_m = 0.3;   // below the main look
constexpr double kLayerShare =
    0.05;  // of the reach: the surface beside the road may lie so much higher or lower,
constexpr double kSlope = 0.5;       // and this much more per metre beyond its border
constexpr double kFartherOn = 0.25;  // of the reach: a row may lie so much farther than the nearest
constexpr double kPaintShare = 0.001;  // of the reach, above the road: 30 mm
constexpr double kNearBorder = 2.0;    // rays
constexpr double kMostMissing = 0.3;   // of the rows may be without surface
constexpr double kNamesKnow = 0.95;    // of the places under the guide are called road
constexpr double kMissingIsDoubted = 0.05;
constexpr double kUntoldIsDoubted = 0.3,
                 kUntoldIsSaid = 0.05;  // of the rows do not tell where the road ends
constexpr double kEndsShare = 0.5;      // of the rows have to know where the road ends

/// Look of every triangle, and the names of the looks.
struct Looks {
  std::vector<std::uint32_t> of_object;
  std::vector<std::string> names;
};

Looks looks_of(const Mesh& mesh) {
  const bool has_looks =
      std::any_of(mesh.objects.begin(), mesh.objects.end(),
                  [](const MeshObject& o) { return !o.material.empty() || !o.texture.empty(); });
  Looks looks;
  std::map<std::string, std::uint32_t> known;
  for (const MeshObject& object : mesh.objects) {
    const std::string name = !has_looks               ? object.name
                             : object.texture.empty() ? object.material
                             : object.material.empty()
                                 ? object.texture
                                 : object.material + " with " + object.texture;
    const auto [at, added] =
        known.try_emplace(name, static_cast<std::uint32_t>(looks.names.size()));
    if (added) looks.names.push_back(name);
    looks.of_object.push_back(at->second);
  }
  return looks;
}

/// Where names call nearly everything under the guide road, what they call otherwise is another
/// look: pit lanes and aprons have the asphalt of the road. Whether they do.
bool part_by_names(const Guide& guide, const RaySurface& surface, const Mesh& mesh,
                   const std::vector<std::uint32_t>& source,
                   const std::vector<SurfaceClass>& by_names, Looks& looks,
                   std::vector<std::uint32_t>& look_of_triangle) {
  std::vector<std::uint32_t> is_named(source.size());
  for (std::size_t k = 0; k < source.size(); ++k)
    is_named[k] = by_names[source[k]] == SurfaceClass::road ? 1 : 0;
  if (look_shares(guide, surface, is_named, 2).inside[1] < kNamesKnow) return false;
  const auto count = static_cast<std::uint32_t>(looks.names.size());
  for (std::uint32_t k = 0; k < count; ++k)
    looks.names.push_back(looks.names[k] + " not called road");
  for (std::size_t k = 0; k < source.size(); ++k)
    if (is_named[k] == 0) {
      look_of_triangle[k] += count;
      looks.of_object[mesh.object_of_triangle[source[k]]] = look_of_triangle[k];
    }
  return true;
}

/// The looks that lie under the guide rather than beside it, along the whole of it and where they
/// lie: sand that the road leads through for a while does not lie beside the rest of it.
std::vector<bool> road_looks(const LookShares& shares) {
  std::vector<bool> is_road(shares.inside.size(), false);
  std::size_t main = 0;
  const auto worth = [&](std::size_t k) {
    return shares.inside[k] * shares.inside[k] / (shares.outside[k] + 0.05);
  };
  for (std::size_t k = 0; k < is_road.size(); ++k) {
    if (worth(k) > worth(main)) main = k;
    is_road[k] = shares.inside[k] >= kRoadInside &&
                 shares.inside[k] > kRoadOutside * shares.outside[k] &&
                 shares.inside_there[k] > kRoadOutside * shares.outside_there[k];
  }
  // What lies only where the road's main look lies too is paint on it, ground that goes on beneath
  // it, or what carries it. Paint lies close to it, and not beside the road.
  std::vector<double> alone(is_road.size(), 0.0), beneath(is_road.size(), 0.0);
  const double each = 1.0 / static_cast<double>(std::max<std::size_t>(shares.places.size(), 1));
  for (const auto& seen : shares.places)
    for (const LookShares::Seen& one : seen) {
      double above_m = std::numeric_limits<double>::quiet_NaN();  // the nearest main look
      for (const LookShares::Seen& other : seen)
        if (other.look == main && !(std::abs(other.z_m - one.z_m) >= std::abs(above_m)))
          above_m = other.z_m - one.z_m;
      if (std::isnan(above_m))
        alone[one.look] += each;
      else if (above_m > kNotPaint_m)
        beneath[one.look] += each;
    }
  for (std::size_t k = 0; k < is_road.size(); ++k)
    if (alone[k] < kRoadInside &&
        (shares.outside_there[k] > shares.outside_there[main] + kBesideMain ||
         beneath[k] > 0.5 * shares.inside[k]))
      is_road[k] = false;
  is_road[main] = true;
  return is_road;
}

/// The rows near a place in plan.
class RowsNear {
 public:
  explicit RowsNear(const GuideRows& all) : all_(all) {
    for (std::uint32_t i = 0; i < all.rows.size(); ++i)
      cells_[key(all.rows[i].at_m, 0, 0)].push_back(i);
  }

  struct Nearest {
    std::size_t row;  ///< of the layer in which the point lies; none within reach: their number
    bool is_beside;   ///< the point lies beside it: no row of another layer is much nearer
  };
  Nearest nearest(const Vector3d& p_m) const {
    std::size_t best = all_.rows.size();
    double best_m = all_.reach_m, nearest_m = all_.reach_m;
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto cell = cells_.find(key(p_m.head<2>(), dx, dy));
        if (cell == cells_.end()) continue;
        for (const std::uint32_t i : cell->second) {
          const GuideRow& row = all_.rows[i];
          const double d = (p_m.head<2>() - row.at_m).norm();
          const double beside_m = std::max(0.0, d - row.half_width_m);
          nearest_m = std::min(nearest_m, d);
          if (d < best_m &&
              std::abs(p_m.z() - row.z_m) <= kLayerShare * all_.reach_m + kSlope * beside_m)
            best = i, best_m = d;
        }
      }
    }
    return {best, best_m <= nearest_m + kFartherOn * all_.reach_m};
  }

 private:
  std::int64_t key(const Vector2d& p_m, int dx, int dy) const {
    const auto index = [&](double x) {
      return static_cast<std::int64_t>(std::floor(x / all_.reach_m));
    };
    return (index(p_m.x()) + dx) << 32 ^ ((index(p_m.y()) + dy) & 0xffffffff);
  }
  const GuideRows& all_;
  std::unordered_map<std::int64_t, std::vector<std::uint32_t>> cells_;
};

/// How much of the guide has no road under it, with the place of the longest piece.
struct Missing {
  double share = 0.0;
  std::string text;
};

Missing missing_under(const GuideRows& all) {
  const std::size_t n = all.rows.size();
  if (n == 0) return {};
  std::size_t missing = 0, run = 0, longest = 0, at = 0;
  for (std::size_t i = 0; i < (all.closed ? 2 * n : n);
       ++i) {  // a gap may lie across the beginning
    run = all.rows[i % n].has_surface ? 0 : std::min(run + 1, n);
    if (i < n && run > 0) ++missing;
    if (run > longest) longest = run, at = (i + 1 - run) % n;
  }
  const auto metres = [&](std::size_t rows) { return static_cast<double>(rows) * all.step_m; };
  const double share = static_cast<double>(missing) / static_cast<double>(n);
  const Vector2d& place = all.rows[at].at_m;
  return {share, fmt::format("the surface is missing along {:.0f} % of the guide ({:.0f} of {:.0f} "
                             "m), the longest piece "
                             "of {:.0f} m begins at ({:.1f}, {:.1f})",
                             100.0 * share, metres(missing), metres(n), metres(longest), place.x(),
                             place.y())};
}

}  // namespace

bool has_several_looks(const Mesh& mesh) {
  return std::any_of(mesh.objects.begin(), mesh.objects.end(), [&](const MeshObject& object) {
    return object.material != mesh.objects.front().material ||
           object.texture != mesh.objects.front().texture;
  });
}

GuidedClasses classes_along(const Mesh& mesh, const Guide& guide, std::optional<double> width_m,
                            const std::vector<bool>& flat,
                            const std::vector<SurfaceClass>& by_names) {
  Mesh ground;
  ground.origin_m = mesh.origin_m;
  ground.vertices_m = mesh.vertices_m;
  std::vector<std::uint32_t> source, look_of_triangle;
  Looks looks = looks_of(mesh);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!flat[t]) continue;
    ground.triangles.push_back(mesh.triangles[t]);
    source.push_back(t);
    look_of_triangle.push_back(looks.of_object[mesh.object_of_triangle[t]]);
  }
  if (source.empty())
    throw Error(fmt::format(
        "nothing to drive on: none of {} triangles is flat; check the axis that points up (--up)",
        mesh.triangles.size()));
  ground.object_of_triangle.assign(source.size(), 0);
  ground.objects.resize(1);
  const RaySurface surface(ground);

  const bool names_know =
      part_by_names(guide, surface, mesh, source, by_names, looks, look_of_triangle);
  const LookShares shares = look_shares(guide, surface, look_of_triangle, looks.names.size());
  if (std::all_of(shares.inside.begin(), shares.inside.end(),
                  [](double share) { return share == 0.0; }))
    throw Error(
        "no surface lies under the guide; check that both are in the same frame and that its "
        "columns are x and y of the mesh "
        "(--up and --unit say how the mesh is read)");
  const std::vector<bool> is_road = road_looks(shares);
  const auto looks_like_road = [&](std::uint32_t t) {
    return static_cast<bool>(is_road[look_of_triangle[t]]);
  };
  GuideRows all = rows_along(guide, surface, looks_like_road);
  const Missing missing = missing_under(all);
  if (missing.share > kMostMissing)
    throw NotUsable(missing.text +
                    "; give a mesh that has it, or a guide that lies on what there is");
  const auto ends = std::count_if(all.rows.begin(), all.rows.end(),
                                  [](const GuideRow& row) { return row.is_usual; });
  const auto with_surface = std::count_if(all.rows.begin(), all.rows.end(),
                                          [](const GuideRow& row) { return row.has_surface; });
  const double told =
      static_cast<double>(ends) / static_cast<double>(std::max<std::ptrdiff_t>(with_surface, 1));
  if (told < kEndsShare && !width_m)
    throw Error(
        fmt::format("under the guide the surface tells along {:.0f} % of it only, by its look, "
                    "slope or border, where the "
                    "road ends. If the guide lies beside the road, check its frame and the order "
                    "of its columns; if the "
                    "road is not to be seen on the mesh, say how wide it is (--guide-width-m W, "
                    "guide_width_m in a recipe)",
                    100.0 * told));
  if (width_m) set_width(all, *width_m);

  GuidedClasses result;
  std::string names;
  for (std::size_t k = 0; k < is_road.size(); ++k)
    if (is_road[k]) names += fmt::format("{}'{}'", names.empty() ? "" : ", ", looks.names[k]);
  result.remarks.push_back(fmt::format("by the guide ({}, {} rows), the road looks like {}",
                                       guide.closed ? "closed" : "open", all.rows.size(), names));
  const auto narrowed = std::count_if(all.rows.begin(), all.rows.end(),
                                      [](const GuideRow& row) { return row.is_narrowed; });
  if (narrowed > 0)
    result.remarks.push_back(
        fmt::format("along {:.0f} m of the guide what looks like road is wider on one side than "
                    "before and after: there the other side tells where the road lies",
                    static_cast<double>(narrowed) * all.step_m));
  if (missing.share > kMissingIsDoubted) result.doubts.push_back(missing.text);
  if (const auto wide = much_wider(all)) result.doubts.push_back(*wide);
  if (told < 1.0 - kUntoldIsDoubted)
    result.doubts.push_back(
        fmt::format("along {:.0f} % of the guide nothing but the guide tells where the road lies; "
                    "look at the picture, "
                    "and say with --line-is-right that it is right",
                    100.0 * (1.0 - told)));
  else if (told < 1.0 - kUntoldIsSaid)
    result.remarks.push_back(
        fmt::format("along {:.0f} % of the guide the sides of the road are unlike those of its "
                    "neighbours (forks, "
                    "wide places): there its middle is taken from them",
                    100.0 * (1.0 - told)));

  result.class_of_triangle.assign(mesh.triangles.size(), SurfaceClass::scenery);
  const RowsNear near(all);
  const auto inside = [&](const GuideRow& row, double offset_m, double more_m) {
    const double low_m = row.is_usual ? row.right_m : row.middle_m - row.half_width_m;
    const double high_m = row.is_usual ? row.left_m : row.middle_m + row.half_width_m;
    return offset_m >= low_m - more_m && offset_m <= high_m + more_m;
  };
  const auto lies_on_road = [&](std::uint32_t t) {
    for (int corner = 0; corner < 3; ++corner) {
      const Vector3d p = mesh.origin_m + mesh.vertex(t, corner);
      const std::size_t i = near.nearest(p).row;
      if (i == all.rows.size()) return false;
      const GuideRow& row = all.rows[i];
      if (!inside(row, (p.head<2>() - row.at_m).dot(left_of(row.heading)),
                  kNearBorder * all.across_m))
        return false;
    }
    return true;
  };
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const bool is_kerb = by_names[t] == SurfaceClass::kerb;
    if (!flat[t] && !is_kerb) continue;
    const Vector3d middle =
        mesh.origin_m + (mesh.vertex(t, 0) + mesh.vertex(t, 1) + mesh.vertex(t, 2)) / 3.0;
    const auto [i, is_beside] = near.nearest(middle);
    if (i == all.rows.size()) continue;
    const GuideRow& row = all.rows[i];
    const double offset_m = (middle.head<2>() - row.at_m).dot(left_of(row.heading));
    const bool looks_right = is_road[looks.of_object[mesh.object_of_triangle[t]]];
    // Along its border, strips that names call otherwise are not the road's.
    const double more_m = all.across_m * (looks_right ? 1.0 : names_know ? -kNearBorder : 0.0);
    // Ground may rise or fall beside the road, not along it: what lies under a bridge is not the
    // road of a row farther on.
    bool is_road_here = flat[t] && !is_kerb && is_beside && inside(row, offset_m, more_m);
    if (is_road_here && !looks_right) {
      // Paint lies on the road, with all of its corners; what lies under it is ground that goes on
      // below, what lies over it a thing that stands there.
      const auto hits = surface.all_hits(middle.x(), middle.y());
      is_road_here = std::none_of(hits.begin(), hits.end(), [&](const SurfaceHit& hit) {
        const double above_m = middle.z() - hit.z_m;
        const bool is_paint = above_m >= 0.0 && above_m <= kPaintShare * all.reach_m;
        return looks_like_road(hit.triangle) && std::abs(above_m) < kLayerShare * all.reach_m &&
               !(is_paint && lies_on_road(t));
      });
      if (!is_road_here) continue;
    }
    result.class_of_triangle[t] = is_road_here ? SurfaceClass::road
                                  : is_kerb    ? SurfaceClass::kerb
                                               : SurfaceClass::runoff;
  }
  // Large triangles are hit by rays though their middles lie far away.
  for (const GuideRow& row : all.rows) {
    if (!row.has_surface) continue;
    const int most = static_cast<int>(std::lround(all.reach_m / all.across_m));
    for (int k = -most; k <= most; ++k) {
      const double offset_m = k * all.across_m;
      if (!inside(row, offset_m, 0.0)) continue;
      const Vector2d p = row.at_m + offset_m * left_of(row.heading);
      const auto hit = surface.nearest_hit(p.x(), p.y(), row.z_m, kLayerShare * all.reach_m);
      if (hit && looks_like_road(hit->triangle) &&
          by_names[source[hit->triangle]] != SurfaceClass::kerb)
        result.class_of_triangle[source[hit->triangle]] = SurfaceClass::road;
    }
  }
  return result;
}

}  // namespace road
