#include "classify_by_guide.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include "guide_rows.h"
#include "mesh/ray_surface.h"
#include "road_looks.h"
#include "stations.h"
#include "wide_places.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLayerShare =
    0.05;  // of the reach: the surface beside the road may lie so much higher or lower,
constexpr double kSlope = 0.5;       // and this much more per metre beyond its border
constexpr double kFartherOn = 0.25;  // of the reach: a row may lie so much farther than the nearest
constexpr double kPaintShare = 0.001;  // of the reach, above the road: 30 mm
constexpr double kNearBorder = 2.0;    // rays
constexpr double kMostMissing = 0.3;   // of the rows may be without surface
constexpr double kMissingIsDoubted = 0.05;
constexpr double kUntoldIsDoubted = 0.3,
                 kUntoldIsSaid = 0.05;  // of the rows do not tell where the road ends
constexpr double kEndsShare = 0.5;      // of the rows have to know where the road ends

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

/// The flat triangles of a mesh, with the looks of all.
struct Ground {
  Mesh mesh;
  std::vector<std::uint32_t> source, look_of_triangle;  ///< of its triangles
  Looks looks;
};

base::Answer<Ground> flat_ground(const Mesh& mesh, const std::vector<bool>& flat) {
  Ground out;
  auto& [ground, source, look_of_triangle, looks] = out;
  looks = looks_of(mesh);
  ground.origin_m = mesh.origin_m;
  ground.vertices_m = mesh.vertices_m;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!flat[t]) continue;
    ground.triangles.push_back(mesh.triangles[t]);
    source.push_back(t);
    look_of_triangle.push_back(looks.of_object[mesh.object_of_triangle[t]]);
  }
  if (source.empty())
    return base::Refusal(fmt::format(
        "nothing to drive on: none of {} triangles is flat; check the axis that points up (--up)",
        mesh.triangles.size()));
  ground.object_of_triangle.assign(source.size(), 0);
  ground.objects.resize(1);
  return out;
}

/// Of the rows with surface: how many tell where the road ends.
double share_told(const GuideRows& all) {
  const auto ends = std::count_if(all.rows.begin(), all.rows.end(),
                                  [](const GuideRow& row) { return row.is_usual; });
  const auto with_surface = std::count_if(all.rows.begin(), all.rows.end(),
                                          [](const GuideRow& row) { return row.has_surface; });
  return static_cast<double>(ends) / static_cast<double>(std::max<std::ptrdiff_t>(with_surface, 1));
}

/// What is said of the road along the guide, and doubted.
void remark_rows(const GuideRows& all, const Guide& guide, const std::vector<bool>& is_road,
                 const Looks& looks, const Missing& missing, double told, GuidedClasses& result) {
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
}

/// What tells whether a triangle is the road's.
struct Road {
  const Mesh& mesh;
  const Ground& ground;
  const RaySurface& surface;
  const std::vector<bool>& is_road;  ///< of looks
  const GuideRows& all;
  RowsNear near;

  bool looks_like_road(std::uint32_t t) const { return is_road[ground.look_of_triangle[t]]; }
};

bool is_inside(const GuideRow& row, double offset_m, double more_m) {
  const double low_m = row.is_usual ? row.right_m : row.middle_m - row.half_width_m;
  const double high_m = row.is_usual ? row.left_m : row.middle_m + row.half_width_m;
  return offset_m >= low_m - more_m && offset_m <= high_m + more_m;
}

bool lies_on_road(const Road& road, std::uint32_t t) {
  for (int corner = 0; corner < 3; ++corner) {
    const Vector3d p = road.mesh.origin_m + road.mesh.vertex(t, corner);
    const std::size_t i = road.near.nearest(p).row;
    if (i == road.all.rows.size()) return false;
    const GuideRow& row = road.all.rows[i];
    if (!is_inside(row, (p.head<2>() - row.at_m).dot(left_of(row.heading)),
                   kNearBorder * road.all.across_m))
      return false;
  }
  return true;
}

/// Paint lies on the road, with all of its corners; what lies under it is ground that goes on
/// below, what lies over it a thing that stands there.
bool is_paint_or_bare(const Road& road, std::uint32_t t, const Vector3d& middle) {
  const auto hits = road.surface.all_hits(middle.x(), middle.y());
  return std::none_of(hits.begin(), hits.end(), [&](const SurfaceHit& hit) {
    const double above_m = middle.z() - hit.z_m;
    const bool is_paint = above_m >= 0.0 && above_m <= kPaintShare * road.all.reach_m;
    return road.looks_like_road(hit.triangle) &&
           std::abs(above_m) < kLayerShare * road.all.reach_m &&
           !(is_paint && lies_on_road(road, t));
  });
}

/// The class of a triangle that is flat or a kerb; nothing where it lies far from the guide, or is
/// no part of the ground.
std::optional<SurfaceClass> class_of(const Road& road, std::uint32_t t, bool flat, bool is_kerb,
                                     bool names_know) {
  const auto& [mesh, ground, surface, is_road, all, near] = road;
  const Vector3d middle =
      mesh.origin_m + (mesh.vertex(t, 0) + mesh.vertex(t, 1) + mesh.vertex(t, 2)) / 3.0;
  const auto [i, is_beside] = near.nearest(middle);
  if (i == all.rows.size()) return std::nullopt;
  const GuideRow& row = all.rows[i];
  const double offset_m = (middle.head<2>() - row.at_m).dot(left_of(row.heading));
  const bool looks_right = is_road[ground.looks.of_object[mesh.object_of_triangle[t]]];
  // Along its border, strips that names call otherwise are not the road's.
  const double more_m = all.across_m * (looks_right ? 1.0 : names_know ? -kNearBorder : 0.0);
  // Ground may rise or fall beside the road, not along it: what lies under a bridge is not the
  // road of a row farther on.
  bool is_road_here = flat && !is_kerb && is_beside && is_inside(row, offset_m, more_m);
  if (is_road_here && !looks_right) {
    is_road_here = is_paint_or_bare(road, t, middle);
    if (!is_road_here) return std::nullopt;
  }
  return is_road_here ? SurfaceClass::road : is_kerb ? SurfaceClass::kerb : SurfaceClass::runoff;
}

/// Large triangles are hit by rays though their middles lie far away.
void take_hit_triangles(const Road& road, const std::vector<SurfaceClass>& by_names,
                        GuidedClasses& result) {
  const auto& [mesh, ground, surface, is_road, all, near] = road;
  for (const GuideRow& row : all.rows) {
    if (!row.has_surface) continue;
    const int most = static_cast<int>(std::lround(all.reach_m / all.across_m));
    for (int k = -most; k <= most; ++k) {
      const double offset_m = k * all.across_m;
      if (!is_inside(row, offset_m, 0.0)) continue;
      const Vector2d p = row.at_m + offset_m * left_of(row.heading);
      const auto hit = surface.nearest_hit(p.x(), p.y(), row.z_m, kLayerShare * all.reach_m);
      if (hit && road.looks_like_road(hit->triangle) &&
          by_names[ground.source[hit->triangle]] != SurfaceClass::kerb)
        result.class_of_triangle[ground.source[hit->triangle]] = SurfaceClass::road;
    }
  }
}

}  // namespace

bool has_several_looks(const Mesh& mesh) {
  return std::any_of(mesh.objects.begin(), mesh.objects.end(), [&](const MeshObject& object) {
    return object.material != mesh.objects.front().material ||
           object.texture != mesh.objects.front().texture;
  });
}

base::Answer<GuidedClasses> classes_along(const Mesh& mesh, const Guide& guide,
                                          std::optional<double> width_m,
                                          const std::vector<bool>& flat,
                                          const std::vector<SurfaceClass>& by_names) {
  auto flat_parts = flat_ground(mesh, flat);
  if (!flat_parts) return flat_parts.refusal();
  Ground& ground = *flat_parts;
  const RaySurface surface(ground.mesh);

  const bool names_know = part_by_names(guide, surface, mesh, ground.source, by_names, ground.looks,
                                        ground.look_of_triangle);
  const auto shares_now = [&] {
    return look_shares(guide, surface, ground.look_of_triangle, ground.looks.names.size());
  };
  LookShares shares = shares_now();
  if (!names_know && join_rare_looks(mesh, shares, ground.looks, ground.look_of_triangle))
    shares = shares_now();
  if (std::all_of(shares.inside.begin(), shares.inside.end(),
                  [](double share) { return share == 0.0; }))
    return base::Refusal(
        "no surface lies under the guide; check that both are in the same frame and that its "
        "columns are x and y of the mesh "
        "(--up and --unit say how the mesh is read)");
  const std::vector<bool> is_road =
      road_looks(shares, names_know ? ground.looks.names.size() / 2 : 0);  // parted by names
  const auto looks_like_road = [&](std::uint32_t t) {
    return static_cast<bool>(is_road[ground.look_of_triangle[t]]);
  };
  GuideRows all = rows_along(guide, surface, looks_like_road);
  const Missing missing = missing_under(all);
  if (missing.share > kMostMissing)
    return base::Refusal(
        missing.text + "; give a mesh that has it, or a guide that lies on what there is", true);
  const double told = share_told(all);
  if (told < kEndsShare && !width_m)
    return base::Refusal(
        fmt::format("under the guide the surface tells along {:.0f} % of it only, by its look, "
                    "slope or border, where the "
                    "road ends. If the guide lies beside the road, check its frame and the order "
                    "of its columns; if the "
                    "road is not to be seen on the mesh, say how wide it is (--guide-width-m W, "
                    "guide_width_m in a recipe)",
                    100.0 * told));
  if (width_m) set_width(all, *width_m);

  GuidedClasses result;
  remark_rows(all, guide, is_road, ground.looks, missing, told, result);
  result.class_of_triangle.assign(mesh.triangles.size(), SurfaceClass::scenery);
  const Road road{mesh, ground, surface, is_road, all, RowsNear(all)};
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const bool is_kerb = by_names[t] == SurfaceClass::kerb;
    if (!flat[t] && !is_kerb) continue;
    if (const auto is = class_of(road, t, flat[t], is_kerb, names_know))
      result.class_of_triangle[t] = *is;
  }
  take_hit_triangles(road, by_names, result);
  return result;
}

}  // namespace road
