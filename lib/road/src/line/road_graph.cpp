#include "road_graph.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <queue>
#include <set>
#include <tuple>
#include <unordered_map>
#include <unordered_set>

#include "base/statistics.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kCells = 60'000;  // of the whole surface, more where the road is narrow
constexpr double kMostCells = 1'500'000;
constexpr double kCellsAcross = 8.0;
constexpr double kOneLayer =
    0.3;  // of a cell: heights at one place that are this near are one surface
constexpr double kSteepest = 1.2;
constexpr double kHeadroom_m = 1.5;
constexpr double kLongestGapWidths = 8.0;
constexpr double kFacing = 0.8;      // cosine between the direction of an end and the gap
constexpr double kSharpest = -0.35;  // cosine of the sharpest turn at a fork, 110 degrees
constexpr double kStraightOn = 0.7;  // over a crossing
constexpr std::int32_t kNone = -1;
// East, then counter-clockwise: even ones share a side with the cell.
constexpr std::array<std::array<int, 2>, 8> kAround{
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

struct Cell {
  std::int32_t x = 0, y = 0;
  double z_m = 0.0;
  std::array<std::int32_t, 8> around{};
};

/// The surface as square cells, several above each other where it has layers.
class Cells {
 public:
  Cells(const Mesh& mesh, double cell_m, double headroom_m)
      : cell_m_(cell_m), origin_m_(mesh.origin_m) {
    std::vector<Cell> hits;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      add_triangle(mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2), hits);
    std::sort(hits.begin(), hits.end(), before);
    for (const Cell& hit : hits) {
      const bool above_last = !cells.empty() && cells.back().x == hit.x && cells.back().y == hit.y;
      // One surface drawn twice, or one that no car fits on under the next: the upper one counts.
      if (above_last && hit.z_m - cells.back().z_m < std::max(kOneLayer * cell_m, headroom_m))
        cells.back() = hit;
      else
        cells.push_back(hit);
    }
    index_rows();
    link();
  }

  /// Cells for what is empty, at most this large, and surrounded by one layer.
  void fill_holes(double largest_m2) {
    const auto most = static_cast<std::size_t>(std::max(1.0, largest_m2 / (cell_m_ * cell_m_)));
    // Empty places that were looked at, each with the height of the layer from which it was
    // reached.
    std::unordered_map<std::int64_t, std::vector<double>> seen;
    std::unordered_set<std::int64_t> in_hole;
    const auto key_of = [](const Cell& c) {
      return static_cast<std::int64_t>(c.y) << 32 ^ (c.x & 0xffffffff);
    };
    const auto mark = [&](const Cell& c) {
      std::vector<double>& heights = seen[key_of(c)];
      for (const double z_m : heights)
        if (std::abs(z_m - c.z_m) < kOneLayer * cell_m_) return false;
      heights.push_back(c.z_m);
      return true;
    };
    std::vector<Cell> added, hole;
    // A surface torn into steps has a hole at every step, on each of its heights: such holes stay.
    const std::size_t most_looked_at = 4 * cells.size() + 100'000;
    std::size_t looked_at = 0;
    for (const Cell& border : cells) {
      if (looked_at > most_looked_at) return;
      for (std::size_t k = 0; k < 8; k += 2) {
        if (border.around[k] != kNone) continue;
        hole.assign(1, {border.x + kAround[k][0], border.y + kAround[k][1], border.z_m, {}});
        if (!mark(hole.front())) continue;
        in_hole.clear();
        in_hole.insert(key_of(hole.front()));
        ++looked_at;
        bool open = false;
        for (std::size_t i = 0; i < hole.size() && !open; ++i) {
          if (looked_at > most_looked_at) return;
          for (std::size_t side = 0; side < 8 && !open; side += 2) {
            Cell next{hole[i].x + kAround[side][0], hole[i].y + kAround[side][1], hole[i].z_m, {}};
            const std::int32_t there = find(next.x, next.y, next.z_m);
            if (there != kNone) {
              hole[i].z_m = 0.5 * (hole[i].z_m + cells[static_cast<std::size_t>(there)].z_m);
            } else if (mark(next)) {
              hole.push_back(next);
              in_hole.insert(key_of(next));
              ++looked_at;
              open = hole.size() > most;
            } else {
              // Part of this hole, or of one that was found to be open.
              open = !in_hole.contains(key_of(next));
            }
          }
        }
        if (!open) added.insert(added.end(), hole.begin(), hole.end());
      }
    }
    if (added.empty()) return;
    std::sort(added.begin(), added.end(), before);
    const auto middle = static_cast<std::ptrdiff_t>(cells.size());
    cells.insert(cells.end(), added.begin(), added.end());
    std::inplace_merge(cells.begin(), cells.begin() + middle, cells.end(), before);
    index_rows();
    link();
  }

  Vector3d point_m(std::int32_t i) const {
    const Cell& c = cells[static_cast<std::size_t>(i)];
    return origin_m_ + Vector3d((c.x + 0.5) * cell_m_, (c.y + 0.5) * cell_m_, c.z_m);
  }
  double cell_m() const { return cell_m_; }
  bool has_surface_at(const Vector3d& map_m) const {
    const Vector3d p = map_m - origin_m_;
    return find(static_cast<std::int32_t>(std::floor(p.x() / cell_m_)),
                static_cast<std::int32_t>(std::floor(p.y() / cell_m_)), p.z()) != kNone;
  }

  std::vector<Cell> cells;

 private:
  static bool before(const Cell& a, const Cell& b) {
    return std::tie(a.y, a.x, a.z_m) < std::tie(b.y, b.x, b.z_m);
  }
  /// Cells beside each other are joined up to this difference in height.
  double step_m() const { return kSteepest * cell_m_; }

  void add_triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                    std::vector<Cell>& hits) const {
    const double area = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
    if (std::abs(area) < 1e-12) return;
    const auto first = [&](double v) {
      return static_cast<std::int32_t>(std::ceil(v / cell_m_ - 0.5 - 1e-9));
    };
    const auto last = [&](double v) {
      return static_cast<std::int32_t>(std::floor(v / cell_m_ - 0.5 + 1e-9));
    };
    const std::int32_t y0 = first(std::min({a.y(), b.y(), c.y()})),
                       y1 = last(std::max({a.y(), b.y(), c.y()}));
    const std::int32_t x0 = first(std::min({a.x(), b.x(), c.x()})),
                       x1 = last(std::max({a.x(), b.x(), c.x()}));
    for (std::int32_t y = y0; y <= y1; ++y) {
      for (std::int32_t x = x0; x <= x1; ++x) {
        const Vector2d p((x + 0.5) * cell_m_, (y + 0.5) * cell_m_);
        const auto weight = [&](const Vector3d& q, const Vector3d& r) {
          return ((q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x())) / area;
        };
        const double wa = weight(b, c), wb = weight(c, a), wc = weight(a, b);
        if (std::min({wa, wb, wc}) < -1e-9) continue;
        hits.push_back({x, y, wa * a.z() + wb * b.z() + wc * c.z(), {}});
      }
    }
  }

  void index_rows() {
    row_begin_.clear();
    if (cells.empty()) return;
    first_row_ = cells.front().y;
    row_begin_.assign(static_cast<std::size_t>(cells.back().y - first_row_) + 2, cells.size());
    for (std::size_t i = cells.size(); i-- > 0;)
      row_begin_[static_cast<std::size_t>(cells[i].y - first_row_)] = i;
    for (std::size_t r = row_begin_.size() - 1; r-- > 0;)
      row_begin_[r] = std::min(row_begin_[r], row_begin_[r + 1]);
  }

  /// The cell at (x, y) whose height is nearest to z_m.
  std::int32_t find(std::int32_t x, std::int32_t y, double z_m) const {
    const std::int64_t row = static_cast<std::int64_t>(y) - first_row_;
    if (row < 0 || row + 1 >= static_cast<std::int64_t>(row_begin_.size())) return kNone;
    const auto begin =
        cells.begin() + static_cast<std::ptrdiff_t>(row_begin_[static_cast<std::size_t>(row)]);
    const auto end =
        cells.begin() + static_cast<std::ptrdiff_t>(row_begin_[static_cast<std::size_t>(row) + 1]);
    auto at = std::lower_bound(begin, end, x,
                               [](const Cell& c, std::int32_t wanted) { return c.x < wanted; });
    std::int32_t best = kNone;
    double best_m = step_m();
    for (; at != end && at->x == x; ++at) {
      if (std::abs(at->z_m - z_m) >= best_m) continue;
      best_m = std::abs(at->z_m - z_m);
      best = static_cast<std::int32_t>(at - cells.begin());
    }
    return best;
  }

  void link() {
    for (Cell& c : cells)
      for (std::size_t k = 0; k < 8; ++k)
        c.around[k] = find(c.x + kAround[k][0], c.y + kAround[k][1], c.z_m);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(cells.size()); ++i) {
      for (std::size_t k = 0; k < 8; ++k) {
        std::int32_t& n = cells[static_cast<std::size_t>(i)].around[k];
        if (n != kNone && cells[static_cast<std::size_t>(n)].around[(k + 4) % 8] != i) n = kNone;
      }
    }
  }

  double cell_m_;
  Vector3d origin_m_;
  std::int32_t first_row_ = 0;
  std::vector<std::size_t> row_begin_;  ///< of each row from first_row_ on, and the end
};

/// Distance of every cell's middle to the border of its layer.
std::vector<double> distances_m(const Cells& grid) {
  const std::size_t n = grid.cells.size();
  std::vector<double> far(n, std::numeric_limits<double>::infinity());
  std::vector<std::int32_t> source(n, kNone);
  using Entry = std::pair<double, std::int32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (std::size_t i = 0; i < n; ++i) {
    const auto& around = grid.cells[i].around;
    if (around[0] != kNone && around[2] != kNone && around[4] != kNone && around[6] != kNone)
      continue;
    far[i] = 0.0;
    source[i] = static_cast<std::int32_t>(i);
    open.emplace(0.0, static_cast<std::int32_t>(i));
  }
  while (!open.empty()) {
    const auto [distance, i] = open.top();
    open.pop();
    if (distance > far[static_cast<std::size_t>(i)]) continue;
    const Cell& from = grid.cells[static_cast<std::size_t>(source[static_cast<std::size_t>(i)])];
    for (const std::int32_t j : grid.cells[static_cast<std::size_t>(i)].around) {
      if (j == kNone) continue;
      const Cell& to = grid.cells[static_cast<std::size_t>(j)];
      const double d = std::hypot(to.x - from.x, to.y - from.y);
      if (d >= far[static_cast<std::size_t>(j)]) continue;
      far[static_cast<std::size_t>(j)] = d;
      source[static_cast<std::size_t>(j)] = source[static_cast<std::size_t>(i)];
      open.emplace(d, j);
    }
  }
  for (double& d : far) d = (d + 0.5) * grid.cell_m();
  return far;
}

/// Cells of the medial axis: what is left when cells are taken away from the border inwards as long
/// as that changes neither what is connected nor an end.
std::vector<char> skeleton(const Cells& grid, const std::vector<double>& distance_m) {
  const std::size_t n = grid.cells.size();
  std::vector<char> left(n, 1);
  std::vector<std::int32_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = static_cast<std::int32_t>(i);
  const auto nearer_to_border = [&](std::int32_t a, std::int32_t b) {
    return std::pair(distance_m[static_cast<std::size_t>(a)], a) <
           std::pair(distance_m[static_cast<std::size_t>(b)], b);
  };
  std::sort(order.begin(), order.end(), nearer_to_border);
  std::vector<std::int32_t> next;
  std::vector<char> listed(n, 1);
  while (!order.empty()) {
    next.clear();
    for (const std::int32_t i : order) {
      listed[static_cast<std::size_t>(i)] = 0;
      if (!left[static_cast<std::size_t>(i)]) continue;
      const auto& around = grid.cells[static_cast<std::size_t>(i)].around;
      std::array<bool, 8> there{};
      int count = 0;
      for (std::size_t k = 0; k < 8; ++k) {
        there[k] = around[k] != kNone && left[static_cast<std::size_t>(around[k])];
        count += there[k] ? 1 : 0;
      }
      if (count <= 1) continue;  // an end
      int parts = 0;
      for (std::size_t k = 0; k < 8; k += 2)
        parts += !there[k] && (there[k + 1] || there[(k + 2) % 8]) ? 1 : 0;
      if (parts != 1) continue;
      left[static_cast<std::size_t>(i)] = 0;
      for (const std::int32_t j : around) {  // they may go now
        if (j == kNone || !left[static_cast<std::size_t>(j)] || listed[static_cast<std::size_t>(j)])
          continue;
        listed[static_cast<std::size_t>(j)] = 1;
        next.push_back(j);
      }
    }
    std::sort(next.begin(), next.end(), nearer_to_border);
    std::swap(order, next);
  }
  return left;
}

double length_of(const std::vector<Vector3d>& points_m) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < points_m.size(); ++i)
    length_m += (points_m[i] - points_m[i - 1]).head<2>().norm();
  return length_m;
}

/// Chains of skeleton cells between ends and forks.
RoadGraph chains(const Cells& grid, const std::vector<double>& distance_m,
                 const std::vector<char>& left) {
  RoadGraph graph;
  graph.cell_m = grid.cell_m();
  const auto seen_from = [&](std::int32_t i) {
    std::vector<std::int32_t> out;
    const auto& around = grid.cells[static_cast<std::size_t>(i)].around;
    const auto there = [&](std::size_t k) {
      return around[k % 8] != kNone && left[static_cast<std::size_t>(around[k % 8])];
    };
    for (std::size_t k = 0; k < 8; ++k) {
      if (!there(k)) continue;
      if (k % 2 == 1 && (there(k + 1) || there(k + 7)))
        continue;  // round the corner, not across it
      out.push_back(around[k]);
    }
    return out;
  };
  // Where layers meet, one cell may see another that does not see it: a chain that goes there would
  // go round for ever.
  const auto neighbours = [&](std::int32_t i) {
    std::vector<std::int32_t> out = seen_from(i);
    std::erase_if(out, [&](std::int32_t j) {
      const std::vector<std::int32_t> back = seen_from(j);
      return std::find(back.begin(), back.end(), i) == back.end();
    });
    return out;
  };
  const std::int32_t n = static_cast<std::int32_t>(grid.cells.size());
  std::unordered_map<std::int32_t, std::uint32_t> node_of;
  const auto add_node = [&](std::int32_t i) {
    node_of.emplace(i, static_cast<std::uint32_t>(graph.nodes.size()));
    graph.nodes.push_back({grid.point_m(i), distance_m[static_cast<std::size_t>(i)], {}});
  };
  std::vector<char> used(grid.cells.size(), 0);
  for (std::int32_t i = 0; i < n; ++i)
    if (left[static_cast<std::size_t>(i)] && neighbours(i).size() != 2) add_node(i);
  const auto follow = [&](std::int32_t from, std::int32_t next) {
    RoadBranch branch;
    std::vector<std::int32_t> path{from};
    std::int32_t before = from, here = next;
    while (true) {
      path.push_back(here);
      if (node_of.contains(here)) break;
      used[static_cast<std::size_t>(here)] = 1;
      const auto around = neighbours(here);
      const std::int32_t on = around[0] == before ? around[1] : around[0];
      before = here;
      here = on;
    }
    branch.from = node_of.at(from);
    branch.to = node_of.at(here);
    for (const std::int32_t i : path) {
      branch.points_m.push_back(grid.point_m(i));
      branch.half_width_m.push_back(distance_m[static_cast<std::size_t>(i)]);
    }
    branch.length_m = length_of(branch.points_m);
    return branch;
  };
  std::set<std::pair<std::int32_t, std::int32_t>> direct;
  std::vector<std::int32_t> starts;
  for (std::int32_t i = 0; i < n; ++i)
    if (node_of.contains(i)) starts.push_back(i);
  for (const std::int32_t i : starts) {
    for (const std::int32_t j : neighbours(i)) {
      if (node_of.contains(j)) {
        if (!direct.insert(std::minmax(i, j)).second) continue;
      } else if (used[static_cast<std::size_t>(j)]) {
        continue;
      }
      graph.branches.push_back(follow(i, j));
    }
  }
  // Rings without a fork.
  for (std::int32_t i = 0; i < n; ++i) {
    if (!left[static_cast<std::size_t>(i)] || used[static_cast<std::size_t>(i)] ||
        node_of.contains(i))
      continue;
    add_node(i);
    graph.branches.push_back(follow(i, neighbours(i)[0]));
  }
  return graph;
}

void list_branches(RoadGraph& graph) {
  for (RoadNode& node : graph.nodes) node.branches.clear();
  for (std::uint32_t b = 0; b < graph.branches.size(); ++b) {
    graph.nodes[graph.branches[b].from].branches.push_back(b);
    graph.nodes[graph.branches[b].to].branches.push_back(b);
  }
}

RoadBranch reversed(RoadBranch branch) {
  std::swap(branch.from, branch.to);
  std::reverse(branch.points_m.begin(), branch.points_m.end());
  std::reverse(branch.half_width_m.begin(), branch.half_width_m.end());
  return branch;
}

/// Branch a, then branch b, which begins where a ends.
RoadBranch joined(RoadBranch a, const RoadBranch& b) {
  a.points_m.insert(a.points_m.end(), b.points_m.begin() + 1, b.points_m.end());
  a.half_width_m.insert(a.half_width_m.end(), b.half_width_m.begin() + 1, b.half_width_m.end());
  a.to = b.to;
  a.length_m += b.length_m;
  return a;
}

/// Nodes that only join two branches go; so do nodes without branches.
void simplify(RoadGraph& graph) {
  list_branches(graph);
  std::vector<char> gone(graph.branches.size(), 0);
  for (std::uint32_t v = 0; v < graph.nodes.size(); ++v) {
    auto& at = graph.nodes[v].branches;
    if (at.size() != 2 || at[0] == at[1]) continue;
    RoadBranch a = graph.branches[at[0]], b = graph.branches[at[1]];
    if (a.to != v) a = reversed(std::move(a));
    if (b.from != v) b = reversed(std::move(b));
    const std::uint32_t into = at[0], out = at[1];
    graph.branches[into] = joined(std::move(a), b);
    gone[out] = 1;
    auto& far = graph.nodes[graph.branches[into].to].branches;
    std::replace(far.begin(), far.end(), out, into);
    at.clear();
  }
  std::vector<std::uint32_t> number(graph.nodes.size(), 0);
  std::vector<RoadNode> nodes;
  std::vector<RoadBranch> branches;
  for (std::uint32_t v = 0; v < graph.nodes.size(); ++v) {
    number[v] = static_cast<std::uint32_t>(nodes.size());
    if (!graph.nodes[v].branches.empty()) nodes.push_back(graph.nodes[v]);
  }
  for (std::uint32_t b = 0; b < graph.branches.size(); ++b) {
    if (gone[b]) continue;
    graph.branches[b].from = number[graph.branches[b].from];
    graph.branches[b].to = number[graph.branches[b].to];
    branches.push_back(std::move(graph.branches[b]));
  }
  graph.nodes = std::move(nodes);
  graph.branches = std::move(branches);
  list_branches(graph);
}

/// Leaves out dead ends no longer than the road is wide: they lead into corners.
void prune(RoadGraph& graph) {
  simplify(graph);
  while (true) {
    std::uint32_t shortest = 0;
    double most = 1.0;
    for (std::uint32_t b = 0; b < graph.branches.size(); ++b) {
      const RoadBranch& branch = graph.branches[b];
      const RoadNode &p = graph.nodes[branch.from], &q = graph.nodes[branch.to];
      if (branch.from == branch.to) continue;
      const bool p_end = p.branches.size() == 1, q_end = q.branches.size() == 1;
      if (p_end == q_end) continue;
      const double share = branch.length_m / (2.5 * (p_end ? q : p).half_width_m);
      if (share < most) most = share, shortest = b;
    }
    if (most >= 1.0) return;
    graph.branches.erase(graph.branches.begin() + shortest);
    simplify(graph);
  }
}

/// Forks whose discs hold each other's middle are one: a crossing is seen as two forks.
void merge_near_forks(RoadGraph& graph) {
  for (bool changed = true; changed;) {
    changed = false;
    for (std::uint32_t b = 0; b < graph.branches.size(); ++b) {
      const RoadBranch branch = graph.branches[b];
      if (branch.from == branch.to) continue;
      const RoadNode &p = graph.nodes[branch.from], &q = graph.nodes[branch.to];
      if (p.branches.size() < 3 || q.branches.size() < 3) continue;
      if (branch.length_m > std::max(3.0 * graph.cell_m, std::min(p.half_width_m, q.half_width_m)))
        continue;
      // Both ends move to the middle between them, so that ways through it stay smooth.
      const Vector3d middle = 0.5 * (p.point_m + q.point_m);
      const double half_m = std::max(p.half_width_m, q.half_width_m);
      for (RoadBranch& other : graph.branches) {
        for (const std::uint32_t node : {branch.from, branch.to}) {
          if (other.from == node)
            other.points_m.front() = middle, other.half_width_m.front() = half_m;
          if (other.to == node) other.points_m.back() = middle, other.half_width_m.back() = half_m;
        }
        if (other.from == branch.to) other.from = branch.from;
        if (other.to == branch.to) other.to = branch.from;
      }
      graph.nodes[branch.from].point_m = middle;
      graph.nodes[branch.from].half_width_m = half_m;
      graph.branches.erase(graph.branches.begin() + b);
      simplify(graph);
      changed = true;
      break;
    }
  }
}

/// The last stretch of a dead end, where the axis runs into a corner or the surface narrows, is
/// left out.
void trim_ends(RoadGraph& graph) {
  for (std::uint32_t b = 0; b < graph.branches.size(); ++b) {
    const double usual_m = 0.8 * base::median(graph.branches[b].half_width_m);
    const double most_m = 0.4 * graph.branches[b].length_m;
    for (const bool at_end : {false, true}) {
      RoadBranch& branch = graph.branches[b];
      if (graph.nodes[at_end ? branch.to : branch.from].branches.size() != 1) continue;
      if (!at_end) branch = reversed(std::move(branch));
      double gone_m = 0.0;
      while (branch.points_m.size() > 3 && gone_m < most_m &&
             (branch.half_width_m.back() < usual_m || gone_m < 1.5 * branch.half_width_m.back())) {
        const std::size_t last = branch.points_m.size() - 1;
        gone_m += (branch.points_m[last] - branch.points_m[last - 1]).head<2>().norm();
        branch.points_m.pop_back();
        branch.half_width_m.pop_back();
      }
      branch.length_m -= gone_m;
      RoadNode& node = graph.nodes[branch.to];
      node.point_m = branch.points_m.back();
      node.half_width_m = branch.half_width_m.back();
      if (!at_end) branch = reversed(std::move(branch));
    }
  }
}

/// Direction in which a branch leaves its node, over about the road's width.
Vector2d leaving(const RoadGraph& graph, std::uint32_t b, bool forwards) {
  const RoadBranch& branch = graph.branches[b];
  const std::size_t n = branch.points_m.size();
  const auto at = [&](std::size_t i) -> const Vector3d& {
    return branch.points_m[forwards ? i : n - 1 - i];
  };
  const double begin_m = graph.nodes[forwards ? branch.from : branch.to].half_width_m;
  std::size_t i = 0;
  double s_m = 0.0;
  while (i + 1 < n && s_m < begin_m) ++i, s_m += (at(i) - at(i - 1)).head<2>().norm();
  std::size_t j = i;
  while (j + 1 < n && s_m < 3.0 * begin_m) ++j, s_m += (at(j) - at(j - 1)).head<2>().norm();
  if (j == i) i = 0;
  return (at(j) - at(i)).head<2>().normalized();
}

/// Joins dead ends that face each other by branches without surface.
void add_gaps(const Cells& grid, RoadGraph& graph) {
  struct End {
    std::uint32_t node;
    Vector2d outwards;
  };
  std::vector<End> ends;
  for (std::uint32_t v = 0; v < graph.nodes.size(); ++v) {
    if (graph.nodes[v].branches.size() != 1) continue;
    const std::uint32_t b = graph.nodes[v].branches[0];
    ends.push_back({v, -leaving(graph, b, graph.branches[b].from == v)});
  }
  std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> pairs;
  for (std::uint32_t i = 0; i < ends.size(); ++i) {
    for (std::uint32_t j = i + 1; j < ends.size(); ++j) {
      const RoadNode &p = graph.nodes[ends[i].node], &q = graph.nodes[ends[j].node];
      const Vector2d across = (q.point_m - p.point_m).head<2>();
      const double length_m = across.norm();
      if (length_m <= 0.0 || length_m > kLongestGapWidths * (p.half_width_m + q.half_width_m))
        continue;
      if (std::min(ends[i].outwards.dot(across), -ends[j].outwards.dot(across)) <
          kFacing * length_m)
        continue;
      if (std::abs(p.point_m.z() - q.point_m.z()) > 0.5 * length_m) continue;
      if (std::max(p.half_width_m, q.half_width_m) > 2.0 * std::min(p.half_width_m, q.half_width_m))
        continue;
      pairs.emplace_back(length_m, i, j);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<char> used(ends.size(), 0);
  for (const auto& [length_m, i, j] : pairs) {
    if (used[i] || used[j]) continue;
    used[i] = used[j] = 1;
    const RoadNode &p = graph.nodes[ends[i].node], &q = graph.nodes[ends[j].node];
    RoadBranch gap;
    gap.from = ends[i].node;
    gap.to = ends[j].node;
    gap.length_m = length_m;
    gap.is_gap = true;
    const auto steps = static_cast<int>(std::ceil(length_m / grid.cell_m()));
    for (int k = 0; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      gap.points_m.push_back((1.0 - t) * p.point_m + t * q.point_m);
      gap.half_width_m.push_back((1.0 - t) * p.half_width_m + t * q.half_width_m);
      if (!grid.has_surface_at(gap.points_m.back())) gap.gap_m += length_m / (steps + 1);
    }
    graph.branches.push_back(std::move(gap));
  }
  list_branches(graph);
}

/// Half of a strip's cells lie farther from its border than a quarter of its width.
double typical_width_m(const std::vector<double>& distance_m) {
  return 4.0 * base::median(distance_m);
}

}  // namespace

RoadGraph road_graph(const Mesh& surface) {
  double area_m2 = 0.0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Vector3d a = surface.vertex(t, 1) - surface.vertex(t, 0),
                   b = surface.vertex(t, 2) - surface.vertex(t, 0);
    area_m2 += 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
  }
  if (!(area_m2 > 0.0)) return {};
  double cell_m = std::sqrt(area_m2 / kCells), headroom_m = 0.0;
  while (true) {
    Cells grid(surface, cell_m, headroom_m);
    const double width_m = typical_width_m(distances_m(grid));
    if (headroom_m == 0.0) {
      headroom_m = std::min(kHeadroom_m, 0.25 * width_m);
      continue;
    }
    const double wanted_m = std::max(width_m / kCellsAcross, std::sqrt(area_m2 / kMostCells));
    if (cell_m > 1.2 * wanted_m) {
      cell_m = wanted_m;
      continue;
    }
    grid.fill_holes(width_m * width_m);
    const std::vector<double> distance_m = distances_m(grid);
    RoadGraph graph = chains(grid, distance_m, skeleton(grid, distance_m));
    graph.area_m2 = static_cast<double>(grid.cells.size()) * cell_m * cell_m;
    prune(graph);
    merge_near_forks(graph);
    prune(graph);
    trim_ends(graph);
    add_gaps(grid, graph);
    return graph;
  }
}

namespace {

struct Step {
  std::uint32_t branch;
  bool forwards;
};

bool longer(const RoadWay& a, const RoadWay& b) { return a.length_m > b.length_m; }

RoadWay way_of(const RoadGraph& graph, const std::vector<Step>& steps, bool closed) {
  RoadWay way;
  way.closed = closed;
  for (const Step& step : steps) {
    const RoadBranch branch =
        step.forwards ? graph.branches[step.branch] : reversed(graph.branches[step.branch]);
    const std::size_t skip = way.points_m.empty() ? 0 : 1;
    way.points_m.insert(way.points_m.end(),
                        branch.points_m.begin() + static_cast<std::ptrdiff_t>(skip),
                        branch.points_m.end());
    way.half_width_m.insert(way.half_width_m.end(),
                            branch.half_width_m.begin() + static_cast<std::ptrdiff_t>(skip),
                            branch.half_width_m.end());
    way.branches.push_back(step.branch);
    way.length_m += branch.length_m;
    way.gap_m += branch.gap_m;
  }
  if (closed && way.points_m.size() > 1) way.points_m.pop_back(), way.half_width_m.pop_back();
  return way;
}

}  // namespace

std::vector<RoadWay> road_ways(const RoadGraph& graph, double longest_gap_m, std::size_t most) {
  constexpr std::size_t kMostSteps = 200'000;
  std::vector<RoadWay> found;
  std::size_t steps_taken = 0;
  std::vector<Step> path;
  std::vector<char> branch_used(graph.branches.size(), 0);
  std::vector<int> visits(graph.nodes.size(), 0);
  const auto end_of = [&](const Step& s) {
    return s.forwards ? graph.branches[s.branch].to : graph.branches[s.branch].from;
  };
  const auto cosine = [&](const Step& in, const Step& out) {
    return -leaving(graph, in.branch, !in.forwards).dot(leaving(graph, out.branch, out.forwards));
  };
  const auto keep = [&](bool closed) {
    found.push_back(way_of(graph, path, closed));
    if (found.size() <= 4 * most) return;
    std::stable_sort(found.begin(), found.end(), longer);
    found.resize(most);
  };
  const auto is_end = [&](std::uint32_t v) {  // gaps are the last branches of their nodes
    const std::vector<std::uint32_t>& at = graph.nodes[v].branches;
    return at.size() == 1 || (at.size() == 2 && graph.branches[at[1]].gap_m > longest_gap_m);
  };
  for (const bool closed : {true, false}) {
    // A cycle is found from its lowest branch, in that branch's own direction. A node is passed
    // once, a crossing also twice, straight on.
    const std::function<void(std::uint32_t, std::uint32_t)> go = [&](std::uint32_t lowest,
                                                                     std::uint32_t start) {
      if (++steps_taken > kMostSteps) return;
      const std::uint32_t here = end_of(path.back());
      const RoadNode& node = graph.nodes[here];
      // Where a ring has no fork its node is any place, perhaps in a hairpin.
      if (closed && here == start &&
          (path.size() == 1 || cosine(path.back(), path.front()) > kSharpest)) {
        keep(true);
        if (node.branches.size() < 4) return;
      }
      if (!closed && is_end(here)) {
        if (here > start) keep(false);
        return;
      }
      if (visits[here] > (node.branches.size() >= 4 ? 1 : 0)) return;
      ++visits[here];
      for (const std::uint32_t b : node.branches) {
        if ((closed && b < lowest) || branch_used[b] || graph.branches[b].gap_m > longest_gap_m)
          continue;
        const Step on{b, graph.branches[b].from == here};
        if (cosine(path.back(), on) < (visits[here] > 1 ? kStraightOn : kSharpest)) continue;
        branch_used[b] = 1;
        path.push_back(on);
        go(lowest, start);
        path.pop_back();
        branch_used[b] = 0;
      }
      --visits[here];
    };
    const auto begin = [&](const Step& first, std::uint32_t lowest, std::uint32_t start) {
      path.assign(1, first);
      branch_used[first.branch] = 1;
      ++visits[start];
      go(lowest, start);
      --visits[start];
      branch_used[first.branch] = 0;
    };
    if (closed) {
      for (std::uint32_t b = 0; b < graph.branches.size(); ++b)
        if (graph.branches[b].gap_m <= longest_gap_m) begin({b, true}, b, graph.branches[b].from);
    } else {
      for (std::uint32_t v = 0; v < graph.nodes.size(); ++v) {
        if (!is_end(v)) continue;
        const std::uint32_t b = graph.nodes[v].branches[0];
        begin({b, graph.branches[b].from == v}, 0, v);
      }
    }
    std::stable_sort(found.begin(), found.end(), longer);
    if (found.size() > most) found.resize(most);
    if (!found.empty()) break;
  }
  return found;
}

}  // namespace road
