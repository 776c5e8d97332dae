#include "clean_layers.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <unordered_set>
#include <utility>

#include "clean_gaps.h"
#include "clean_soup.h"
#include "mesh/ray_surface.h"

namespace road {
namespace {

constexpr double kThinnest_m = 0.05;  // thinner ones are decals that look the wrong way
constexpr double kSame_m = 1e-3;
constexpr double kThickest_m = 1.5;  // of a slab; under thicker ones one drives

/// A name without its level of detail, and that level: "road_LOD1" is ("road", 1).
std::optional<std::pair<std::string, int>> level_of(const std::string& name) {
  std::string lower = name;
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  const std::size_t at = lower.rfind("lod");
  if (at == std::string::npos || (at > 0 && lower[at - 1] >= 'a' && lower[at - 1] <= 'z'))
    return std::nullopt;
  std::size_t digit = at + 3;
  if (digit < lower.size() && (lower[digit] == '_' || lower[digit] == '-')) ++digit;
  if (digit >= lower.size() || lower[digit] < '0' || lower[digit] > '9') return std::nullopt;
  std::size_t end = digit + 1;
  if (end < lower.size() && lower[end] >= '0' && lower[end] <= '9') return std::nullopt;
  return std::pair(lower.substr(0, at) + lower.substr(end), lower[digit] - '0');
}

/// The objects that are coarser copies of another one.
std::vector<bool> coarser_copies(const std::vector<MeshObject>& objects) {
  std::map<std::string, int> finest;
  for (const MeshObject& object : objects)
    if (const auto level = level_of(object.name)) {
      const auto [known, inserted] = finest.try_emplace(level->first, level->second);
      if (!inserted) known->second = std::min(known->second, level->second);
    }
  std::vector<bool> coarser;
  for (const MeshObject& object : objects) {
    const auto level = level_of(object.name);
    coarser.push_back(level && level->second > finest.at(level->first));
  }
  return coarser;
}

// A coarser copy without a level in its name: the same outline and area within this share, this
// many times fewer triangles, most of each within this height of the other: facets cut bends.
constexpr double kSameOutline = 0.02, kSameArea = 0.1, kFewer = 1.5, kOnTheOther = 0.6;
constexpr double kCopyReach_m = 0.3;
constexpr double kLargeShare = 0.2;     // of the largest: a road is no small part
constexpr std::size_t kLookedAt = 200;  // triangles of each
constexpr std::size_t kMostToTakeApart = 1'000'000;

/// Of each vertex of the objects looked at the first one in its place; of others itself.
std::vector<std::uint32_t> places_of(const Mesh& mesh, const std::vector<bool>& looked_at) {
  std::vector<bool> used(mesh.vertices_m.size(), false);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (looked_at[mesh.object_of_triangle[t]])
      for (const std::uint32_t vertex : mesh.triangles[t]) used[vertex] = true;
  std::vector<std::uint32_t> place(used.size()), vertices;
  std::vector<Eigen::Vector3d> points_m;
  for (std::uint32_t i = 0; i < used.size(); ++i) {
    place[i] = i;
    if (used[i]) vertices.push_back(i), points_m.push_back(mesh.vertices_m[i]);
  }
  const std::vector<std::uint32_t> first = weld(points_m, kSame_m, kSame_m);
  for (std::size_t k = 0; k < vertices.size(); ++k) place[vertices[k]] = vertices[first[k]];
  return place;
}

/// Flat faces of an object that hang together by edges of two faces: a copy shares corners with the
/// finer one, and edges across it.
struct FlatPart {
  std::uint32_t object = 0;
  std::vector<std::uint32_t> triangles;
  double area_m2 = 0.0;
  Eigen::AlignedBox2d box;
};

/// The largest first; of large meshes each object is one.
std::vector<FlatPart> flat_parts(const Mesh& mesh, const std::vector<bool>& flat) {
  const bool are_large = mesh.triangles.size() > kMostToTakeApart;
  DisjointSets together(are_large ? 0 : mesh.triangles.size());
  if (!are_large) {
    const std::vector<std::uint32_t> place =
        places_of(mesh, std::vector<bool>(mesh.objects.size(), true));
    std::vector<Triangle> faces;
    std::vector<std::uint32_t> source;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      if (!flat[t]) continue;
      faces.push_back(mesh.triangles[t]);
      for (std::uint32_t& corner : faces.back()) corner = place[corner];
      source.push_back(t);
    }
    const std::vector<EdgeUse> uses = edge_uses(faces);
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
      while (end < uses.size() && uses[end].key == uses[i].key) ++end;
      if (end - i == 2) together.join(source[uses[i].t], source[uses[i + 1].t]);
    }
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, FlatPart> found;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!flat[t]) continue;
    const std::uint32_t object = mesh.object_of_triangle[t];
    FlatPart& part = found[{object, are_large ? 0 : together.find(t)}];
    part.object = object;
    part.triangles.push_back(t);
    part.area_m2 +=
        0.5 * area_vector(mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2)).norm();
    for (int c = 0; c < 3; ++c) part.box.extend(Eigen::Vector2d(mesh.vertex(t, c).head<2>()));
  }
  std::vector<FlatPart> parts;
  for (auto& [key, part] : found) parts.push_back(std::move(part));
  std::stable_sort(parts.begin(), parts.end(),
                   [](const FlatPart& a, const FlatPart& b) { return a.area_m2 > b.area_m2; });
  return parts;
}

bool is_alike(const FlatPart& a, const FlatPart& b) {
  const double apart_m = (a.box.min() - b.box.min()).norm() + (a.box.max() - b.box.max()).norm();
  const auto [fewer, more] = std::minmax(a.triangles.size(), b.triangles.size());
  return apart_m < kSameOutline * a.box.sizes().norm() &&
         std::abs(a.area_m2 - b.area_m2) < kSameArea * a.area_m2 &&
         static_cast<double>(more) >= kFewer * static_cast<double>(fewer);
}

/// Does nearly all of a part lie on or just under or over the other?
bool lies_on(const Mesh& mesh, const RaySurface& surface, const FlatPart& part,
             const FlatPart& other) {
  const std::size_t step = 1 + part.triangles.size() / kLookedAt;
  std::size_t on = 0, all = 0;
  for (std::size_t k = 0; k < part.triangles.size(); k += step, ++all) {
    const std::uint32_t t = part.triangles[k];
    const Eigen::Vector3d at =
        mesh.origin_m + (mesh.vertex(t, 0) + mesh.vertex(t, 1) + mesh.vertex(t, 2)) / 3.0;
    const std::vector<SurfaceHit> hits = surface.all_hits(at.x(), at.y());
    on += std::any_of(hits.begin(), hits.end(), [&](const SurfaceHit& hit) {
      return std::abs(hit.z_m - at.z()) < kCopyReach_m &&
             std::binary_search(other.triangles.begin(), other.triangles.end(), hit.triangle);
    });
  }
  return static_cast<double>(on) >= kOnTheOther * static_cast<double>(all);
}

/// Hides what lies on a finer part of its class all over, whatever it is called; the objects that
/// it belongs to.
std::vector<std::uint32_t> hide_superposed(const Mesh& mesh, const std::vector<bool>& flat,
                                           const std::vector<SurfaceClass>& class_of_object,
                                           std::vector<bool>& hidden) {
  const std::vector<FlatPart> parts = flat_parts(mesh, flat);
  std::vector<std::uint32_t> objects;
  std::optional<RaySurface> surface;
  const auto is_hidden = [&](const FlatPart& part) { return hidden[part.triangles.front()]; };
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t k = i + 1; k < parts.size(); ++k) {
      const FlatPart &a = parts[i], &b = parts[k];
      if (a.area_m2 < kLargeShare * parts[0].area_m2 || b.area_m2 < (1.0 - kSameArea) * a.area_m2)
        break;
      if (class_of_object[a.object] != class_of_object[b.object]) continue;
      if (is_hidden(a) || is_hidden(b) || !is_alike(a, b)) continue;
      if (!surface) surface.emplace(mesh);
      if (!lies_on(mesh, *surface, a, b) || !lies_on(mesh, *surface, b, a)) continue;
      const FlatPart& coarser = a.triangles.size() < b.triangles.size() ? a : b;
      for (const std::uint32_t t : coarser.triangles) hidden[t] = true;
      objects.push_back(coarser.object);
    }
  return objects;
}

double rise_m2(const Mesh& mesh, std::size_t t) {
  return area_vector(mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2)).z();
}

/// Of each object the first one of its material and class: the two sides of a slab may be two
/// objects.
std::vector<std::uint32_t> first_alike(const std::vector<MeshObject>& objects,
                                       const std::vector<SurfaceClass>& class_of_object) {
  std::map<std::pair<std::string, SurfaceClass>, std::uint32_t> first;
  std::vector<std::uint32_t> alike;
  alike.reserve(objects.size());
  for (std::uint32_t k = 0; k < objects.size(); ++k)
    alike.push_back(
        objects[k].material.empty()
            ? k
            : first.try_emplace({objects[k].material, class_of_object[k]}, k).first->second);
  return alike;
}

/// Objects with flat faces that look up as well as down, or that are alike and do.
std::vector<bool> two_sided(const Mesh& mesh, const std::vector<bool>& flat,
                            const std::vector<std::uint32_t>& alike) {
  std::vector<bool> up(mesh.objects.size(), false), down = up;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (flat[t]) (rise_m2(mesh, t) > 0.0 ? up : down)[alike[mesh.object_of_triangle[t]]] = true;
  std::vector<bool> both;
  both.reserve(alike.size());
  for (const std::uint32_t k : alike) both.push_back(up[k] && down[k]);
  return both;
}

/// Of each place whether it is a corner of a body: closed, wound one way all over, its faces
/// looking out. What looks down there is an underside, however thick the body is.
std::vector<bool> corners_of_bodies(const Mesh& mesh, const std::vector<std::uint32_t>& place,
                                    const std::vector<bool>& looked_at) {
  struct Edge {
    std::uint32_t low, high;
    int way;
  };
  std::vector<Edge> edges;
  DisjointSets sets(place.size());
  std::vector<double> six_volumes_m3(place.size(), 0.0);
  const auto each = [&](const auto& run) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& corners = mesh.triangles[t];
      const std::array<std::uint32_t, 3> at{place[corners[0]], place[corners[1]],
                                            place[corners[2]]};
      if (looked_at[mesh.object_of_triangle[t]] && at[0] != at[1] && at[1] != at[2] &&
          at[2] != at[0])
        run(t, at);
    }
  };
  each([&](std::uint32_t, const auto& at) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = at[c], b = at[(c + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
      sets.join(a, b);
    }
  });
  each([&](std::uint32_t t, const auto& at) {
    six_volumes_m3[sets.find(at[0])] +=
        mesh.vertex(t, 0).dot(mesh.vertex(t, 1).cross(mesh.vertex(t, 2)));
  });
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::pair(a.low, a.high) < std::pair(b.low, b.high);
  });
  std::vector<bool> open(place.size(), false), found(place.size(), false);
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    int ways = 0;
    for (; end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high;
         ++end)
      ways += edges[end].way;
    if (end - i != 2 || ways != 0) open[sets.find(edges[i].low)] = true;
    i = end;
  }
  for (const Edge& edge : edges) {
    const std::uint32_t body = sets.find(edge.low);
    found[edge.low] = found[edge.high] = !open[body] && six_volumes_m3[body] > 0.0;
  }
  return found;
}

/// Marks the undersides, each with all that hangs together with it and looks down; their number.
std::size_t mark_undersides(const Mesh& mesh, const std::vector<bool>& flat,
                            const std::vector<SurfaceClass>& class_of_object,
                            std::vector<bool>& hidden) {
  const std::vector<std::uint32_t> alike = first_alike(mesh.objects, class_of_object);
  const std::vector<bool> looked_at = two_sided(mesh, flat, alike);
  if (std::find(looked_at.begin(), looked_at.end(), true) == looked_at.end()) return 0;
  const RaySurface surface(mesh);
  std::vector<std::uint32_t> down;
  std::vector<double> below_m2(mesh.triangles.size(), 0.0);  // under a face of an object alike
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t object = mesh.object_of_triangle[t];
    if (hidden[t] || !flat[t] || !looked_at[object] || rise_m2(mesh, t) >= 0.0) continue;
    down.push_back(t);
    const Eigen::Vector3d at =
        mesh.origin_m + (mesh.vertex(t, 0) + mesh.vertex(t, 1) + mesh.vertex(t, 2)) / 3.0;
    const std::vector<SurfaceHit> hits = surface.all_hits(at.x(), at.y());
    const bool is_below = std::any_of(hits.begin(), hits.end(), [&](const SurfaceHit& hit) {
      const double over_m = hit.z_m - at.z();
      return over_m > kThinnest_m && over_m < kThickest_m && flat[hit.triangle] &&
             alike[mesh.object_of_triangle[hit.triangle]] == alike[object] &&
             rise_m2(mesh, hit.triangle) > 0.0;
    });
    if (is_below) below_m2[t] = -rise_m2(mesh, t);
  }
  // Pieces by corners in one place: an underside goes on where the slab is thicker.
  const std::vector<std::uint32_t> place = places_of(mesh, looked_at);
  DisjointSets pieces(mesh.vertices_m.size());
  const auto piece_of = [&](std::uint32_t t) { return pieces.find(place[mesh.triangles[t][0]]); };
  for (const std::uint32_t t : down)
    for (int c = 1; c < 3; ++c)
      pieces.join(place[mesh.triangles[t][0]],
                  place[mesh.triangles[t][static_cast<std::size_t>(c)]]);
  std::map<std::uint32_t, double> more_below_m2;
  for (const std::uint32_t t : down)
    more_below_m2[piece_of(t)] += 2.0 * below_m2[t] + rise_m2(mesh, t);
  const std::vector<bool> of_body = corners_of_bodies(mesh, place, looked_at);
  std::size_t count = 0;
  for (const std::uint32_t t : down) {
    hidden[t] = of_body[place[mesh.triangles[t][0]]] || more_below_m2[piece_of(t)] > 0.0;
    count += hidden[t] ? 1 : 0;
  }
  return count;
}

// Of the area that names call road: objects that hold less are looked at as strokes, where all
// others hold nearly everything.
constexpr double kSmallShare = 0.02, kMainShare = 0.9;

/// The triangles that names call road of objects with little of it.
std::vector<std::uint32_t> of_small_objects(const Mesh& mesh,
                                            const std::vector<SurfaceClass>& class_of_triangle) {
  std::vector<double> road_m2(mesh.objects.size(), 0.0);
  double all_m2 = 0.0;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (class_of_triangle[i] != SurfaceClass::road) continue;
    const double area_m2 =
        area_vector(mesh.vertex(i, 0), mesh.vertex(i, 1), mesh.vertex(i, 2)).norm();
    road_m2[mesh.object_of_triangle[i]] += area_m2;
    all_m2 += area_m2;
  }
  double main_m2 = 0.0;
  for (const double m2 : road_m2)
    if (m2 >= kSmallShare * all_m2) main_m2 += m2;
  std::vector<std::uint32_t> small;
  if (main_m2 < kMainShare * all_m2) return small;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    if (class_of_triangle[i] == SurfaceClass::road &&
        road_m2[mesh.object_of_triangle[i]] < kSmallShare * all_m2)
      small.push_back(i);
  return small;
}

}  // namespace

std::vector<bool> hidden_triangles(const Mesh& mesh, const std::vector<bool>& flat,
                                   const std::vector<SurfaceClass>& class_of_object,
                                   std::vector<std::string>& remarks) {
  std::vector<bool> hidden(mesh.triangles.size(), false);
  const std::vector<bool> coarser = coarser_copies(mesh.objects);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    hidden[t] = coarser[mesh.object_of_triangle[t]];
  std::vector<std::uint32_t> objects = hide_superposed(mesh, flat, class_of_object, hidden);
  for (std::uint32_t k = 0; k < coarser.size(); ++k)
    if (coarser[k]) objects.push_back(k);
  if (!objects.empty())
    remarks.push_back(fmt::format(
        "{} surface{} of a coarser level of detail left out, for example of object '{}'",
        objects.size(), objects.size() == 1 ? "" : "s",
        mesh.objects[*std::min_element(objects.begin(), objects.end())].name));
  if (const std::size_t count = mark_undersides(mesh, flat, class_of_object, hidden); count > 0)
    remarks.push_back(fmt::format(
        "{} triangle{} that look down, undersides of closed bodies or most of each piece "
        "up to {} m below faces of their own object or material that look up, left out",
        count, count == 1 ? "" : "s", kThickest_m));
  return hidden;
}

void cut_strokes(const Mesh& mesh, const std::vector<bool>& flat, const CleanOptions& options,
                 std::vector<SurfaceClass>& class_of_triangle, CleanReport& facts) {
  const std::vector<std::uint32_t> small = of_small_objects(mesh, class_of_triangle);
  if (small.empty()) return;
  std::vector<SurfaceClass> without = class_of_triangle;
  for (const std::uint32_t i : small) without[i] = SurfaceClass::scenery;
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    if (without[i] == SurfaceClass::road && flat[i]) kept.push_back(i);
  CleanReport counted;
  const Soup rest = make_soup(mesh, kept, without, options, counted);
  std::vector<bool> may_fill(mesh.triangles.size(), false);
  for (const std::uint32_t i : small) may_fill[i] = flat[i];
  if (!fill_gaps_from_other_names(mesh, rest, may_fill, without, counted)) return;

  // What hangs together with a piece that fills a gap, and does not lie in it, sticks out.
  const Soup strokes = make_soup(mesh, small, class_of_triangle, options, counted);
  const std::vector<std::uint32_t> component = components(strokes.triangles).of_triangle;
  std::unordered_set<std::uint32_t> filling;
  for (std::size_t k = 0; k < strokes.source.size(); ++k)
    if (without[strokes.source[k]] == SurfaceClass::road) filling.insert(component[k]);
  std::size_t cut = 0;
  for (std::size_t k = 0; k < strokes.source.size(); ++k) {
    const std::uint32_t i = strokes.source[k];
    if (without[i] == SurfaceClass::road || !filling.contains(component[k])) continue;
    class_of_triangle[i] = SurfaceClass::scenery;
    if (cut++ == 0)
      facts.remarks.push_back(fmt::format(
          "object '{0}'{1} lies across gaps of the road and sticks out of it: what lies beyond the "
          "edges of the road was left out",
          mesh.objects[mesh.object_of_triangle[i]].name,
          mesh.objects[mesh.object_of_triangle[i]].material.empty()
              ? ""
              : fmt::format(" (material '{}')",
                            mesh.objects[mesh.object_of_triangle[i]].material)));
  }
}

}  // namespace road
