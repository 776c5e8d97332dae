#include "road/clean.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <tuple>
#include <unordered_map>
#include <unordered_set>

#include "base/statistics.h"
#include "classify_by_guide.h"
#include "classify_by_shape.h"
#include "mesh_topology.h"
#include "name_pattern.h"
#include "road/centreline.h"
#include "road/error.h"
#include "road_graph.h"
#include "roads_of.h"
#include "route.h"
#include "strip_ends.h"

namespace road {
namespace {

constexpr double kZeroArea_m2 = 1e-8;
// Vertices snapped at a border must agree in height, or the lip of a kerb would be flattened.
constexpr double kSnapHeight_m = 0.001;
// Where hardly any triangle shares an edge (more components than this share of the triangles) the
// export tore every vertex apart, and there is no step to keep.
constexpr double kTornShare = 0.05;
constexpr double kTornHeight_m = 0.005;
// A gap of the named road is looked for between two ends that face each other within this.
constexpr double kLongestGap_m = 40.0;
// A piece under another name fills a gap when it lies this near the surface between the two ends.
constexpr double kGapHeight_m = 0.15;
// Surfaces that touch within this along their borders belong together (T-junctions).
constexpr double kTouch_m = 0.05;
// A steep face that rises this much from an edge is a wall, one that falls this much an edge of a
// bridge; kerbs are lower.
constexpr double kWallHeight_m = 0.25;
constexpr double kDropHeight_m = 0.5;
// Names that geometry confirms to this degree are believed without a second look.
constexpr double kNamesAreRight = 0.9;
// Shape is taken where it shows this much more road than the names do.
constexpr double kClearlyMore = 1.1;
// The longest piece of missing road that a look at the whole takes for a gap.
constexpr double kRoadGap_m = 12.0;
// Where geometry finds no road it looks again at a model this many times as large.
constexpr double kModelScale = 10.0;
// A second component with this share of the largest one's road is another circuit, not a leftover.
constexpr double kOtherCircuitShare = 0.3;
// A second look that makes the road longer than this has gone astray at a wide place.
constexpr double kDetour = 1.01;
// Of flat ground beyond this multiple of the road only a part can be road.
constexpr double kMuchGround = 4.0;
// All of the ground is a road when its longest way covers this much of it, this slim or slimmer.
constexpr double kAllOfIt = 0.9;
constexpr double kRingSlimness = 0.1;
// A road by its shape that is narrower than this share of a ring this wide may be a lane of it.
constexpr double kLaneShare = 0.6;
constexpr double kWideRing_m = 16.0;
// Two components whose corners lie this near, as a share of their size, are one road drawn twice.
constexpr double kSameRoadShare = 0.02;

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Name rules, compiled. Materials and textures recur, so their answers are kept.
class NameTable {
 public:
  NameTable(const std::vector<NameRule>& rules, const std::string& convention) {
    for (const NameRule& rule : rules) {
      if (!rule.convention.empty() && rule.convention != convention) continue;
      try {
        compiled_.push_back({rule.field, rule.surface_class, NamePattern(rule.pattern), {}});
      } catch (const Error& error) {
        throw Error(fmt::format("name rule {}", error.what()));
      }
    }
  }

  std::optional<SurfaceClass> class_of(const MeshObject& object) {
    const std::array<std::string, 3> text{lower_case(object.name), lower_case(object.material),
                                          lower_case(object.texture)};
    for (Rule& rule : compiled_) {
      const std::string& subject = text[static_cast<std::size_t>(rule.field)];
      if (subject.empty()) continue;
      bool matches = false;
      if (rule.field == NameRule::Field::object) {
        matches = rule.pattern.is_in(subject);
      } else {
        const auto [known, inserted] = rule.answers.try_emplace(subject, false);
        if (inserted) known->second = rule.pattern.is_in(subject);
        matches = known->second;
      }
      if (matches) return rule.surface_class;
    }
    return std::nullopt;
  }

 private:
  struct Rule {
    NameRule::Field field;
    SurfaceClass surface_class;
    NamePattern pattern;
    std::unordered_map<std::string, bool> answers;
  };
  std::vector<Rule> compiled_;
};

Eigen::Vector3d area_vector(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c) {
  return 0.5 * (b - a).cross(c - a);
}

/// The first naming convention of the table one of whose road rules matches an object of the mesh.
std::string convention_of(const Mesh& mesh, const std::vector<NameRule>& rules) {
  std::vector<std::string> conventions;
  for (const NameRule& rule : rules) {
    if (!rule.convention.empty() &&
        std::find(conventions.begin(), conventions.end(), rule.convention) == conventions.end()) {
      conventions.push_back(rule.convention);
    }
  }
  for (const std::string& convention : conventions) {
    NameTable table(rules, convention);
    for (const MeshObject& object : mesh.objects) {
      if (table.class_of(object) == SurfaceClass::road) return convention;
    }
  }
  return {};
}

/// The drivable part of a mesh while it is being cleaned: shared vertices, faces up.
struct Soup {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> source;  ///< triangle of the input mesh it is, or stands beside
  std::vector<SurfaceClass> surface_class;

  Eigen::Vector3d area_vector_of(std::size_t i) const {
    const Triangle& t = triangles[i];
    return area_vector(vertices_m[t[0]], vertices_m[t[1]], vertices_m[t[2]]);
  }

  /// Keeps the triangles for which `keep` says so.
  template <class Keep>
  void filter(Keep keep) {
    std::size_t out = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (!keep(i)) continue;
      triangles[out] = triangles[i];
      source[out] = source[i];
      surface_class[out] = surface_class[i];
      ++out;
    }
    triangles.resize(out);
    source.resize(out);
    surface_class.resize(out);
  }

  /// Applies a vertex map; drops what collapses or repeats.
  void merge_vertices(const std::vector<std::uint32_t>& target,
                      std::map<std::string, std::size_t>& dropped) {
    struct Hash {
      std::size_t operator()(const Triangle& t) const {
        return (static_cast<std::size_t>(t[0]) * 73856093) ^
               (static_cast<std::size_t>(t[1]) * 19349663) ^
               (static_cast<std::size_t>(t[2]) * 83492791);
      }
    };
    std::unordered_set<Triangle, Hash> seen;
    seen.reserve(2 * triangles.size());
    for (Triangle& t : triangles) {
      for (std::uint32_t& index : t) index = target[index];
    }
    filter([&](std::size_t i) {
      Triangle key = triangles[i];
      if (key[0] == key[1] || key[1] == key[2] || key[2] == key[0] ||
          area_vector_of(i).norm() < kZeroArea_m2) {
        ++dropped["zero area"];
        return false;
      }
      std::sort(key.begin(), key.end());
      if (!seen.insert(key).second) {
        ++dropped["duplicate"];
        return false;
      }
      return true;
    });
  }

  /// Leaves out vertices that no triangle uses, in order of first use.
  void compact() {
    std::vector<std::uint32_t> number(vertices_m.size(), kNoIndex);
    std::vector<Eigen::Vector3d> used;
    used.reserve(vertices_m.size());
    for (Triangle& t : triangles) {
      for (std::uint32_t& index : t) {
        if (number[index] == kNoIndex) {
          number[index] = static_cast<std::uint32_t>(used.size());
          used.push_back(vertices_m[index]);
        }
        index = number[index];
      }
    }
    vertices_m = std::move(used);
  }
};

Soup make_soup(const Mesh& mesh, const std::vector<std::uint32_t>& kept,
               const std::vector<SurfaceClass>& class_of_triangle, const CleanOptions& options,
               CleanReport& facts) {
  Soup soup;
  soup.triangles.reserve(kept.size());
  std::vector<std::uint32_t> number(mesh.vertices_m.size(), kNoIndex);
  for (const std::uint32_t i : kept) {
    Triangle t{};
    for (std::size_t c = 0; c < 3; ++c) {
      std::uint32_t& n = number[mesh.triangles[i][c]];
      if (n == kNoIndex) {
        n = static_cast<std::uint32_t>(soup.vertices_m.size());
        soup.vertices_m.push_back(mesh.vertices_m[mesh.triangles[i][c]]);
      }
      t[c] = n;
    }
    soup.triangles.push_back(t);
    soup.source.push_back(i);
    soup.surface_class.push_back(class_of_triangle[i]);
    if (soup.area_vector_of(soup.triangles.size() - 1).z() < 0.0) {
      std::swap(soup.triangles.back()[1], soup.triangles.back()[2]);
      ++facts.faces_turned;
    }
  }
  const std::vector<std::uint32_t> target =
      weld(soup.vertices_m, options.weld_tolerance_m, options.weld_tolerance_m);
  for (std::uint32_t i = 0; i < target.size(); ++i) facts.vertices_welded += target[i] != i ? 1 : 0;
  soup.merge_vertices(target, facts.dropped);
  soup.compact();
  return soup;
}

/// Border vertices that nearly coincide become one: cracks that the weld tolerance left open.
/// Returns what became of each vertex.
std::vector<std::uint32_t> snap_borders(Soup& soup, double horizontal_m, double vertical_m,
                                        CleanReport& facts) {
  std::vector<std::uint32_t> border;
  std::vector<char> seen(soup.vertices_m.size(), 0);
  for (const auto& loop : border_loops(soup.triangles, soup.vertices_m)) {
    for (const std::uint32_t vertex : loop) {
      if (seen[vertex]) continue;
      seen[vertex] = 1;
      border.push_back(vertex);
    }
  }
  std::sort(border.begin(), border.end());
  std::vector<Eigen::Vector3d> points;
  points.reserve(border.size());
  for (const std::uint32_t vertex : border) points.push_back(soup.vertices_m[vertex]);
  const std::vector<std::uint32_t> near = weld(points, horizontal_m, vertical_m);
  std::vector<std::uint32_t> target(soup.vertices_m.size());
  std::iota(target.begin(), target.end(), 0u);
  bool any = false;
  for (std::uint32_t i = 0; i < border.size(); ++i) {
    if (near[i] == i) continue;
    target[border[i]] = border[near[i]];
    any = true;
    ++facts.vertices_snapped;
  }
  if (any) soup.merge_vertices(target, facts.dropped);
  return target;
}

bool is_torn(const std::vector<Triangle>& triangles) {
  const std::vector<std::uint32_t> number = components(triangles);
  const std::size_t count =
      number.empty() ? 0 : 1 + *std::max_element(number.begin(), number.end());
  return static_cast<double>(count) > 1.0 + kTornShare * static_cast<double>(triangles.size());
}

/// The quadrilateral between two ends: is a point in it, and how high is the surface there?
class Corridor {
 public:
  explicit Corridor(const Gap& gap)
      : corner_{gap.a.first, gap.a.last, gap.b.first, gap.b.last},
        centre_((gap.a.middle + gap.b.middle) / 2.0) {
    // Seen from inside the gap, a runs first -> last and b continues first -> last: a closed
    // quadrilateral, clockwise since the surface is on the left of both.
    area_m2_ = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3d &p = corner_[k], &q = corner_[(k + 1) % 4];
      area_m2_ -= 0.5 * (p.x() * q.y() - p.y() * q.x());
    }
  }
  bool contains(const Eigen::Vector3d& point, double margin_m) const {
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector2d edge = (corner_[(k + 1) % 4] - corner_[k]).head<2>();
      const Eigen::Vector2d to = (point - corner_[k]).head<2>();
      const double length = edge.norm();
      if (length > 0.0 && (edge.x() * to.y() - edge.y() * to.x()) / length > margin_m) return false;
    }
    return true;
  }
  double height_at(const Eigen::Vector3d& point) const {
    // Weighted by the distance to the two ends; the ends are straight.
    const auto on_end = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                            double& distance_m) {
      const Eigen::Vector2d along = (q - p).head<2>();
      const Eigen::Vector2d to = (point - p).head<2>();
      const double s = std::clamp(along.dot(to) / along.squaredNorm(), 0.0, 1.0);
      distance_m = (to - s * along).norm();
      return p.z() + s * (q.z() - p.z());
    };
    double da = 0.0, db = 0.0;
    const double za = on_end(corner_[0], corner_[1], da);
    const double zb = on_end(corner_[2], corner_[3], db);
    return da + db > 0.0 ? (za * db + zb * da) / (da + db) : za;
  }
  double area_m2() const { return area_m2_; }
  const Eigen::Vector3d& centre() const { return centre_; }

 private:
  std::array<Eigen::Vector3d, 4> corner_;
  Eigen::Vector3d centre_;
  double area_m2_ = 0.0;
};

/// The triangles of the road in `soup`.
std::vector<Triangle> road_triangles(const Soup& soup) {
  std::vector<Triangle> out;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    if (soup.surface_class[i] == SurfaceClass::road) out.push_back(soup.triangles[i]);
  }
  return out;
}

/// The same as a mesh in the frame of the vertices.
Mesh surface_of(const Soup& soup) {
  Mesh surface;
  surface.vertices_m = soup.vertices_m;
  surface.triangles = road_triangles(soup);
  return surface;
}

/// Where the named road has a gap that pieces of other classes fill, calls these road. True if any.
bool fill_gaps_from_other_names(const Mesh& mesh, const Soup& soup,
                                const std::vector<bool>& may_fill,
                                std::vector<SurfaceClass>& class_of_triangle, CleanReport& facts) {
  const std::vector<Gap> gaps =
      facing_ends(open_ends(road_triangles(soup), soup.vertices_m, 60.0), kLongestGap_m);
  bool any = false;
  for (const Gap& gap : gaps) {
    if (gap.length_m < 0.02) continue;
    const Corridor corridor(gap);
    std::vector<std::uint32_t> filling;
    double filled_m2 = 0.0;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      if (!may_fill[i] || class_of_triangle[i] == SurfaceClass::road) continue;
      const Eigen::Vector3d centroid =
          (mesh.vertex(i, 0) + mesh.vertex(i, 1) + mesh.vertex(i, 2)) / 3.0;
      if ((centroid - corridor.centre()).head<2>().norm() > kLongestGap_m) continue;
      bool inside = corridor.contains(centroid, 0.0);
      for (int c = 0; c < 3 && inside; ++c) {
        inside =
            corridor.contains(mesh.vertex(i, c), 0.5) &&
            std::abs(mesh.vertex(i, c).z() - corridor.height_at(mesh.vertex(i, c))) < kGapHeight_m;
      }
      if (!inside) continue;
      filling.push_back(i);
      filled_m2 +=
          std::abs(area_vector(mesh.vertex(i, 0), mesh.vertex(i, 1), mesh.vertex(i, 2)).z());
    }
    if (filling.empty() || filled_m2 < 0.5 * corridor.area_m2()) continue;
    for (const std::uint32_t i : filling) class_of_triangle[i] = SurfaceClass::road;
    any = true;
    const Eigen::Vector3d place = mesh.origin_m + corridor.centre();
    facts.remarks.push_back(fmt::format(
        "a gap of {:.2f} m in the road at ({:.1f}, {:.1f}) is filled by object '{}', taken as road",
        gap.length_m, place.x(), place.y(),
        mesh.objects[mesh.object_of_triangle[filling.front()]].name));
  }
  return any;
}

/// Triangles of the mesh that carry the road from p to q.
struct Bridge {
  Eigen::Vector3d p, q;
  std::vector<std::uint32_t> triangles;
};

/// How much of the straight line from p to q lies on the triangles of one object, within `reach_m`
/// in height; their flat triangles between the two ends are added to `carrying`.
double carried(const Mesh& mesh, const std::vector<bool>& flat, std::uint32_t object,
               const Eigen::Vector3d& p, const Eigen::Vector3d& q, double half_width_m,
               std::vector<std::uint32_t>& carrying) {
  const double length_m = (q - p).head<2>().norm(), reach_m = std::max(1.0, 0.1 * length_m);
  const Eigen::Vector2d along = (q - p).head<2>() / length_m;
  constexpr int kPlaces = 40;
  std::array<bool, kPlaces> on{};
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.object_of_triangle[i] != object || !flat[i]) continue;
    bool near = true;
    for (int c = 0; c < 3 && near; ++c) {
      const Eigen::Vector2d to = (mesh.vertex(i, c) - p).head<2>();
      const double s_m = to.dot(along), aside_m = std::abs(to.x() * along.y() - to.y() * along.x());
      const double z_m = p.z() + std::clamp(s_m / length_m, 0.0, 1.0) * (q.z() - p.z());
      near = s_m > -2.0 * half_width_m && s_m < length_m + 2.0 * half_width_m &&
             aside_m < 2.0 * half_width_m && std::abs(mesh.vertex(i, c).z() - z_m) < reach_m;
    }
    if (!near) continue;
    carrying.push_back(i);
    const Eigen::Vector3d &a = mesh.vertex(i, 0), &b = mesh.vertex(i, 1), &c = mesh.vertex(i, 2);
    for (std::size_t k = 0; k < kPlaces; ++k) {
      const Eigen::Vector2d at =
          p.head<2>() + length_m * (static_cast<double>(k) + 0.5) / kPlaces * along;
      const auto side = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
        return (to - from).x() * (at.y() - from.y()) - (to - from).y() * (at.x() - from.x());
      };
      const double ab = side(a, b), bc = side(b, c), ca = side(c, a);
      on[k] = on[k] || (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
    }
  }
  return static_cast<double>(std::count(on.begin(), on.end(), true)) / kPlaces;
}

/// Where two ends of the road face each other, an object of another class may carry it from one to
/// the other: a bridge that has a name or a material of its own, and is taken as road.
std::vector<Bridge> fill_gaps_between_ends(const Mesh& mesh, const RoadGraph& graph,
                                           const std::vector<bool>& flat,
                                           std::vector<SurfaceClass>& class_of_triangle,
                                           CleanReport& facts) {
  std::vector<Bridge> bridges;
  for (const RoadBranch& gap : graph.branches) {
    // Shorter ones are crossed where the line is traced; what carries it there may be anything.
    if (!gap.is_gap || gap.gap_m < 3.0 * gap.half_width_m.front()) continue;
    const Eigen::Vector3d &p = gap.points_m.front(), &q = gap.points_m.back();
    const double half_m = std::max(gap.half_width_m.front(), gap.half_width_m.back());
    std::vector<std::uint32_t> best;
    double best_share = 0.0;
    for (std::uint32_t object = 0; object < mesh.objects.size(); ++object) {
      std::vector<std::uint32_t> carrying;
      const double share = carried(mesh, flat, object, p, q, half_m, carrying);
      if (share > best_share) best_share = share, best = std::move(carrying);
    }
    if (best_share < 0.9 * gap.gap_m / gap.length_m) continue;
    for (const std::uint32_t i : best) class_of_triangle[i] = SurfaceClass::road;
    const Eigen::Vector3d place = mesh.origin_m + 0.5 * (p + q);
    const MeshObject& object = mesh.objects[mesh.object_of_triangle[best.front()]];
    bridges.push_back({p, q, std::move(best)});
    facts.remarks.push_back(
        fmt::format("a gap of {:.0f} m in the road at ({:.1f}, {:.1f}) is bridged by object "
                    "'{}'{}, taken as road",
                    gap.gap_m, place.x(), place.y(), object.name,
                    object.texture.empty() ? "" : fmt::format(" (texture '{}')", object.texture)));
  }
  return bridges;
}

/// Closes gaps across the strip made of the triangles that `of` admits by triangles between the
/// ends.
template <class Of>
void bridge_gaps(Soup& soup, Of of, const Eigen::Vector3d& origin_m, const CleanOptions& options,
                 CleanReport& facts) {
  std::vector<Triangle> strip;
  std::vector<std::uint32_t> index;
  for (std::uint32_t i = 0; i < soup.triangles.size(); ++i) {
    if (!of(i)) continue;
    strip.push_back(soup.triangles[i]);
    index.push_back(i);
  }
  const std::vector<Gap> gaps =
      facing_ends(open_ends(strip, soup.vertices_m, 250.0), options.max_gap_m);
  if (gaps.empty()) return;
  std::unordered_map<std::uint64_t, std::uint32_t> triangle_of_edge;
  for (const EdgeUse& use : edge_uses(strip)) triangle_of_edge.try_emplace(use.key, index[use.t]);
  for (const Gap& gap : gaps) {
    // Ends at one place in plan are the foot and the top of a step, not a gap.
    if (gap.length_m < options.weld_tolerance_m) continue;
    // Only a gap of the road itself: run-off may well end in front of other run-off.
    bool of_road = false;
    for (std::size_t k = 0; k + 1 < gap.a.vertices.size(); ++k) {
      const std::uint64_t p = gap.a.vertices[k];
      const std::uint64_t q = gap.a.vertices[k + 1];
      const auto like = triangle_of_edge.find(std::min(p, q) << 32 | std::max(p, q));
      of_road = of_road || (like != triangle_of_edge.end() &&
                            soup.surface_class[like->second] == SurfaceClass::road);
    }
    if (!of_road) continue;
    // Walk both ends from the same side; step on the one whose next vertex lies less far across.
    const std::vector<std::uint32_t>& a = gap.a.vertices;
    const std::vector<std::uint32_t> b(gap.b.vertices.rbegin(), gap.b.vertices.rend());
    const Eigen::Vector2d across = (gap.a.last - gap.a.first).head<2>().normalized();
    const auto offset = [&](std::uint32_t vertex) {
      return across.dot((soup.vertices_m[vertex] - gap.a.first).head<2>());
    };
    std::size_t i = 0, j = 0;
    while (i + 1 < a.size() || j + 1 < b.size()) {
      const bool step_a =
          j + 1 >= b.size() || (i + 1 < a.size() && offset(a[i + 1]) <= offset(b[j + 1]));
      // The new triangle takes class and object from the one across the edge it shares with an end.
      const std::uint64_t p = step_a ? a[i] : b[j];
      const std::uint64_t q = step_a ? a[i + 1] : b[j + 1];
      const auto like = triangle_of_edge.find(std::min(p, q) << 32 | std::max(p, q));
      Triangle t = step_a ? Triangle{a[i + 1], a[i], b[j]} : Triangle{b[j], b[j + 1], a[i]};
      (step_a ? i : j) += 1;
      if (like == triangle_of_edge.end() || t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
      const Eigen::Vector3d area =
          area_vector(soup.vertices_m[t[0]], soup.vertices_m[t[1]], soup.vertices_m[t[2]]);
      if (area.z() < 0.0) std::swap(t[1], t[2]);
      soup.triangles.push_back(t);
      soup.source.push_back(soup.source[like->second]);
      soup.surface_class.push_back(soup.surface_class[like->second]);
      ++facts.bridging_triangles;
    }
    const Eigen::Vector3d place = origin_m + (gap.a.middle + gap.b.middle) / 2.0;
    facts.remarks.push_back(
        fmt::format("a gap of {:.1f} mm across the track at ({:.1f}, {:.1f}) was bridged",
                    1000.0 * gap.length_m, place.x(), place.y()));
  }
}

/// Components of the surface where borders that touch without shared vertices count as joined.
std::vector<std::uint32_t> touching_components(const Soup& soup, std::size_t& by_edges) {
  std::vector<std::uint32_t> number = components(soup.triangles);
  by_edges = number.empty() ? 0 : 1 + *std::max_element(number.begin(), number.end());
  if (by_edges < 2) return number;

  // Border edges in a coarse grid; every border vertex looks for edges of other components nearby.
  struct Edge {
    std::uint32_t a, b, component;
  };
  std::vector<Edge> edges;
  const std::vector<EdgeUse> uses = edge_uses(soup.triangles);
  for (std::size_t i = 0; i < uses.size(); ++i) {
    if ((i > 0 && uses[i - 1].key == uses[i].key) ||
        (i + 1 < uses.size() && uses[i + 1].key == uses[i].key))
      continue;
    edges.push_back({static_cast<std::uint32_t>(uses[i].key >> 32),
                     static_cast<std::uint32_t>(uses[i].key), number[uses[i].t]});
  }
  constexpr double kCell_m = 4.0;
  const auto cell_of = [](double value) {
    return static_cast<std::int64_t>(std::floor(value / kCell_m));
  };
  const auto key_of = [](std::int64_t x, std::int64_t y) {
    return static_cast<std::uint64_t>(x) << 32 ^ static_cast<std::uint32_t>(y);
  };
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells;
  for (std::uint32_t e = 0; e < edges.size(); ++e) {
    const Eigen::Vector3d &p = soup.vertices_m[edges[e].a], &q = soup.vertices_m[edges[e].b];
    const int steps = 1 + static_cast<int>((q - p).head<2>().norm() / kCell_m * 2.0);
    std::uint64_t last = 0;
    for (int k = 0; k <= steps; ++k) {
      const Eigen::Vector3d at = p + (q - p) * (static_cast<double>(k) / steps);
      const std::uint64_t key = key_of(cell_of(at.x()), cell_of(at.y()));
      if (k == 0 || key != last) cells[key].push_back(e);
      last = key;
    }
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> touches;
  for (const Edge& edge : edges) {
    const Eigen::Vector3d& v = soup.vertices_m[edge.a];
    std::uint32_t counted = kNoIndex;
    for (std::int64_t x = cell_of(v.x() - kTouch_m); x <= cell_of(v.x() + kTouch_m); ++x) {
      for (std::int64_t y = cell_of(v.y() - kTouch_m); y <= cell_of(v.y() + kTouch_m); ++y) {
        const auto cell = cells.find(key_of(x, y));
        if (cell == cells.end()) continue;
        for (const std::uint32_t e : cell->second) {
          if (edges[e].component == edge.component || edges[e].component == counted) continue;
          const Eigen::Vector3d &p = soup.vertices_m[edges[e].a], &q = soup.vertices_m[edges[e].b];
          const double s = std::clamp((v - p).dot(q - p) / (q - p).squaredNorm(), 0.0, 1.0);
          if ((p + s * (q - p) - v).norm() > kTouch_m) continue;
          counted = edges[e].component;
          ++touches[std::minmax(edge.component, edges[e].component)];
        }
      }
    }
  }
  DisjointSets sets(by_edges);
  for (const auto& [pair, count] : touches) {
    if (count >= 2) sets.join(pair.first, pair.second);
  }
  for (std::uint32_t& n : number) n = sets.find(n);
  return number;
}

/// What a bridge and the roads at its two ends belong to becomes one component.
void join_by_bridges(const Soup& soup, const std::vector<Bridge>& bridges,
                     std::vector<std::uint32_t>& component) {
  for (const Bridge& bridge : bridges) {
    std::array<double, 2> nearest_m{std::numeric_limits<double>::infinity(),
                                    std::numeric_limits<double>::infinity()};
    std::array<std::uint32_t, 2> at{kNoIndex, kNoIndex};
    std::vector<std::uint32_t> together;
    for (std::uint32_t i = 0; i < soup.triangles.size(); ++i) {
      if (soup.surface_class[i] != SurfaceClass::road) continue;
      if (std::binary_search(bridge.triangles.begin(), bridge.triangles.end(), soup.source[i])) {
        together.push_back(component[i]);
        continue;
      }
      for (std::size_t end = 0; end < 2; ++end) {
        for (const std::uint32_t vertex : soup.triangles[i]) {
          const double d = (soup.vertices_m[vertex] - (end == 0 ? bridge.p : bridge.q)).norm();
          if (d < nearest_m[end]) nearest_m[end] = d, at[end] = component[i];
        }
      }
    }
    for (const std::uint32_t c : at)
      if (c != kNoIndex) together.push_back(c);
    if (together.empty()) continue;
    const std::uint32_t one = *std::min_element(together.begin(), together.end());
    for (std::uint32_t& c : component)
      if (std::find(together.begin(), together.end(), c) != together.end()) c = one;
  }
}

/// Keeps every piece of the surface that has road in it.
void keep_what_touches_road(Soup& soup, CleanReport& facts) {
  const std::vector<std::uint32_t> component = touching_components(soup, facts.components);
  std::unordered_set<std::uint32_t> with_road;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i)
    if (soup.surface_class[i] == SurfaceClass::road) with_road.insert(component[i]);
  soup.filter([&](std::size_t i) {
    if (with_road.contains(component[i])) return true;
    ++facts.dropped["not connected"];
    return false;
  });
}

/// Keeps the connected surface that carries the most road; refuses to choose between circuits.
void keep_one_circuit(Soup& soup, const std::vector<Bridge>& bridges,
                      const Eigen::Vector3d& origin_m, const CleanOptions& options,
                      CleanReport& facts) {
  std::vector<std::uint32_t> component = touching_components(soup, facts.components);
  join_by_bridges(soup, bridges, component);
  struct Part {
    double road_m2 = 0.0;
    double distance_m = std::numeric_limits<double>::infinity();
    Eigen::Vector3d lowest = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Vector3d highest = -lowest;
    Eigen::Vector3d centre() const { return (lowest + highest) / 2.0; }
  };
  std::map<std::uint32_t, Part> parts;
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    if (soup.surface_class[i] != SurfaceClass::road) continue;
    Part& part = parts[component[i]];
    part.road_m2 += soup.area_vector_of(i).norm();
    for (const std::uint32_t vertex : soup.triangles[i]) {
      const Eigen::Vector3d& v = soup.vertices_m[vertex];
      part.lowest = part.lowest.cwiseMin(v);
      part.highest = part.highest.cwiseMax(v);
      if (options.near_m) {
        part.distance_m =
            std::min(part.distance_m, ((origin_m + v).head<2>() - *options.near_m).norm());
      }
    }
  }
  if (parts.empty()) return;
  auto chosen = parts.begin();
  for (auto part = parts.begin(); part != parts.end(); ++part) {
    if (part->second.road_m2 > chosen->second.road_m2) chosen = part;
  }
  std::vector<const Part*> circuits;
  for (const auto& [number, part] : parts) {
    // One road drawn twice is one road.
    const auto is_this = [&, &part = part](const Part* other) {
      const double apart_m =
          (part.lowest - other->lowest).norm() + (part.highest - other->highest).norm();
      return apart_m < kSameRoadShare * (part.highest - part.lowest).norm();
    };
    if (part.road_m2 >= kOtherCircuitShare * chosen->second.road_m2 &&
        std::none_of(circuits.begin(), circuits.end(), is_this))
      circuits.push_back(&part);
  }
  if (circuits.size() > 1 && !options.near_m) {
    std::string places;
    for (const Part* part : circuits) {
      const Eigen::Vector3d centre = origin_m + part->centre();
      const Eigen::Vector3d size = part->highest - part->lowest;
      places += fmt::format("{}{:.0f} m2 around ({:.0f}, {:.0f}), {:.0f} x {:.0f} m",
                            places.empty() ? "" : "; ", part->road_m2, centre.x(), centre.y(),
                            size.x(), size.y());
    }
    throw Error(
        fmt::format("{} separate roads of similar size: {}; wanted one, near a point (--near-m "
                    "X,Y, near_m in a recipe)",
                    circuits.size(), places));
  }
  if (options.near_m) {
    for (auto part = parts.begin(); part != parts.end(); ++part) {
      const bool circuit =
          std::find(circuits.begin(), circuits.end(), &part->second) != circuits.end();
      if (circuit && part->second.distance_m < chosen->second.distance_m) chosen = part;
    }
  }
  soup.filter([&, number = chosen->first](std::size_t i) {
    if (component[i] == number) return true;
    ++facts.dropped["not connected"];
    return false;
  });
}

/// Class of each triangle of the mesh from its geometry alone: road, runoff or scenery (all steep
/// ones).
std::vector<SurfaceClass> classes_by_shape(const Mesh& mesh, const std::vector<bool>& empty,
                                           const std::vector<bool>& flat, CleanOptions options) {
  std::vector<std::uint32_t> all;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!empty[i]) all.push_back(i);
  }
  // Only to see what belongs together: welded coarsely, and surfaces may meet with a step as high
  // as a kerb. The mesh itself stays as it is.
  options.weld_tolerance_m = std::max(options.weld_tolerance_m, 0.01);
  CleanReport ignored;
  std::vector<SurfaceClass> classes(mesh.triangles.size(), SurfaceClass::scenery);
  const Soup soup = make_soup(mesh, all, classes, options, ignored);
  Soup ground = soup;
  ground.filter([&](std::size_t i) { return flat[ground.source[i]]; });
  const std::vector<std::uint32_t> target = snap_borders(ground, kTouch_m, kWallHeight_m, ignored);
  FlatSurface surface;
  surface.vertices_m = std::move(ground.vertices_m);
  surface.triangles = std::move(ground.triangles);
  for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
    if (flat[soup.source[i]]) continue;
    const Triangle& t = soup.triangles[i];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = t[c], b = t[(c + 1) % 3];
      const double edge_m = std::max(soup.vertices_m[a].z(), soup.vertices_m[b].z());
      const double apex_m = soup.vertices_m[t[(c + 2) % 3]].z();
      if (apex_m - edge_m < kWallHeight_m && edge_m - apex_m < kDropHeight_m) continue;
      const auto [low, high] = std::minmax(target[a], target[b]);
      surface.walls.push_back(static_cast<std::uint64_t>(low) << 32 | high);
    }
  }
  std::sort(surface.walls.begin(), surface.walls.end());
  ShapeClasses found = classify_by_shape(surface);
  if (found.road_length_m == 0.0) {  // perhaps a model
    for (Eigen::Vector3d& v : surface.vertices_m) v *= kModelScale;
    found = classify_by_shape(surface);
  }
  for (std::size_t i = 0; i < ground.source.size(); ++i)
    classes[ground.source[i]] = found.class_of_triangle[i];
  return classes;
}

/// Area that both call road over the area that either does; flat triangles only.
double agreement(const Mesh& mesh, const std::vector<SurfaceClass>& a,
                 const std::vector<SurfaceClass>& b, const std::vector<bool>& flat) {
  double both_m2 = 0.0, either_m2 = 0.0;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const bool in_a = a[i] == SurfaceClass::road, in_b = b[i] == SurfaceClass::road;
    if (!flat[i] || (!in_a && !in_b)) continue;
    const double area_m2 =
        area_vector(mesh.vertex(i, 0), mesh.vertex(i, 1), mesh.vertex(i, 2)).norm();
    either_m2 += area_m2;
    if (in_a && in_b) both_m2 += area_m2;
  }
  return either_m2 > 0.0 ? both_m2 / either_m2 : 0.0;
}

/// What is known of every triangle before anything is kept.
struct Triangles {
  std::vector<bool> empty, flat;
  std::vector<SurfaceClass> by_names;
  bool has_named_road = false;
};

Triangles look_at(const Mesh& mesh, const CleanOptions& options) {
  NameTable table(options.name_rules, convention_of(mesh, options.name_rules));
  std::vector<SurfaceClass> class_of_object;
  class_of_object.reserve(mesh.objects.size());
  for (const MeshObject& object : mesh.objects) {
    class_of_object.push_back(table.class_of(object).value_or(SurfaceClass::scenery));
  }
  const double min_cosine = std::cos(options.max_slope_deg * std::numbers::pi / 180.0);
  Triangles triangles;
  triangles.by_names.resize(mesh.triangles.size());
  triangles.flat.resize(mesh.triangles.size());
  triangles.empty.resize(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    triangles.by_names[i] = class_of_object[mesh.object_of_triangle[i]];
    const Eigen::Vector3d area =
        area_vector(mesh.vertex(i, 0), mesh.vertex(i, 1), mesh.vertex(i, 2));
    triangles.empty[i] = area.norm() < kZeroArea_m2;
    triangles.flat[i] = !triangles.empty[i] && std::abs(area.z()) >= min_cosine * area.norm();
  }
  triangles.has_named_road = std::find(class_of_object.begin(), class_of_object.end(),
                                       SurfaceClass::road) != class_of_object.end();
  return triangles;
}

/// Whether nothing that is flat is called anything else than road: then names cannot mislead.
bool is_all_road(const Mesh& mesh, const Triangles& triangles) {
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    if (triangles.flat[i] && triangles.by_names[i] != SurfaceClass::road) return false;
  return true;
}

/// What is left of several roads.
enum class Keep : std::uint8_t { one, touching_road, all };

/// A cleaned surface, and the road that its graph shows.
struct Cleaning {
  Soup soup;
  CleanReport facts;
  std::vector<SurfaceClass> class_of_triangle;
};

/// Everything from classes to a welded surface. With `doubtful` classes (nobody confirms them) also
/// gaps that are longer than a crack are looked at.
Cleaning clean_classes(const Mesh& mesh, const Triangles& triangles,
                       std::vector<SurfaceClass> class_of_triangle, const CleanOptions& options,
                       CleanReport facts, bool doubtful, Keep keep = Keep::one) {
  const auto build_soup = [&](CleanReport& counted) {
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const SurfaceClass surface_class = class_of_triangle[i];
      if (surface_class == SurfaceClass::barrier || surface_class == SurfaceClass::scenery) {
        ++counted.dropped[to_string(surface_class)];
      } else if (triangles.empty[i]) {
        ++counted.dropped["zero area"];
      } else if (!triangles.flat[i] && surface_class != SurfaceClass::kerb) {
        ++counted.dropped["too steep"];
      } else {
        kept.push_back(i);
      }
    }
    return make_soup(mesh, kept, class_of_triangle, options, counted);
  };
  CleanReport first = facts;
  Soup soup = build_soup(first);
  if (keep == Keep::one &&
      fill_gaps_from_other_names(mesh, soup, triangles.flat, class_of_triangle, facts)) {
    first = facts;
    soup = build_soup(first);
  }
  facts = std::move(first);
  std::vector<Bridge> bridges;
  if (doubtful)
    bridges = fill_gaps_between_ends(mesh, road_graph(surface_of(soup)), triangles.flat,
                                     class_of_triangle, facts);
  if (!bridges.empty()) {
    facts.dropped.clear();
    facts.vertices_welded = facts.faces_turned = 0;
    soup = build_soup(facts);
  }
  double snap_height_m = kSnapHeight_m;
  if (options.snap_tolerance_m > 0.0 && is_torn(soup.triangles)) {
    snap_height_m = kTornHeight_m;
    facts.remarks.push_back(
        fmt::format("the triangles hardly share corners at {} mm: border vertices up to {} mm "
                    "apart in height were "
                    "joined; heights are no better than that",
                    1000.0 * options.weld_tolerance_m, 1000.0 * kTornHeight_m));
  }
  snap_borders(soup, options.snap_tolerance_m, snap_height_m, facts);
  bridge_gaps(
      soup, [](std::size_t) { return true; }, mesh.origin_m, options, facts);
  bridge_gaps(
      soup, [&](std::size_t i) { return soup.surface_class[i] == SurfaceClass::road; },
      mesh.origin_m, options, facts);
  if (keep == Keep::touching_road) keep_what_touches_road(soup, facts);
  if (keep == Keep::one) keep_one_circuit(soup, bridges, mesh.origin_m, options, facts);
  if (soup.triangles.empty()) {
    throw Error(
        fmt::format("nothing to drive on: {} triangles in {} objects, none of them road; give a "
                    "mesh with a road, "
                    "or name rules that find it",
                    mesh.triangles.size(), mesh.objects.size()));
  }
  return {std::move(soup), std::move(facts), std::move(class_of_triangle)};
}

/// How much road a surface shows: the longest way through it, less what is not closed, and less
/// what lies beside it.
struct RoadShown {
  double length_m = 0.0, share = 0.0, width_m = 0.0;
  bool closed = false;
  double worth() const { return length_m * (closed ? 1.0 : 0.6) * std::sqrt(share); }
};

RoadShown road_shown(const Soup& soup) {
  const RoadGraph graph = road_graph(surface_of(soup));
  const std::vector<RoadWay> ways = road_ways(graph, kRoadGap_m, 1);
  if (ways.empty()) return {};
  double way_m2 = 0.0;
  const auto& points = ways[0].points_m;
  for (std::size_t i = 1; i < points.size(); ++i)
    way_m2 += 2.0 * ways[0].half_width_m[i] * (points[i] - points[i - 1]).head<2>().norm();
  return {ways[0].length_m, std::min(1.0, way_m2 / graph.area_m2),
          2.0 * base::median(ways[0].half_width_m), ways[0].closed};
}

/// The road by its shape. Where the flat ground as a whole is a closed road, shape must not find
/// only a part of it: the whole is taken in place of an open strip, and a closed lane that is much
/// narrower is doubted.
Cleaning clean_by_shape(const Mesh& mesh, const Triangles& triangles,
                        std::vector<SurfaceClass> by_shape, const CleanOptions& options,
                        const CleanReport& facts) {
  double flat_m2 = 0.0, road_m2 = 0.0;
  std::vector<SurfaceClass> all_flat(mesh.triangles.size(), SurfaceClass::scenery);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!triangles.flat[t]) continue;
    const double area_m2 =
        0.5 * std::abs(area_vector(mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2)).z());
    all_flat[t] = SurfaceClass::road;
    flat_m2 += area_m2;
    if (by_shape[t] == SurfaceClass::road) road_m2 += area_m2;
  }
  std::optional<Cleaning> shaped;
  std::optional<Error> refused;
  try {
    shaped = clean_classes(mesh, triangles, std::move(by_shape), options, facts, true);
  } catch (const Error& error) {
    refused = error;
  }
  std::optional<Cleaning> whole;
  if (road_m2 == 0.0 || road_m2 > flat_m2 / kMuchGround) {
    try {
      whole = clean_classes(mesh, triangles, std::move(all_flat), options, facts, true);
    } catch (const Error&) {  // no road then
    }
  }
  const RoadShown ground = whole ? road_shown(whole->soup) : RoadShown{};
  const bool is_ring =
      ground.closed && ground.share > kAllOfIt && ground.width_m < kRingSlimness * ground.length_m;
  const RoadShown strip = shaped ? road_shown(shaped->soup) : RoadShown{};
  if (is_ring && !strip.closed) {
    whole->facts.remarks.push_back(fmt::format(
        "all of the flat ground is one closed road of about {:.0f} m, {:.1f} m wide; its shape "
        "alone tells no narrower road on it",
        ground.length_m, ground.width_m));
    return std::move(*whole);
  }
  if (!shaped) throw *refused;
  if (is_ring && strip.width_m < kLaneShare * ground.width_m && ground.width_m < kWideRing_m)
    shaped->facts.doubts.push_back(fmt::format(
        "by its shape the road is {:.1f} m wide, on flat ground that is itself a closed road, "
        "{:.1f} m wide: it may be one lane of it; take all of it by a rough line along its middle "
        "(--guide FILE), or, if the line is right all the same, say so with --line-is-right",
        strip.width_m, ground.width_m));
  return std::move(*shaped);
}

/// Both ways of telling road from scenery, and of these the one that shows more of a road; says
/// which and why. Throws what the names' way throws, with what shape finds as a way out.
Cleaning more_plausible(const Mesh& mesh, const Triangles& triangles,
                        std::vector<SurfaceClass> by_shape, const CleanOptions& options,
                        const CleanReport& facts) {
  CleanReport shape_facts = facts;
  shape_facts.by_names = false;
  const auto text = [](const RoadShown& shown) {
    return shown.length_m == 0.0
               ? std::string("no road")
               : fmt::format("{} road of about {:.0f} m ({:.0f} % of what looks like road)",
                             shown.closed ? "a closed" : "an open", shown.length_m,
                             100.0 * shown.share);
  };
  std::optional<Cleaning> shaped;
  try {
    shaped = clean_by_shape(mesh, triangles, std::move(by_shape), options, shape_facts);
  } catch (const Error&) {  // shape finds nothing: then it is for the names to say what is wrong
  }
  const RoadShown by_form = shaped ? road_shown(shaped->soup) : RoadShown{};
  std::optional<Cleaning> named;
  try {
    named = clean_classes(mesh, triangles, triangles.by_names, options, facts, true);
  } catch (const Error& refused) {
    if (by_form.length_m == 0.0) throw;
    throw Error(fmt::format("{}; shape alone finds {}", refused.what(), text(by_form)));
  }
  const RoadShown by_name = road_shown(named->soup);
  const bool take_shape = by_form.worth() > kClearlyMore * by_name.worth();
  Cleaning& taken = take_shape ? *shaped : *named;
  taken.facts.remarks.push_back(fmt::format(
      "names and shape disagree about what is road: by names {}, by shape {}; taken by {} "
      "(--use-names {} takes the other)",
      text(by_name), text(by_form), take_shape ? "shape" : "names", take_shape ? "true" : "false"));
  return std::move(taken);
}

/// The surface as others see it.
RoadMesh road_mesh_of(const Mesh& mesh, const Cleaning& cleaning) {
  const Soup& soup = cleaning.soup;
  RoadMesh road;
  road.mesh.origin_m = mesh.origin_m;
  road.mesh.vertices_m = soup.vertices_m;
  road.mesh.triangles = soup.triangles;
  road.mesh.object_of_triangle.reserve(soup.source.size());
  for (const std::uint32_t i : soup.source)
    road.mesh.object_of_triangle.push_back(mesh.object_of_triangle[i]);
  road.mesh.objects = mesh.objects;
  road.class_of_triangle = soup.surface_class;
  return road;
}

/// Classes from what lies along a guide.
Cleaning clean_along(const Mesh& mesh, const Guide& guide, const Triangles& triangles,
                     const CleanOptions& options, CleanReport facts) {
  facts.by_guide = true;
  GuidedClasses guided =
      classes_along(mesh, guide, options.guide_width_m, triangles.flat, triangles.by_names);
  facts.remarks.insert(facts.remarks.end(), guided.remarks.begin(), guided.remarks.end());
  facts.doubts = std::move(guided.doubts);
  return clean_classes(mesh, triangles, std::move(guided.class_of_triangle), options,
                       std::move(facts), false, Keep::touching_road);
}

/// A line that names did not confirm tells what looks like road: with it as the guide, the parts of
/// the road that were missed come in, and what only lay beside it goes. Where that does not work,
/// and where names shall not count, the first look stands.
void look_again(const Mesh& mesh, const Triangles& triangles, const CleanOptions& options,
                Cleaning& cleaning) {
  if (options.use_names == UseNames::no || !has_several_looks(mesh)) return;
  try {
    const Centreline line = trace_centreline(road_mesh_of(mesh, cleaning));
    if (!line.closed) return;  // doubted anyway
    CleanReport facts;
    facts.triangles_in = cleaning.facts.triangles_in;
    facts.weld_tolerance_m = cleaning.facts.weld_tolerance_m;
    facts.snap_tolerance_m = cleaning.facts.snap_tolerance_m;
    facts.road_agreement = cleaning.facts.road_agreement;
    facts.remarks = cleaning.facts.remarks;
    Cleaning again =
        clean_along(mesh, {line.points_m, line.closed}, triangles, options, std::move(facts));
    if (!again.facts.doubts.empty()) return;
    again.soup.compact();
    const Centreline line_again = trace_centreline(road_mesh_of(mesh, again));
    const bool detours = line_again.length_m > kDetour * line.length_m;
    if (!line_again.closed || detours || !goes_along(line_again, line) ||
        !goes_along(line, line_again))
      return;
    again.facts.by_guide = false;
    again.facts.by_names = cleaning.facts.by_names;
    cleaning = std::move(again);
  } catch (const Error&) {  // trace_centreline() will say so to the user
  }
}

/// The way of the options' route over the roads by names, else over those by shape.
Guide guide_through(const Mesh& mesh, const CleanOptions& options) {
  std::optional<Error> refused;
  for (const RoadGraph& graph : roads_of(mesh, options)) {
    try {
      return guide_of(way_through(graph, options.route_m));
    } catch (const Error& error) {
      if (!refused) refused = error;
    }
  }
  throw refused ? *refused
                : Error(
                      "nothing looks like road: a route has nothing to lead over; give a line "
                      "(--guide FILE)");
}

}  // namespace

std::vector<RoadGraph> roads_of(const Mesh& mesh, const CleanOptions& options) {
  const Triangles triangles = look_at(mesh, options);
  std::vector<RoadGraph> graphs;
  const auto add = [&](std::vector<SurfaceClass> classes) {
    try {
      const RoadGraph graph = road_graph(surface_of(
          clean_classes(mesh, triangles, std::move(classes), options, {}, false, Keep::all).soup));
      if (!graph.branches.empty()) graphs.push_back(graph);
    } catch (const Error&) {  // no road of this kind
    }
  };
  if (options.use_names != UseNames::no && triangles.has_named_road) add(triangles.by_names);
  if (options.use_names != UseNames::yes)
    add(classes_by_shape(mesh, triangles.empty, triangles.flat, options));
  return graphs;
}

RoadMesh clean(const Mesh& mesh, const CleanOptions& options, CleanReport* report) {
  if (options.guide && !options.route_m.empty())
    throw Error(
        "a guide and a route seen; both tell which road is meant: give one of them (--guide, "
        "--route)");
  if (options.guide_width_m && !options.guide && options.route_m.empty())
    throw Error(
        "guide_width_m seen without a guide; it is the width of the road along one: give --guide "
        "FILE too");
  CleanReport facts;
  facts.triangles_in = mesh.triangles.size();
  facts.weld_tolerance_m = options.weld_tolerance_m;
  facts.snap_tolerance_m = options.snap_tolerance_m;

  Triangles triangles = look_at(mesh, options);
  const std::optional<Guide> guide =
      options.guide || options.route_m.empty() ? options.guide : guide_through(mesh, options);
  std::vector<SurfaceClass> by_shape;
  if (!guide) by_shape = classes_by_shape(mesh, triangles.empty, triangles.flat, options);
  if (!guide && options.use_names != UseNames::no && triangles.has_named_road) {
    facts.by_names = true;
    facts.road_agreement = agreement(mesh, triangles.by_names, by_shape, triangles.flat);
  }
  Cleaning cleaning;
  if (guide) {
    cleaning = clean_along(mesh, *guide, triangles, options, std::move(facts));
  } else if (!facts.by_names) {
    cleaning = clean_by_shape(mesh, triangles, std::move(by_shape), options, facts);
    cleaning.soup.compact();
    look_again(mesh, triangles, options, cleaning);
  } else if (options.use_names == UseNames::yes || options.near_m ||
             *facts.road_agreement >= kNamesAreRight || is_all_road(mesh, triangles)) {
    cleaning = clean_classes(mesh, triangles, triangles.by_names, options, std::move(facts), false);
  } else {
    cleaning = more_plausible(mesh, triangles, std::move(by_shape), options, facts);
    cleaning.soup.compact();
    look_again(mesh, triangles, options, cleaning);
  }
  Soup& soup = cleaning.soup;
  facts = std::move(cleaning.facts);
  soup.compact();
  facts.non_manifold_edges = adjacency(soup.triangles).non_manifold_edges;
  facts.boundary_loops = count_borders(soup.triangles);

  RoadMesh road = road_mesh_of(mesh, cleaning);
  road.guide = guide;
  facts.class_of_triangle = std::move(cleaning.class_of_triangle);
  for (const SurfaceClass surface_class : road.class_of_triangle)
    ++facts.kept[to_string(surface_class)];
  facts.triangles_kept = road.mesh.triangles.size();
  if (report != nullptr) *report = std::move(facts);
  return road;
}

}  // namespace road
