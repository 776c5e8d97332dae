// Ways through the graph of a surface.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "road/road_graph.h"
#include "tidy_graph.h"

namespace road {
namespace {

constexpr double kSharpest = -0.35;  // cosine of the sharpest turn at a fork, 110 degrees
constexpr double kStraightOn = 0.7;  // over a crossing

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
