#include "tidy_graph.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/statistics.h"

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

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

}  // namespace

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

}  // namespace road
