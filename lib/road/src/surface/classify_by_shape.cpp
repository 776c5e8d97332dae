#include "classify_by_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>
#include <unordered_map>
#include <unordered_set>

#include "strip_ends.h"

namespace road {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
// A chain along the track outlives anything that runs across it (60 m with run-off on both sides).
constexpr double kShortestChain_m = 120.0;
constexpr std::size_t kFewestChainEdges = 8;
constexpr double kNarrowestRoad_m = 4.5;
constexpr double kWidestRoad_m = 45.0;
// "Keeps its distance": this share of the length within this much of the median width.
constexpr double kSteadyShare = 0.8;
constexpr double kSteadyWidth = 0.04;
// Roads that get wider and narrower do so over more edges than this.
constexpr std::size_t kAround = 12;
// A steady strip counts as the road unless a merely smooth one joins many more cross sections.
constexpr double kAsManyRings = 0.7;
// Nothing of a band lies farther from its chain than this many widths (bends make it more than
// one).
constexpr double kBandReach = 1.4;
// Columns of the same road: equal width, no fold between them.
constexpr double kSameColumn = 0.06;
constexpr double kFlatFold = 1.5 * kDegree;
// Farther from the road than this nothing is called its run-off.
constexpr double kWidestRunoff_m = 25.0;
// A piece of run-off has its outer edge along the inner one (cosine), and its sides across it.
constexpr double kAlong = 0.94;
constexpr double kAcross = 0.75;
// A fold sharper than this (cosine of 20 degrees) is the foot of a bank.
constexpr double kHill = 0.94;
// Two chains bound the same band when this share of the triangles beside one lies beside the other.
constexpr double kCommonShare = 0.8;
// A strip that continues the road across a gap has its width.
constexpr double kSameWidth = 0.1;
constexpr double kLongestGap_m = 40.0;
// Of strips this nearly as long as the longest the widest is the road; the others run beside it.
constexpr double kAsLong = 0.85;
// A strip beside the road may be the road itself when it is this wide (of the road taken), or when
// it is less wide and lies between two wider ones, or beside something wider than most roads are.
constexpr double kAlikeWidth = 0.5, kRivalWidth = 0.3, kUsuallyNarrower_m = 20.0;
constexpr double kBesideShare = 0.5;

std::uint64_t directed(std::uint32_t from, std::uint32_t to) {
  return static_cast<std::uint64_t>(from) << 32 | to;
}
std::uint64_t undirected(std::uint32_t a, std::uint32_t b) {
  return directed(std::min(a, b), std::max(a, b));
}

/// Who lies beside a directed edge, and which vertices a vertex is joined with.
class Fans {
 public:
  explicit Fans(const FlatSurface& flat) : flat_(flat) {
    left_.reserve(4 * flat.triangles.size());
    for (std::uint32_t t = 0; t < flat.triangles.size(); ++t) {
      for (std::size_t c = 0; c < 3; ++c) {
        left_.try_emplace(directed(flat.triangles[t][c], flat.triangles[t][(c + 1) % 3]), t);
      }
    }
    first_.assign(flat.vertices_m.size() + 1, 0);
    std::vector<std::uint64_t> pairs;
    pairs.reserve(2 * left_.size());
    for (const Triangle& t : flat.triangles) {
      for (std::size_t c = 0; c < 3; ++c) {
        pairs.push_back(directed(t[c], t[(c + 1) % 3]));
        pairs.push_back(directed(t[(c + 1) % 3], t[c]));
      }
    }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    joined_.reserve(pairs.size());
    for (const std::uint64_t pair : pairs) {
      ++first_[(pair >> 32) + 1];
      joined_.push_back(static_cast<std::uint32_t>(pair));
    }
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  }

  /// Triangle on the left of from -> to, kNoIndex if none.
  std::uint32_t left(std::uint32_t from, std::uint32_t to) const {
    const auto found = left_.find(directed(from, to));
    return found == left_.end() ? kNoIndex : found->second;
  }
  std::uint32_t apex(std::uint32_t t, std::uint32_t a, std::uint32_t b) const {
    for (const std::uint32_t v : flat_.triangles[t]) {
      if (v != a && v != b) return v;
    }
    return kNoIndex;
  }
  double turn(std::uint32_t u, std::uint32_t v, std::uint32_t w) const {
    const Eigen::Vector2d in = (flat_.vertices_m[v] - flat_.vertices_m[u]).head<2>();
    const Eigen::Vector2d out = (flat_.vertices_m[w] - flat_.vertices_m[v]).head<2>();
    return std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
  }

  /// Where a chain of edges that comes from u to v goes on. Inside a loft three triangles lie on
  /// either side of it at every vertex; elsewhere it goes as straight as it can.
  std::uint32_t straight_on(std::uint32_t u, std::uint32_t v) const {
    constexpr double kSharpest = 60.0 * kDegree;
    constexpr double kSharpestElsewhere = 25.0 * kDegree;
    std::array<std::uint32_t, 2> third{kNoIndex, kNoIndex};
    std::array<bool, 2> border{false, false};
    for (std::size_t side = 0; side < 2; ++side) {
      std::uint32_t w = u;
      int passed = 0;
      for (; passed < 3; ++passed) {
        const std::uint32_t t = side == 0 ? left(w, v) : left(v, w);
        if (t == kNoIndex) break;
        w = apex(t, w, v);
      }
      if (passed == 3) third[side] = w;
      border[side] = passed == 0;
    }
    std::uint32_t on = kNoIndex;
    if (third[0] != kNoIndex && (third[0] == third[1] || border[1])) on = third[0];
    if (third[1] != kNoIndex && border[0]) on = third[1];
    if (on != kNoIndex && std::abs(turn(u, v, on)) < kSharpest) return on;
    double best = kSharpestElsewhere;
    on = kNoIndex;
    for (std::uint32_t i = first_[v]; i < first_[v + 1]; ++i) {
      if (joined_[i] == u) continue;
      const double angle = std::abs(turn(u, v, joined_[i]));
      if (angle < best) {
        best = angle;
        on = joined_[i];
      }
    }
    return on;
  }

 private:
  const FlatSurface& flat_;
  std::unordered_map<std::uint64_t, std::uint32_t> left_;
  std::vector<std::uint32_t> first_, joined_;
};

struct Chain {
  std::vector<std::uint32_t> vertices;  ///< when closed, the first is not repeated
  bool closed = false;
  double length_m = 0.0;
  std::size_t edges() const { return vertices.size() - (closed ? 0 : 1); }
  std::uint32_t at(std::size_t i) const { return vertices[i % vertices.size()]; }
};

std::vector<Chain> long_chains(const FlatSurface& flat, const Fans& fans) {
  const std::vector<EdgeUse> uses = edge_uses(flat.triangles);
  std::unordered_map<std::uint64_t, bool> taken;
  taken.reserve(uses.size());
  std::vector<Chain> chains;
  for (const EdgeUse& use : uses) {
    if (!taken.try_emplace(use.key, true).second) continue;
    const auto a = static_cast<std::uint32_t>(use.key >> 32);
    const auto b = static_cast<std::uint32_t>(use.key & 0xffffffffu);
    std::deque<std::uint32_t> line{a, b};
    bool closed = false;
    for (int direction = 0; direction < 2 && !closed; ++direction) {
      std::uint32_t u = direction == 0 ? a : b;
      std::uint32_t v = direction == 0 ? b : a;
      while (true) {
        const std::uint32_t w = fans.straight_on(u, v);
        if (w == kNoIndex) break;
        const std::uint64_t key = undirected(v, w);
        if (taken.contains(key)) {
          closed = key == use.key && line.size() > 3;
          break;
        }
        if (fans.straight_on(w, v) != u) break;
        taken.emplace(key, true);
        direction == 0 ? line.push_back(w) : line.push_front(w);
        u = v;
        v = w;
      }
    }
    Chain chain;
    if (closed && line.front() == line.back()) line.pop_back();
    chain.vertices.assign(line.begin(), line.end());
    chain.closed = closed;
    for (std::size_t i = 0; i < chain.edges(); ++i) {
      chain.length_m += (flat.vertices_m[chain.at(i + 1)] - flat.vertices_m[chain.at(i)]).norm();
    }
    if (chain.length_m >= kShortestChain_m && chain.edges() >= kFewestChainEdges)
      chains.push_back(std::move(chain));
  }
  return chains;
}

/// The triangles on one side of a chain and how steadily wide they are.
struct Band {
  std::size_t chain = 0;
  bool on_left = true;
  double length_m = 0.0;
  double width_m = 0.0;            ///< median
  double steady = 0.0;             ///< share of the length near the median width
  double smooth = 0.0;             ///< share of the length near the mean width around it
  std::size_t rings = 0;           ///< cross sections that it joins
  std::vector<double> width_at_m;  ///< per edge of the chain; 0: no triangle beside it
  std::vector<std::uint32_t> triangles;
};

Band band_beside(const FlatSurface& flat, const Fans& fans, const std::vector<Chain>& chains,
                 std::size_t index, bool on_left) {
  Band band;
  band.chain = index;
  band.on_left = on_left;
  const Chain& chain = chains[index];
  std::vector<std::pair<double, double>> width_and_length;
  std::vector<std::size_t> edge_of_triangle;
  std::vector<double> width_at(chain.edges(), 0.0);  ///< 0: no triangle beside this edge
  for (std::size_t i = 0; i < chain.edges(); ++i) {
    const std::uint32_t a = chain.at(i);
    const std::uint32_t b = chain.at(i + 1);
    const std::uint32_t t = on_left ? fans.left(a, b) : fans.left(b, a);
    if (t == kNoIndex) continue;
    const Eigen::Vector2d along = (flat.vertices_m[b] - flat.vertices_m[a]).head<2>();
    const Eigen::Vector2d to = (flat.vertices_m[fans.apex(t, a, b)] - flat.vertices_m[a]).head<2>();
    const double length = along.norm();
    if (length <= 0.0) continue;
    width_and_length.emplace_back(std::abs(along.x() * to.y() - along.y() * to.x()) / length,
                                  length);
    width_at[i] = width_and_length.back().first;
    band.length_m += length;
    band.triangles.push_back(t);
    edge_of_triangle.push_back(i);
    // The triangles that touch the chain at b only lie between this edge's and the next one's.
    if (!chain.closed && i + 1 >= chain.edges()) continue;
    const std::uint32_t c = chain.at(i + 2);
    std::uint32_t w = a;
    for (std::uint32_t s = t; s != kNoIndex;) {
      w = fans.apex(s, w, b);
      if (w == c) break;
      s = on_left ? fans.left(w, b) : fans.left(b, w);
      if (s != kNoIndex) {
        band.triangles.push_back(s);
        edge_of_triangle.push_back(i);
      }
      if (band.triangles.size() > 6 * (i + 2) + 64) break;
    }
  }
  if (width_and_length.empty()) return band;
  std::sort(width_and_length.begin(), width_and_length.end());
  double passed = 0.0;
  for (const auto& [width, length] : width_and_length) {
    passed += length;
    band.width_m = width;
    if (passed >= 0.5 * band.length_m) break;
  }
  for (const auto& [width, length] : width_and_length) {
    if (std::abs(width - band.width_m) < kSteadyWidth * band.width_m)
      band.steady += length / band.length_m;
  }
  band.rings = width_and_length.size();
  std::vector<double> width_around(chain.edges(), band.width_m);
  for (std::size_t i = 0; i < chain.edges(); ++i) {
    if (width_at[i] <= 0.0) continue;
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t k = i - std::min(i, kAround); k < std::min(chain.edges(), i + kAround + 1);
         ++k) {
      if (width_at[k] <= 0.0) continue;
      sum += width_at[k];
      ++count;
    }
    const double mean = sum / static_cast<double>(count);
    width_around[i] = mean;
    if (std::abs(width_at[i] - mean) >= kSteadyWidth * mean) continue;
    band.smooth +=
        (flat.vertices_m[chain.at(i + 1)] - flat.vertices_m[chain.at(i)]).head<2>().norm() /
        band.length_m;
  }
  // Where the chain leaves the road's side at an irregular vertex, or the fan reaches beyond the
  // band.
  std::size_t kept = 0;
  for (std::size_t k = 0; k < band.triangles.size(); ++k) {
    const Eigen::Vector2d a = flat.vertices_m[chain.at(edge_of_triangle[k])].head<2>();
    const Eigen::Vector2d along =
        (flat.vertices_m[chain.at(edge_of_triangle[k] + 1)].head<2>() - a).normalized();
    const double width =
        band.steady >= kSteadyShare ? band.width_m : width_around[edge_of_triangle[k]];
    bool inside = width_at[edge_of_triangle[k]] > width / kBandReach;
    for (const std::uint32_t v : flat.triangles[band.triangles[k]]) {
      const Eigen::Vector2d to = flat.vertices_m[v].head<2>() - a;
      inside = inside && std::abs(along.x() * to.y() - along.y() * to.x()) < kBandReach * width;
    }
    if (inside) band.triangles[kept++] = band.triangles[k];
  }
  band.triangles.resize(kept);
  band.width_at_m = std::move(width_at);
  return band;
}

/// Are the bands on the two sides of a chain of one width, edge by edge?
bool as_wide(const Band& left, const Band& right) {
  std::size_t same = 0, all = 0;
  for (std::size_t i = 0; i < left.width_at_m.size(); ++i) {
    const double l = left.width_at_m[i], r = right.width_at_m[i];
    if (l <= 0.0 || r <= 0.0) continue;
    ++all;
    same += std::abs(l - r) < kSameColumn * std::max(l, r) ? 1 : 0;
  }
  return all > 0 && static_cast<double>(same) >= kSteadyShare * static_cast<double>(all);
}

Eigen::Vector3d normal_of(const FlatSurface& flat, std::uint32_t t) {
  const Triangle& v = flat.triangles[t];
  return (flat.vertices_m[v[1]] - flat.vertices_m[v[0]])
      .cross(flat.vertices_m[v[2]] - flat.vertices_m[v[0]])
      .normalized();
}

/// Mean angle between the surfaces on both sides of a chain.
double fold_along(const FlatSurface& flat, const Fans& fans, const Chain& chain) {
  double sum = 0.0, length = 0.0;
  for (std::size_t i = 0; i < chain.edges(); ++i) {
    const std::uint32_t l = fans.left(chain.at(i), chain.at(i + 1));
    const std::uint32_t r = fans.left(chain.at(i + 1), chain.at(i));
    if (l == kNoIndex || r == kNoIndex) continue;
    const double step = (flat.vertices_m[chain.at(i + 1)] - flat.vertices_m[chain.at(i)]).norm();
    sum += step * std::acos(std::clamp(normal_of(flat, l).dot(normal_of(flat, r)), -1.0, 1.0));
    length += step;
  }
  return length > 0.0 ? sum / length : std::numbers::pi;
}

/// Follows a column of quads across `front` (surface behind it on its left) as long as it keeps its
/// width.
void march(const FlatSurface& flat, const Fans& fans, std::uint32_t p, std::uint32_t q,
           std::vector<char>& road) {
  const auto at = [&](std::uint32_t v) { return Eigen::Vector2d(flat.vertices_m[v].head<2>()); };
  const double width = (at(q) - at(p)).norm();
  Eigen::Vector2d ahead((at(q) - at(p)).y(), -(at(q) - at(p)).x());
  ahead.normalize();
  std::vector<std::uint32_t> passed;
  std::uint32_t behind = fans.left(p, q);
  if (behind == kNoIndex) return;
  while (true) {
    const std::uint32_t t = fans.left(q, p);
    if (t == kNoIndex || road[t]) return;
    const std::uint32_t x = fans.apex(t, q, p);
    // The new front is (p, x) or (x, q): the one along which the side left behind goes straight
    // ahead.
    const Eigen::Vector2d from_q = (at(x) - at(q)).normalized();
    const Eigen::Vector2d from_p = (at(x) - at(p)).normalized();
    const bool moves_q = from_q.dot(ahead) > from_p.dot(ahead);
    const Eigen::Vector2d along = moves_q ? from_q : from_p;
    const std::uint32_t next_p = moves_q ? p : x;
    const std::uint32_t next_q = moves_q ? x : q;
    // Width across the direction of travel: a diagonal front is longer than the road is wide.
    const Eigen::Vector2d chord = at(next_q) - at(next_p);
    const double across = std::abs(chord.x() * along.y() - chord.y() * along.x());
    const bool folded = normal_of(flat, t).dot(normal_of(flat, behind)) < kHill;
    behind = t;
    if (folded || along.dot(ahead) < 0.5 || std::abs(across - width) > 0.1 * width) {
      for (const std::uint32_t s : passed) road[s] = 0;
      return;
    }
    passed.push_back(t);
    road[t] = 1;
    ahead = (0.5 * ahead + 0.5 * along).normalized();
    p = next_p;
    q = next_q;
  }
}

/// Triangles of a road to be; area and border give length and width as of a long strip.
struct Strip {
  std::vector<std::uint32_t> triangles;  ///< ascending
  std::vector<std::size_t> chains;       ///< that its bands lie beside
  std::size_t rings = 0;
  double area_m2 = 0.0, border_m = 0.0;
  double length_m() const { return border_m / 2.0; }
  double width_m() const { return border_m > 0.0 ? 2.0 * area_m2 / border_m : 0.0; }
};

void measure(const FlatSurface& flat, const Fans& fans, Strip& strip) {
  for (const std::uint32_t t : strip.triangles) {
    const Triangle& v = flat.triangles[t];
    const Eigen::Vector3d& a = flat.vertices_m[v[0]];
    strip.area_m2 += 0.5 * (flat.vertices_m[v[1]] - a).cross(flat.vertices_m[v[2]] - a).norm();
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t across = fans.left(v[(c + 1) % 3], v[c]);
      if (across != kNoIndex &&
          std::binary_search(strip.triangles.begin(), strip.triangles.end(), across))
        continue;
      strip.border_m += (flat.vertices_m[v[(c + 1) % 3]] - flat.vertices_m[v[c]]).norm();
    }
  }
}

/// Marks with 2 what hangs on the sides of the road (1) without a wall between.
void grow_runoff(const FlatSurface& flat, const Fans& fans, std::vector<char>& mark) {
  // Points along the sides of the road, in a grid: how far is a triangle from the road?
  constexpr double kCell_m = kWidestRunoff_m;
  std::unordered_map<std::uint64_t, std::vector<Eigen::Vector3d>> sides;
  const auto cell_of = [](double value) {
    return static_cast<std::int64_t>(std::floor(value / kCell_m));
  };
  const auto key_of = [](std::int64_t x, std::int64_t y) {
    return static_cast<std::uint64_t>(x) << 32 ^ static_cast<std::uint32_t>(y);
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open;
  for (std::uint32_t t = 0; t < flat.triangles.size(); ++t) {
    if (mark[t] != 1) continue;
    const Triangle& v = flat.triangles[t];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t p = v[c], q = v[(c + 1) % 3];
      const std::uint32_t across = fans.left(q, p);
      if (across != kNoIndex && mark[across] == 1) continue;
      open.emplace_back(p, q);
      const Eigen::Vector3d& a = flat.vertices_m[p];
      const Eigen::Vector3d step = flat.vertices_m[q] - a;
      const int pieces = 1 + static_cast<int>(step.norm() / 3.0);
      for (int k = 0; k < pieces; ++k) {
        const Eigen::Vector3d point = a + step * ((k + 0.5) / pieces);
        sides[key_of(cell_of(point.x()), cell_of(point.y()))].push_back(point);
      }
    }
  }
  const auto near_road = [&](const Eigen::Vector3d& point) {
    for (std::int64_t x = cell_of(point.x()) - 1; x <= cell_of(point.x()) + 1; ++x) {
      for (std::int64_t y = cell_of(point.y()) - 1; y <= cell_of(point.y()) + 1; ++y) {
        const auto found = sides.find(key_of(x, y));
        if (found == sides.end()) continue;
        for (const Eigen::Vector3d& side : found->second) {
          if ((side - point).head<2>().squaredNorm() < kWidestRunoff_m * kWidestRunoff_m)
            return true;
        }
      }
    }
    return false;
  };
  const auto at = [&](std::uint32_t v) { return Eigen::Vector2d(flat.vertices_m[v].head<2>()); };
  const auto walled = [&](std::uint32_t p, std::uint32_t q) {
    return std::binary_search(flat.walls.begin(), flat.walls.end(), undirected(p, q));
  };
  /// Is p, q, y, x (x beside p, y beside q) a piece of a loft: x-y runs like p-q, p-x and q-y
  /// across?
  const auto lofted = [&](std::uint32_t p, std::uint32_t q, std::uint32_t x, std::uint32_t y) {
    const Eigen::Vector2d inner = at(q) - at(p), outer = at(y) - at(x), px = at(x) - at(p),
                          qy = at(y) - at(q);
    const double ratio = outer.norm() / inner.norm();
    return ratio > 0.1 && ratio < 10.0 && outer.dot(inner) > kAlong * outer.norm() * inner.norm() &&
           std::abs(px.dot(inner)) < kAcross * px.norm() * inner.norm() &&
           std::abs(qy.dot(inner)) < kAcross * qy.norm() * inner.norm() &&
           near_road(flat.vertices_m[x]) && near_road(flat.vertices_m[y]);
  };
  std::deque<std::pair<std::uint32_t, std::uint32_t>> fronts(open.begin(), open.end());
  while (!fronts.empty()) {
    const auto [p, q] = fronts.front();
    fronts.pop_front();
    const std::uint32_t t = fans.left(q, p);
    if (t == kNoIndex || mark[t] != 0 || walled(p, q)) continue;
    const std::uint32_t x = fans.apex(t, q, p);
    // The second triangle of the quad lies across q-x or across p-x.
    const std::uint32_t by_q = walled(q, x) ? kNoIndex : fans.left(q, x);
    const std::uint32_t by_p = walled(p, x) ? kNoIndex : fans.left(x, p);
    for (const bool across_q : {true, false}) {
      const std::uint32_t second = across_q ? by_q : by_p;
      if (second == kNoIndex || mark[second] != 0) continue;
      const std::uint32_t y = across_q ? fans.apex(second, q, x) : fans.apex(second, x, p);
      const std::uint32_t beside_p = across_q ? x : y;
      const std::uint32_t beside_q = across_q ? y : x;
      if (!lofted(p, q, beside_p, beside_q)) continue;
      const std::uint32_t behind = fans.left(p, q);
      if (behind != kNoIndex && normal_of(flat, behind).dot(normal_of(flat, t)) < kHill) continue;
      mark[t] = mark[second] = 2;
      fronts.emplace_back(beside_p, beside_q);
      break;
    }
  }
  // What is left over between lofted pieces: the triangle where a strip begins or ends.
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<std::uint32_t> enclosed;
    for (std::uint32_t t = 0; t < flat.triangles.size(); ++t) {
      if (mark[t] != 0) continue;
      int sides_marked = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t p = flat.triangles[t][c], q = flat.triangles[t][(c + 1) % 3];
        const std::uint32_t across = fans.left(q, p);
        sides_marked += across != kNoIndex && mark[across] != 0 && !walled(p, q) ? 1 : 0;
      }
      if (sides_marked >= 2) enclosed.push_back(t);
    }
    for (const std::uint32_t t : enclosed) mark[t] = 2;
  }
}

/// Adds triangles that have two sides in common with the strip: chains that break off leave such
/// gaps between columns.
void fill_notches(const FlatSurface& flat, const Fans& fans,
                  std::vector<std::uint32_t>& triangles) {
  std::vector<char> in(flat.triangles.size(), 0);
  for (const std::uint32_t t : triangles) in[t] = 1;
  std::vector<std::uint32_t> newest = triangles;
  while (!newest.empty()) {
    std::vector<std::uint32_t> added;
    for (const std::uint32_t t : newest) {
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t near = fans.left(flat.triangles[t][(c + 1) % 3], flat.triangles[t][c]);
        if (near == kNoIndex || in[near]) continue;
        int sides = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::uint32_t across =
              fans.left(flat.triangles[near][(k + 1) % 3], flat.triangles[near][k]);
          sides += across != kNoIndex && in[across] ? 1 : 0;
        }
        if (sides < 2) continue;
        in[near] = 1;
        added.push_back(near);
      }
    }
    triangles.insert(triangles.end(), added.begin(), added.end());
    newest = std::move(added);
  }
  std::sort(triangles.begin(), triangles.end());
}

/// A road is a band, what lies between the same two chains, and further columns of equal width. Of
/// the bands that `admits` names, all strips that are as wide as a road.
template <class Admits>
std::vector<Strip> strips_of_bands(const FlatSurface& flat, const Fans& fans,
                                   const std::vector<Chain>& chains, const std::vector<Band>& bands,
                                   Admits admits) {
  std::vector<std::vector<std::uint32_t>> bands_of_triangle(flat.triangles.size());
  for (std::uint32_t b = 0; b < bands.size(); ++b) {
    if (!admits(b)) continue;
    for (const std::uint32_t t : bands[b].triangles) {
      if (bands_of_triangle[t].empty() || bands_of_triangle[t].back() != b)
        bands_of_triangle[t].push_back(b);
    }
  }
  std::vector<int> fold_known(chains.size(), -1);
  const auto flat_across = [&](std::size_t chain) {
    if (fold_known[chain] < 0)
      fold_known[chain] = fold_along(flat, fans, chains[chain]) < kFlatFold ? 1 : 0;
    return fold_known[chain] == 1;
  };

  std::vector<char> grouped(bands.size(), 0);
  std::vector<Strip> strips;
  for (std::uint32_t first = 0; first < bands.size(); ++first) {
    if (grouped[first] || !admits(first)) continue;
    Strip strip;
    std::vector<std::uint32_t> open{first};
    grouped[first] = 1;
    while (!open.empty()) {
      const std::uint32_t b = open.back();
      open.pop_back();
      strip.chains.push_back(bands[b].chain);
      strip.rings = std::max(strip.rings, bands[b].rings);
      strip.triangles.insert(strip.triangles.end(), bands[b].triangles.begin(),
                             bands[b].triangles.end());
      const std::uint32_t across = b ^ 1u;
      if (!grouped[across] && admits(across) && as_wide(bands[b], bands[across]) &&
          flat_across(bands[b].chain)) {
        grouped[across] = 1;
        open.push_back(across);
      }
      std::map<std::uint32_t, std::size_t> common;
      for (const std::uint32_t t : bands[b].triangles) {
        for (const std::uint32_t other : bands_of_triangle[t]) ++common[other];
      }
      for (const auto& [other, count] : common) {
        const std::size_t fewer =
            std::min(bands[b].triangles.size(), bands[other].triangles.size());
        if (grouped[other] ||
            static_cast<double>(count) < kCommonShare * static_cast<double>(fewer))
          continue;
        grouped[other] = 1;
        open.push_back(other);
      }
    }
    std::sort(strip.triangles.begin(), strip.triangles.end());
    strip.triangles.erase(std::unique(strip.triangles.begin(), strip.triangles.end()),
                          strip.triangles.end());
    fill_notches(flat, fans, strip.triangles);
    measure(flat, fans, strip);
    if (strip.width_m() >= kNarrowestRoad_m && strip.width_m() <= kWidestRoad_m)
      strips.push_back(std::move(strip));
  }
  return strips;
}

std::vector<Triangle> triangles_of(const FlatSurface& flat,
                                   const std::vector<std::uint32_t>& indices) {
  std::vector<Triangle> out;
  out.reserve(indices.size());
  for (const std::uint32_t t : indices) out.push_back(flat.triangles[t]);
  return out;
}

/// The open ends of the road that span its whole width.
std::vector<End> road_ends(const FlatSurface& flat, const std::vector<char>& road, double width_m,
                           const std::unordered_set<std::uint64_t>& sides) {
  std::vector<Triangle> triangles;
  for (std::uint32_t t = 0; t < flat.triangles.size(); ++t) {
    if (road[t]) triangles.push_back(flat.triangles[t]);
  }
  std::vector<End> ends = open_ends(triangles, flat.vertices_m, 1.3 * width_m);
  std::erase_if(ends, [&](const End& end) {
    // Two kinks of one side of the road look like an end, too.
    bool on_side = false;
    for (std::size_t i = 0; i + 1 < end.vertices.size(); ++i) {
      on_side = on_side || sides.contains(undirected(end.vertices[i], end.vertices[i + 1]));
    }
    return on_side || end.width_m < 0.9 * width_m;
  });
  return ends;
}

/// Share of a strip's length along which it lies beside the road.
double beside_road(const FlatSurface& flat, const Fans& fans, const std::vector<char>& road,
                   const Strip& strip) {
  double beside_m = 0.0;
  for (const std::uint32_t t : strip.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t p = flat.triangles[t][c], q = flat.triangles[t][(c + 1) % 3];
      const std::uint32_t across = fans.left(q, p);
      if (across == kNoIndex || !road[across] || road[t]) continue;
      beside_m += (flat.vertices_m[q] - flat.vertices_m[p]).norm();
    }
  }
  return beside_m / strip.length_m();
}

std::vector<char> marked(const FlatSurface& flat, const Strip& strip) {
  std::vector<char> mark(flat.triangles.size(), 0);
  for (const std::uint32_t t : strip.triangles) mark[t] = 1;
  return mark;
}

/// The strips that run beside one, as long as it.
std::vector<const Strip*> neighbours(const FlatSurface& flat, const Fans& fans,
                                     const std::vector<Strip>& strips, const Strip& of) {
  const std::vector<char> mark = marked(flat, of);
  std::vector<const Strip*> beside;
  for (const Strip& strip : strips)
    if (&strip != &of && strip.length_m() >= kAsLong * of.length_m() &&
        beside_road(flat, fans, mark, strip) >= kBesideShare)
      beside.push_back(&strip);
  return beside;
}

/// Width of the only strip beside the road that may be the road itself; 0 where none may.
double rival_width_m(const FlatSurface& flat, const Fans& fans, const std::vector<Strip>& strips,
                     const Strip& chosen) {
  const std::vector<const Strip*> beside = neighbours(flat, fans, strips, chosen);
  if (beside.size() != 1) return 0.0;
  const Strip& rival = *beside.front();
  if (rival.width_m() >= kAlikeWidth * chosen.width_m()) return rival.width_m();
  if (rival.width_m() < kRivalWidth * chosen.width_m()) return 0.0;
  const std::vector<const Strip*> around = neighbours(flat, fans, strips, rival);
  const bool between =
      around.size() == 2 && std::all_of(around.begin(), around.end(), [&](const Strip* strip) {
        return strip->width_m() > rival.width_m();
      });
  return between || chosen.width_m() > kUsuallyNarrower_m ? rival.width_m() : 0.0;
}

}  // namespace

ShapeClasses classify_by_shape(const FlatSurface& flat) {
  ShapeClasses out;
  out.class_of_triangle.assign(flat.triangles.size(), SurfaceClass::scenery);
  const Fans fans(flat);
  const std::vector<Chain> chains = long_chains(flat, fans);

  std::vector<Band> bands;  // two for every chain: left, right
  for (std::size_t i = 0; i < chains.size(); ++i) {
    bands.push_back(band_beside(flat, fans, chains, i, true));
    bands.push_back(band_beside(flat, fans, chains, i, false));
  }
  const auto long_enough = [&](std::size_t b) {
    return bands[b].length_m >= kShortestChain_m && bands[b].width_m <= kWidestRoad_m;
  };
  std::vector<Strip> strips = strips_of_bands(flat, fans, chains, bands, [&](std::size_t b) {
    return long_enough(b) && bands[b].steady >= kSteadyShare;
  });
  std::vector<Strip> smooth = strips_of_bands(flat, fans, chains, bands, [&](std::size_t b) {
    return long_enough(b) && bands[b].smooth >= kSteadyShare;
  });
  const auto most_rings = [](const std::vector<Strip>& of) {
    std::size_t most = 0;
    for (const Strip& strip : of) most = std::max(most, strip.rings);
    return static_cast<double>(most);
  };
  if (most_rings(strips) < kAsManyRings * most_rings(smooth)) strips = std::move(smooth);
  if (strips.empty()) return out;
  // The road has the most cross sections, or nearly; of these strips the long ones, of these the
  // widest.
  const double fewest_rings = kAsManyRings * most_rings(strips);
  double longest_m = 0.0;
  for (const Strip& strip : strips) {
    if (static_cast<double>(strip.rings) >= fewest_rings)
      longest_m = std::max(longest_m, strip.length_m());
  }
  const Strip* chosen = nullptr;
  for (const Strip& strip : strips) {
    if (static_cast<double>(strip.rings) < fewest_rings || strip.length_m() < kAsLong * longest_m)
      continue;
    if (chosen == nullptr || strip.width_m() > chosen->width_m()) chosen = &strip;
  }
  out.road_length_m = chosen->length_m();
  out.road_width_m = chosen->width_m();
  std::vector<char> road(flat.triangles.size(), 0);
  for (const std::uint32_t t : chosen->triangles) road[t] = 1;
  out.rival_width_m = rival_width_m(flat, fans, strips, *chosen);

  // Go on where the chains broke: along the open columns, then over to other strips of this width
  // whose end faces one of the road's.
  std::vector<std::vector<End>> ends_of_strip(strips.size());
  for (std::size_t k = 0; k < strips.size(); ++k) {
    if (&strips[k] == chosen ||
        std::abs(strips[k].width_m() - out.road_width_m) > kSameWidth * out.road_width_m)
      continue;
    ends_of_strip[k] =
        open_ends(triangles_of(flat, strips[k].triangles), flat.vertices_m, 1.3 * out.road_width_m);
  }
  std::unordered_set<std::uint64_t> sides;
  const auto add_sides = [&](const Strip& strip) {
    for (const std::size_t c : strip.chains) {
      for (std::size_t i = 0; i < chains[c].edges(); ++i)
        sides.insert(undirected(chains[c].at(i), chains[c].at(i + 1)));
    }
  };
  add_sides(*chosen);
  std::vector<char> joined(strips.size(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    for (const End& end : road_ends(flat, road, out.road_width_m, sides)) {
      for (std::size_t i = 0; i + 1 < end.vertices.size(); ++i)
        march(flat, fans, end.vertices[i], end.vertices[i + 1], road);
    }
    const std::vector<End> ends = road_ends(flat, road, out.road_width_m, sides);
    for (std::size_t k = 0; k < strips.size(); ++k) {
      if (joined[k] || ends_of_strip[k].empty()) continue;
      std::vector<End> both = ends;
      both.insert(both.end(), ends_of_strip[k].begin(), ends_of_strip[k].end());
      for (const Gap& gap : facing_ends(both, kLongestGap_m)) {
        // One end of each; a strip that already is road faces itself.
        const auto of_road = [&](const End& end) {
          return std::any_of(ends.begin(), ends.end(),
                             [&](const End& other) { return other.vertices == end.vertices; });
        };
        if (of_road(gap.a) == of_road(gap.b)) continue;
        if (beside_road(flat, fans, road, strips[k]) > 0.3) continue;
        add_sides(strips[k]);
        for (const std::uint32_t t : strips[k].triangles) road[t] = 1;
        joined[k] = 1;
        changed = true;
        break;
      }
    }
  }

  grow_runoff(flat, fans, road);
  for (std::uint32_t t = 0; t < flat.triangles.size(); ++t) {
    if (road[t] == 1) out.class_of_triangle[t] = SurfaceClass::road;
    if (road[t] == 2) out.class_of_triangle[t] = SurfaceClass::runoff;
  }
  return out;
}

}  // namespace road
