#include "clean_gaps.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>
#include <unordered_map>

#include "strip_ends.h"

namespace road {
namespace {

// A piece under another name fills a gap when it lies this near the surface between the two ends.
constexpr double kGapHeight_m = 0.15;
// A bridge carries this much of the way between two ends, which bends to either side by at most
// this share of its length, tried in steps of a quarter of the road's width.
constexpr double kBridged = 0.9, kMostBulge = 0.25;
constexpr int kBulges = 6;
// A piece from end to end begins this near their corners, and is this much wider than they are at
// most; more ends than these are no road's.
constexpr double kAtEnd_m = 0.5, kWiderThanEnds = 1.6, kWidestOpening_m = 60.0;
constexpr std::size_t kMostEnds = 32;

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

/// How much of the way from p to q lies on some triangles, within `reach_m` in height, over half of
/// the road's width; those between the two ends are added to `carrying`. `bulge_m`: how far to the
/// left of the straight line the middle of the way lies.
double carried(const Mesh& mesh, const std::vector<std::uint32_t>& triangles,
               const Eigen::Vector3d& p, const Eigen::Vector3d& q, double bulge_m,
               double half_width_m, std::vector<std::uint32_t>& carrying) {
  const double length_m = (q - p).head<2>().norm(), reach_m = std::max(1.0, 0.1 * length_m);
  const Eigen::Vector2d along = (q - p).head<2>() / length_m, left(-along.y(), along.x());
  const auto offset_m = [&](double t) { return 4.0 * bulge_m * t * (1.0 - t); };
  constexpr int kPlaces = 40;
  constexpr double kAside[] = {-0.5, 0.0, 0.5};  // of the half width
  std::array<std::array<bool, kPlaces>, std::size(kAside)> on{};
  for (const std::uint32_t i : triangles) {
    bool near = true;
    for (int c = 0; c < 3 && near; ++c) {
      const Eigen::Vector2d to = (mesh.vertex(i, c) - p).head<2>();
      const double s_m = to.dot(along), t = std::clamp(s_m / length_m, 0.0, 1.0);
      const double aside_m = std::abs(to.dot(left) - offset_m(t));
      const double z_m = p.z() + t * (q.z() - p.z());
      near = s_m > -2.0 * half_width_m && s_m < length_m + 2.0 * half_width_m &&
             aside_m < 2.0 * half_width_m && std::abs(mesh.vertex(i, c).z() - z_m) < reach_m;
    }
    if (!near) continue;
    carrying.push_back(i);
    const Eigen::Vector3d &a = mesh.vertex(i, 0), &b = mesh.vertex(i, 1), &c = mesh.vertex(i, 2);
    for (std::size_t n = 0; n < on.size() * kPlaces; ++n) {
      bool& is_on = on[n / kPlaces][n % kPlaces];
      const double t = (static_cast<double>(n % kPlaces) + 0.5) / kPlaces;
      const double aside_m = offset_m(t) + kAside[n / kPlaces] * half_width_m;
      const Eigen::Vector2d at = p.head<2>() + length_m * t * along + aside_m * left;
      const auto side = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
        return (to - from).x() * (at.y() - from.y()) - (to - from).y() * (at.x() - from.x());
      };
      const double ab = side(a, b), bc = side(b, c), ca = side(c, a);
      is_on = is_on || (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
    }
  }
  auto least = kPlaces;
  for (const auto& lane : on)
    least = std::min(least, static_cast<int>(std::count(lane.begin(), lane.end(), true)));
  return static_cast<double>(least) / kPlaces;
}

/// Flat triangles of every object that are no road yet.
std::vector<std::vector<std::uint32_t>> flat_by_object(
    const Mesh& mesh, const std::vector<bool>& flat,
    const std::vector<SurfaceClass>& class_of_triangle) {
  std::vector<std::vector<std::uint32_t>> out(mesh.objects.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
    if (flat[i] && class_of_triangle[i] != SurfaceClass::road)
      out[mesh.object_of_triangle[i]].push_back(i);
  return out;
}

/// Components of those of `from` that have a corner near an end, each with the ends that it has.
struct PieceAtEnds {
  std::vector<std::uint32_t> triangles;  ///< of the mesh
  std::vector<std::size_t> ends;
  double width_m = 0.0;
};

std::vector<PieceAtEnds> pieces_at(const std::vector<End>& ends, const Soup& soup) {
  const Components found = components(soup.triangles);
  std::vector<PieceAtEnds> pieces(found.count);
  std::vector<double> area_m2(found.count, 0.0), border_m(found.count, 0.0);
  std::vector<std::vector<std::array<bool, 2>>> has(
      found.count, std::vector<std::array<bool, 2>>(ends.size(), {false, false}));
  for (std::uint32_t i = 0; i < soup.triangles.size(); ++i) {
    const std::uint32_t piece = found.of_triangle[i];
    pieces[piece].triangles.push_back(soup.source[i]);
    area_m2[piece] += soup.area_vector_of(i).norm();
    for (const std::uint32_t v : soup.triangles[i])
      for (std::size_t e = 0; e < ends.size(); ++e)
        for (std::size_t k = 0; k < 2; ++k) {
          const Eigen::Vector3d to = soup.vertices_m[v] - (k == 0 ? ends[e].first : ends[e].last);
          if (to.head<2>().norm() < kAtEnd_m && std::abs(to.z()) < kGapHeight_m)
            has[piece][e][k] = true;
        }
  }
  const std::vector<EdgeUse> uses = edge_uses(soup.triangles);
  for (std::size_t i = 0; i < uses.size(); ++i)
    if ((i == 0 || uses[i - 1].key != uses[i].key) &&
        (i + 1 == uses.size() || uses[i + 1].key != uses[i].key)) {
      const Triangle& t = soup.triangles[uses[i].t];
      border_m[found.of_triangle[uses[i].t]] +=
          (soup.vertices_m[t[(uses[i].c + 1u) % 3]] - soup.vertices_m[t[uses[i].c]]).norm();
    }
  for (std::uint32_t piece = 0; piece < found.count; ++piece) {
    for (std::size_t e = 0; e < ends.size(); ++e)
      if (has[piece][e][0] && has[piece][e][1]) pieces[piece].ends.push_back(e);
    pieces[piece].width_m = border_m[piece] > 0.0 ? area_m2[piece] / border_m[piece] : 0.0;
  }
  return pieces;
}

/// Of the triangles that may fill gaps, those of objects with a corner near an end.
std::vector<std::uint32_t> of_objects_at(const std::vector<End>& ends, const Mesh& mesh,
                                         const std::vector<bool>& may_fill) {
  std::vector<bool> at_end(mesh.objects.size(), false);
  std::vector<std::uint32_t> found;
  for (const bool collects : {false, true})
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      if (!may_fill[i]) continue;
      if (collects && at_end[mesh.object_of_triangle[i]]) found.push_back(i);
      for (int c = 0; c < 3 && !collects; ++c)
        for (const End& end : ends)
          if ((mesh.vertex(i, c) - end.first).norm() < kAtEnd_m)
            at_end[mesh.object_of_triangle[i]] = true;
    }
  return found;
}

using Row = std::vector<std::uint32_t>;
using EdgeTriangles = std::unordered_map<std::uint64_t, std::uint32_t>;

/// The rows of a bridge from one end of a gap, `a`, to the other, `b`, both included, each from the
/// same side. The edges of new rows take the triangle across the edge of `a`.
std::vector<Row> bridge_rows(const Gap& gap, const Row& a, Row b, Soup& soup,
                             EdgeTriangles& triangle_of_edge) {
  const auto like_at = [&](const Row& end, std::size_t k) {
    return triangle_of_edge.find(undirected(end[k], end[k + 1]));
  };
  const auto points = [&](const Row& end, const Eigen::Vector2d& way) {
    std::vector<EndPoint> found;
    for (std::size_t k = 0; k < end.size(); ++k) {
      const auto like = like_at(end, std::min(k, end.size() - 2));
      const Eigen::Vector3d n = like == triangle_of_edge.end() ? Eigen::Vector3d::UnitZ()
                                                               : soup.area_vector_of(like->second);
      found.push_back(
          {soup.vertices_m[end[k]], n.z() == 0.0 ? 0.0 : -n.head<2>().dot(way) / n.z()});
    }
    return found;
  };
  std::vector<Row> rows{a};
  for (const auto& row : rows_over(gap, points(a, gap.a.outward), points(b, -gap.b.outward))) {
    Row& next = rows.emplace_back();
    for (const Eigen::Vector3d& at_m : row) {
      next.push_back(static_cast<std::uint32_t>(soup.vertices_m.size()));
      soup.vertices_m.push_back(at_m);
    }
    for (std::size_t k = 0; k + 1 < a.size(); ++k)
      if (const auto like = like_at(a, k); like != triangle_of_edge.end())
        triangle_of_edge[undirected(next[k], next[k + 1])] = std::uint32_t{like->second};
  }
  rows.push_back(std::move(b));
  return rows;
}

/// Triangles between two rows of a bridge; how many. Steps on the row whose next vertex lies less
/// far across. They take class and object from the triangle across the edge that they share with a
/// row.
std::size_t stitch(const Row& a, const Row& b, Soup& soup, const EdgeTriangles& triangle_of_edge) {
  const std::size_t before = soup.triangles.size();
  const Eigen::Vector3d first = soup.vertices_m[a.front()];
  const Eigen::Vector2d across = (soup.vertices_m[a.back()] - first).head<2>().normalized();
  const auto offset = [&](std::uint32_t vertex) {
    return across.dot((soup.vertices_m[vertex] - first).head<2>());
  };
  std::size_t i = 0, j = 0;
  while (i + 1 < a.size() || j + 1 < b.size()) {
    const bool step_a =
        j + 1 >= b.size() || (i + 1 < a.size() && offset(a[i + 1]) <= offset(b[j + 1]));
    const auto like =
        triangle_of_edge.find(step_a ? undirected(a[i], a[i + 1]) : undirected(b[j], b[j + 1]));
    Triangle t = step_a ? Triangle{a[i + 1], a[i], b[j]} : Triangle{b[j], b[j + 1], a[i]};
    (step_a ? i : j) += 1;
    if (like == triangle_of_edge.end() || t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    const Eigen::Vector3d area =
        area_vector(soup.vertices_m[t[0]], soup.vertices_m[t[1]], soup.vertices_m[t[2]]);
    if (area.z() < 0.0) std::swap(t[1], t[2]);
    soup.triangles.push_back(t);
    soup.source.push_back(soup.source[like->second]);
    soup.surface_class.push_back(soup.surface_class[like->second]);
  }
  return soup.triangles.size() - before;
}

}  // namespace

bool fill_gaps_from_end_to_end(const Mesh& mesh, const Soup& soup,
                               const std::vector<bool>& may_fill, const CleanOptions& options,
                               std::vector<SurfaceClass>& class_of_triangle, CleanReport& facts) {
  const std::vector<End> ends = open_ends(road_triangles(soup), soup.vertices_m, kWidestOpening_m);
  if (ends.size() < 2 || ends.size() > kMostEnds) return false;
  CleanReport ignored;
  const Soup others =
      make_soup(mesh, of_objects_at(ends, mesh, may_fill), class_of_triangle, options, ignored);
  bool any = false;
  for (const PieceAtEnds& piece : pieces_at(ends, others)) {
    if (piece.ends.size() < 2) continue;
    const End &a = ends[piece.ends[0]], &b = ends[piece.ends[1]];
    if (piece.width_m > kWiderThanEnds * std::max(a.width_m, b.width_m)) continue;
    for (const std::uint32_t i : piece.triangles) class_of_triangle[i] = SurfaceClass::road;
    any = true;
    const Eigen::Vector3d place = mesh.origin_m + 0.5 * (a.middle + b.middle);
    const MeshObject& object = mesh.objects[mesh.object_of_triangle[piece.triangles.front()]];
    facts.remarks.push_back(
        fmt::format("a gap of {:.0f} m in the road at ({:.1f}, {:.1f}) is bridged by object '{}', "
                    "taken as road",
                    (b.middle - a.middle).head<2>().norm(), place.x(), place.y(), object.name));
  }
  return any;
}

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

std::vector<Bridge> fill_gaps_between_ends(const Mesh& mesh, const RoadGraph& graph,
                                           const std::vector<bool>& flat,
                                           std::vector<SurfaceClass>& class_of_triangle,
                                           CleanReport& facts) {
  std::vector<Bridge> bridges;
  const std::vector<std::vector<std::uint32_t>> of_object =
      flat_by_object(mesh, flat, class_of_triangle);
  for (const RoadBranch& gap : graph.branches) {
    // Shorter ones are crossed where the line is traced; what carries it there may be anything.
    if (!gap.is_gap || gap.gap_m < 3.0 * gap.half_width_m.front()) continue;
    const Eigen::Vector3d &p = gap.points_m.front(), &q = gap.points_m.back();
    const double half_m = std::max(gap.half_width_m.front(), gap.half_width_m.back());
    const double enough = kBridged * gap.gap_m / gap.length_m;
    std::vector<std::uint32_t> best;
    double best_share = 0.0;
    const auto try_all = [&](double bulge_m) {
      for (const std::vector<std::uint32_t>& triangles : of_object) {
        std::vector<std::uint32_t> carrying;
        const double share = carried(mesh, triangles, p, q, bulge_m, half_m, carrying);
        if (share > best_share) best_share = share, best = std::move(carrying);
      }
    };
    try_all(0.0);
    if (best_share < enough)
      for (int k = -kBulges; k <= kBulges; ++k)
        if (std::abs(0.5 * k * half_m) < kMostBulge * gap.length_m) try_all(0.5 * k * half_m);
    if (best_share < enough) continue;
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

void bridge_gaps(Soup& soup, const std::function<bool(std::size_t)>& of,
                 const Eigen::Vector3d& origin_m, const CleanOptions& options, CleanReport& facts) {
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
  EdgeTriangles triangle_of_edge;
  for (const EdgeUse& use : edge_uses(strip)) triangle_of_edge.try_emplace(use.key, index[use.t]);
  for (const Gap& gap : gaps) {
    // Ends at one place in plan are the foot and the top of a step, not a gap.
    if (gap.length_m < options.weld_tolerance_m) continue;
    // Only a gap of the road itself: run-off may well end in front of other run-off.
    bool of_road = false;
    for (std::size_t k = 0; k + 1 < gap.a.vertices.size(); ++k) {
      const auto like = triangle_of_edge.find(undirected(gap.a.vertices[k], gap.a.vertices[k + 1]));
      of_road = of_road || (like != triangle_of_edge.end() &&
                            soup.surface_class[like->second] == SurfaceClass::road);
    }
    if (!of_road) continue;
    const std::vector<std::vector<std::uint32_t>> rows =
        bridge_rows(gap, gap.a.vertices, {gap.b.vertices.rbegin(), gap.b.vertices.rend()}, soup,
                    triangle_of_edge);
    for (std::size_t r = 0; r + 1 < rows.size(); ++r)
      facts.bridging_triangles += stitch(rows[r], rows[r + 1], soup, triangle_of_edge);
    facts.bridged_m += gap.length_m;
    const Eigen::Vector3d place = origin_m + (gap.a.middle + gap.b.middle) / 2.0;
    const std::string length = gap.length_m < 1.0 ? fmt::format("{:.1f} mm", 1000.0 * gap.length_m)
                                                  : fmt::format("{:.2f} m", gap.length_m);
    facts.remarks.push_back(
        fmt::format("a gap of {} across the track at ({:.1f}, {:.1f}) was bridged", length,
                    place.x(), place.y()));
  }
}

}  // namespace road
