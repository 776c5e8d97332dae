#include "make/plausible.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <unordered_set>

#include "road/name_pattern.h"

namespace road {
namespace {

using Eigen::Vector3d;

constexpr double kMissingShare = 0.05;
constexpr double kGroundShare = 0.5;
constexpr double kAgreement = 0.5;  // of names and shape: less is no confirmation
constexpr double kElsewhereShare = 0.2;
constexpr double kNoRoadShare = 0.5;  // of a road called water: a puddle on it is none
constexpr double kMainMaterialShare = 0.6;

/// Of the usual width; of the length. The widest right road without either, of 41 of others, has
/// 1.45 times (measured along each, 2026-11-23).
constexpr double kMuchWider = 1.6, kWideShare = 0.01;

constexpr const char* kWayOut =
    "look at the picture of the classes (.classes.png); tell what is road by name_rules in a "
    "recipe where objects have names ('crgbuild objects MESH' lists them and shows a rule), else "
    "by a rough line along its middle (--guide FILE, with --guide-width-m W where nothing on the "
    "mesh shows its width), or, if the line is right all the same, say so with "
    "--line-is-right";

double flat_area_m2(const Mesh& mesh, std::size_t t) {
  const Vector3d a = mesh.vertex(t, 1) - mesh.vertex(t, 0),
                 b = mesh.vertex(t, 2) - mesh.vertex(t, 0);
  const Vector3d area = 0.5 * a.cross(b);
  return std::abs(area.z()) >= 0.7 * area.norm() ? std::abs(area.z()) : 0.0;
}

bool is_drivable(SurfaceClass surface_class) {
  return surface_class == SurfaceClass::road || surface_class == SurfaceClass::runoff;
}

void surface_missing(const Centreline& line, const RaySurface& surface,
                     std::vector<std::string>& doubts) {
  const std::size_t n = line.points_m.size(), segments = line.closed ? n : n - 1;
  double missing_m = 0.0, all_m = 0.0, longest_m = 0.0, run_m = 0.0;
  Vector3d place = line.points_m.front(), run_begin = place;
  for (std::size_t i = 0; i < segments; ++i) {
    const Vector3d &p = line.points_m[i], &q = line.points_m[(i + 1) % n];
    const double length_m = (q - p).head<2>().norm();
    const double reach_m = 1.0 + 0.5 * line.half_width_m[i];
    const int pieces =
        std::max(1, static_cast<int>(length_m / std::max(0.2 * line.half_width_m[i], 1e-3)));
    for (int k = 0; k < std::min(pieces, 1000); ++k) {
      const Vector3d at = p + (k + 0.5) / std::min(pieces, 1000) * (q - p);
      const double piece_m = length_m / std::min(pieces, 1000);
      all_m += piece_m;
      if (surface.nearest_hit(at.x(), at.y(), at.z(), reach_m)) {
        run_m = 0.0;
        continue;
      }
      if (run_m == 0.0) run_begin = at;
      missing_m += piece_m;
      run_m += piece_m;
      if (run_m > longest_m) longest_m = run_m, place = run_begin;
    }
  }
  if (missing_m <= kMissingShare * all_m) return;
  doubts.push_back(
      fmt::format("the surface is missing along {:.0f} % of the line ({:.0f} of {:.0f} m), the "
                  "longest piece of {:.0f} m at ({:.1f}, {:.1f})",
                  100.0 * missing_m / all_m, missing_m, all_m, longest_m, place.x(), place.y()));
}

/// Whether the mesh draws the road at a station as one strip: every triangle from border to border.
/// A lane beside the road has its own border, so corners lie between.
bool is_one_strip(const Centreline& line, std::size_t station, const RaySurface& surface,
                  const Mesh& road) {
  constexpr int kPlaces = 9;
  constexpr double kBorder = 0.7;  // of the half width: as far apart may two neighbouring ends be
  const std::size_t n = line.points_m.size();
  const auto wrapped = [&](std::size_t i) { return line.closed ? i % n : std::min(i, n - 1); };
  const Vector3d &at = line.points_m[station], &next = line.points_m[wrapped(station + 1)];
  const Vector3d& before = line.points_m[station > 0 ? station - 1 : line.closed ? n - 1 : 0];
  const Eigen::Vector2d along = (next - before).head<2>();
  const Eigen::Vector2d left = Eigen::Vector2d(-along.y(), along.x()).normalized();
  const double half_m = line.half_width_m[station];
  for (int k = 0; k < kPlaces; ++k) {
    const Eigen::Vector2d place = at.head<2>() + (1.8 * (k + 0.5) / kPlaces - 0.9) * half_m * left;
    const auto hit = surface.nearest_hit(place.x(), place.y(), at.z(), 1.0 + 0.5 * half_m);
    if (!hit) return false;
    for (int c = 0; c < 3; ++c) {
      const Vector3d corner = road.origin_m + road.vertex(hit->triangle, c);
      if (std::abs((corner - at).head<2>().dot(left)) < kBorder * half_m) return false;
    }
  }
  return true;
}

/// A pit lane or an apron in one piece with the road: the line lies in the middle of all of it.
void wide_in_places(const Centreline& line, const RaySurface& surface, const Mesh& road,
                    std::vector<std::string>& doubts) {
  const std::size_t n = line.points_m.size(), segments = line.closed ? n : n - 1;
  std::vector<double> half_m = line.half_width_m;
  const auto middle = half_m.begin() + static_cast<std::ptrdiff_t>(half_m.size() / 2);
  std::nth_element(half_m.begin(), middle, half_m.end());
  const double usual_m = *middle;
  double wide_m = 0.0, all_m = 0.0;
  std::optional<std::size_t> widest;
  for (std::size_t i = 0; i < segments; ++i) {
    const double length_m = (line.points_m[(i + 1) % n] - line.points_m[i]).head<2>().norm();
    all_m += length_m;
    if (line.half_width_m[i] <= kMuchWider * usual_m || is_one_strip(line, i, surface, road))
      continue;
    wide_m += length_m;
    if (!widest || line.half_width_m[i] > line.half_width_m[*widest]) widest = i;
  }
  if (wide_m <= kWideShare * all_m) return;
  doubts.push_back(fmt::format(
      "along {:.0f} m of the line what looks like road is more than {} times as wide as usual "
      "({:.1f} m), {:.1f} m at ({:.1f}, {:.1f}): a pit lane or an apron may be taken for road, and "
      "the line lies in the middle of both",
      wide_m, kMuchWider, 2.0 * usual_m, 2.0 * line.half_width_m[*widest],
      line.points_m[*widest].x(), line.points_m[*widest].y()));
}

void little_of_the_ground(const Mesh& mesh, const CleanReport& report,
                          std::vector<std::string>& doubts) {
  double found_m2 = 0.0, all_m2 = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double area_m2 = flat_area_m2(mesh, t);
    all_m2 += area_m2;
    if (is_drivable(report.class_of_triangle[t])) found_m2 += area_m2;
  }
  if (found_m2 >= kGroundShare * all_m2) return;
  doubts.push_back(
      fmt::format("an open road was found by its shape alone on {:.0f} of {:.0f} m2 of flat "
                  "ground: that may be any strip of it",
                  found_m2, all_m2));
}

/// That most of a road found without names is called something that is no road.
void called_something_else(const Mesh& mesh, const CleanReport& report,
                           std::vector<std::string>& doubts) {
  const NamePattern no_road("(^|[^a-z])(water|river|lake|ocean|pond|sky|roof|ceiling)");
  // A rally stage may be of gravel, sand or dirt.
  const NamePattern verge("(^|[^a-z])(grass|lawn|verge)"), road("road|asphalt|tarmac|track");
  const auto lower_case = [](std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  };
  double all_m2 = 0.0, named_m2 = 0.0;
  std::string example;
  std::vector<std::string> name_of_object;  // empty where nothing speaks against it
  for (const MeshObject& object : mesh.objects) {
    name_of_object.emplace_back();
    for (const std::string* name : {&object.name, &object.material, &object.texture})
      if (name_of_object.back().empty() && no_road.is_in(lower_case(*name)))
        name_of_object.back() = *name;
    // The material tells more than the picture or the object.
    const std::string& telling = !object.material.empty()  ? object.material
                                 : !object.texture.empty() ? object.texture
                                                           : object.name;
    if (const std::string lower = lower_case(telling);
        name_of_object.back().empty() && verge.is_in(lower) && !road.is_in(lower))
      name_of_object.back() = telling;
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (report.class_of_triangle[t] != SurfaceClass::road) continue;
    const double area_m2 = flat_area_m2(mesh, t);
    all_m2 += area_m2;
    const std::string& name = name_of_object[mesh.object_of_triangle[t]];
    if (name.empty()) continue;
    named_m2 += area_m2;
    if (example.empty()) example = name;
  }
  if (named_m2 > kNoRoadShare * all_m2)
    doubts.push_back(
        fmt::format("{:.0f} % of what its shape calls road is called '{}' in the mesh or alike",
                    100.0 * named_m2 / all_m2, example));
}

}  // namespace

std::optional<std::string> same_material_elsewhere(const Centreline& line, const Mesh& mesh,
                                                   const CleanReport& report) {
  const auto look_of = [&](std::size_t t) {
    const MeshObject& object = mesh.objects[mesh.object_of_triangle[t]];
    return object.texture.empty() ? object.material : object.texture;
  };
  std::set<std::string> looks;
  std::map<std::string, double> road_m2;
  double all_m2 = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    looks.insert(look_of(t));
    if (report.class_of_triangle[t] != SurfaceClass::road) continue;
    road_m2[look_of(t)] += flat_area_m2(mesh, t);
    all_m2 += flat_area_m2(mesh, t);
  }
  if (looks.size() < 3 || road_m2.empty()) return {};  // materials tell nothing apart
  const auto main =
      std::max_element(road_m2.begin(), road_m2.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (main->first.empty() || main->second < kMainMaterialShare * all_m2) return {};

  // What lies above or below the line is its own underside or a bridge's.
  double widest_m = 0.0;
  for (const double half_m : line.half_width_m) widest_m = std::max(widest_m, half_m);
  const double cell_m = std::max(widest_m, 1e-3);
  const auto cell = [&](double x, double y) {
    return static_cast<std::int64_t>(std::floor(x / cell_m)) << 32 ^
           (static_cast<std::int64_t>(std::floor(y / cell_m)) & 0xffffffff);
  };
  std::unordered_set<std::int64_t> near;
  const std::size_t n = line.points_m.size();
  for (std::size_t i = 0; i < (line.closed ? n : n - 1); ++i) {
    const Vector3d &p = line.points_m[i], &q = line.points_m[(i + 1) % n];
    const int pieces = 1 + static_cast<int>(std::min((q - p).head<2>().norm() / cell_m * 2.0, 1e4));
    for (int k = 0; k <= pieces; ++k) {
      const Vector3d at = p + static_cast<double>(k) / pieces * (q - p);
      for (int dx = -1; dx <= 1; ++dx)
        for (int dy = -1; dy <= 1; ++dy)
          near.insert(cell(at.x() + dx * cell_m, at.y() + dy * cell_m));
    }
  }
  double found_m2 = 0.0, elsewhere_m2 = 0.0, largest_m2 = 0.0;
  Vector3d place = Vector3d::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (look_of(t) != main->first) continue;
    const double area_m2 = flat_area_m2(mesh, t);
    if (is_drivable(report.class_of_triangle[t])) {
      found_m2 += area_m2;
      continue;
    }
    const Vector3d middle =
        mesh.origin_m + (mesh.vertex(t, 0) + mesh.vertex(t, 1) + mesh.vertex(t, 2)) / 3.0;
    if (near.contains(cell(middle.x(), middle.y()))) continue;
    elsewhere_m2 += area_m2;
    if (area_m2 > largest_m2) largest_m2 = area_m2, place = middle;
  }
  if (elsewhere_m2 <= kElsewhereShare * found_m2) return {};
  return fmt::format(
      "the road is made of '{}', of which {:.0f} m2 are in it and {:.0f} m2 lie elsewhere, for "
      "example at ({:.1f}, {:.1f}): this may be a part of the road only",
      main->first, found_m2, elsewhere_m2, place.x(), place.y());
}

namespace {

/// Another surface of the mesh a little above the road: a wheel would meet that one.
void below_another(const Centreline& line, const RaySurface& ground, const CleanReport& report,
                   std::vector<std::string>& doubts) {
  constexpr double kEvery_m = 10.0, kMuch = 0.3;        // of the line
  constexpr double kLowest_m = 0.03, kHighest_m = 2.5;  // paint lies lower, bridges higher
  std::size_t looked = 0, covered = 0;
  double gone_m = kEvery_m, over_m = 0.0;
  for (std::size_t i = 0; i + 1 < line.points_m.size(); ++i) {
    const Vector3d& at = line.points_m[i];
    gone_m += (line.points_m[i + 1] - at).head<2>().norm();
    if (gone_m < kEvery_m) continue;
    gone_m = 0.0;
    ++looked;
    for (const SurfaceHit& hit : ground.all_hits(at.x(), at.y())) {
      if (hit.z_m - at.z() < kLowest_m || hit.z_m - at.z() > kHighest_m ||
          std::binary_search(report.left_out.begin(), report.left_out.end(), hit.triangle))
        continue;
      ++covered;
      over_m = std::max(over_m, hit.z_m - at.z());
      break;
    }
  }
  if (static_cast<double>(covered) <= kMuch * static_cast<double>(looked)) return;
  doubts.push_back(fmt::format(
      "another surface of the mesh lies up to {:.2f} m above the road along {:.0f} % of it: that "
      "one may be the road",
      over_m, 100.0 * static_cast<double>(covered) / static_cast<double>(looked)));
}

/// A strip at the rim of flat ground, found by its shape alone: the road may be what lies beside
/// it.
void at_the_rim(const Centreline& line, const RaySurface& ground,
                std::vector<std::string>& doubts) {
  constexpr double kEvery_m = 10.0, kSlope = 0.3;
  constexpr double kMostly = 0.6, kHardly = 0.2;  // of the line
  const std::size_t n = line.points_m.size();
  std::array<std::size_t, 2> with_ground{}, part_way{};  // as far as looked; 0.9
  std::size_t looked = 0;
  double gone_m = kEvery_m;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const Vector3d& at = line.points_m[i];
    const Eigen::Vector2d along = (line.points_m[i + 1] - at).head<2>();
    gone_m += along.norm();
    if (gone_m < kEvery_m || along.norm() == 0.0) continue;
    gone_m = 0.0;
    ++looked;
    const Eigen::Vector2d left = Eigen::Vector2d(-along.y(), along.x()).normalized();
    const double half_m = line.half_width_m[i];
    for (const bool is_left : {true, false}) {
      bool goes_on = true;
      for (const double beside : {0.3, 0.9, 1.5}) {  // half widths beyond the edge
        if (beside == 1.5) part_way[is_left ? 0 : 1] += goes_on ? 1 : 0;
        const double off_m = (1.0 + beside) * half_m;
        const Eigen::Vector2d place = at.head<2>() + (is_left ? off_m : -off_m) * left;
        goes_on =
            goes_on &&
            ground.nearest_hit(place.x(), place.y(), at.z(), 0.5 + kSlope * off_m).has_value();
      }
      with_ground[is_left ? 0 : 1] += goes_on ? 1 : 0;
    }
  }
  const std::size_t wide = with_ground[0] > with_ground[1] ? 0 : 1;
  const std::size_t most = with_ground[wide], least = part_way[1 - wide];
  if (static_cast<double>(most) < kMostly * static_cast<double>(looked) ||
      static_cast<double>(least) > kHardly * static_cast<double>(looked))
    return;
  doubts.push_back(fmt::format(
      "by its shape alone the road lies at the rim of flat ground, which goes on along {:.0f} % of "
      "it on the {} and {:.0f} % on the other side: it may be the verge of the road",
      100.0 * static_cast<double>(most) / static_cast<double>(looked), wide == 0 ? "left" : "right",
      100.0 * static_cast<double>(least) / static_cast<double>(looked)));
}

/// Where no name told what is road.
void nothing_confirms(const Centreline& line, const Mesh& mesh, const CleanReport& report,
                      std::vector<std::string>& doubts) {
  if (!line.closed && report.by_names && !report.is_all_by_names)
    doubts.push_back(
        fmt::format("names and shape agree about only {:.0f} % of what either calls road, and the "
                    "road found by names is open: it may be a part of it",
                    100.0 * *report.road_agreement));
  if (!report.by_names) called_something_else(mesh, report, doubts);
  if (!line.closed && !report.by_names && !report.by_place)
    little_of_the_ground(mesh, report, doubts);
  if (auto elsewhere = same_material_elsewhere(line, mesh, report))
    doubts.push_back(std::move(*elsewhere));
}

}  // namespace

std::vector<std::string> doubts_about(const Centreline& line, const RaySurface& surface,
                                      const Mesh& road, const Mesh& mesh,
                                      const CleanReport& report) {
  std::vector<std::string> doubts = report.doubts;
  if (!report.by_guide)
    surface_missing(line, surface, doubts);  // a guide knows better where it should be
  const std::size_t first = doubts.size();
  if (!report.by_guide) wide_in_places(line, surface, road, doubts);
  const bool confirmed =
      report.by_names && (!report.road_agreement || *report.road_agreement >= kAgreement);
  if (!confirmed && !report.by_guide) nothing_confirms(line, mesh, report, doubts);
  std::optional<RaySurface> of_mesh;  // where all of it is road they are the same
  if (road.triangles.size() != mesh.triangles.size() || !report.left_out.empty())
    of_mesh.emplace(mesh);
  const RaySurface& ground = of_mesh ? *of_mesh : surface;
  below_another(line, ground, report, doubts);
  if (!report.by_names && !report.by_colour && !report.by_guide && !report.by_place &&
      doubts.empty())
    at_the_rim(line, ground, doubts);
  if (doubts.size() > first) doubts.back() += fmt::format("; {}", kWayOut);
  return doubts;
}

}  // namespace road
