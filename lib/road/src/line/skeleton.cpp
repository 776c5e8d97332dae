#include "skeleton.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <unordered_map>
#include <utility>

namespace road {
namespace {

using Eigen::Vector3d;

double plan_length_m(const std::vector<Vector3d>& points_m) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < points_m.size(); ++i)
    length_m += (points_m[i] - points_m[i - 1]).head<2>().norm();
  return length_m;
}

/// Cells of the axis beside cell i; round the corner, not across it.
std::vector<std::int32_t> seen_from(const Cells& grid, const std::vector<char>& left,
                                    std::int32_t i) {
  std::vector<std::int32_t> out;
  const auto& around = grid.cells[static_cast<std::size_t>(i)].around;
  const auto there = [&](std::size_t k) {
    return around[k % 8] != kNoCell && left[static_cast<std::size_t>(around[k % 8])];
  };
  for (std::size_t k = 0; k < 8; ++k) {
    if (!there(k)) continue;
    if (k % 2 == 1 && (there(k + 1) || there(k + 7))) continue;
    out.push_back(around[k]);
  }
  return out;
}

/// Those of them that see i, too: where layers meet, one cell may see another that does not see it,
/// and a chain that goes there would go round for ever.
std::vector<std::int32_t> neighbours_of(const Cells& grid, const std::vector<char>& left,
                                        std::int32_t i) {
  std::vector<std::int32_t> out = seen_from(grid, left, i);
  std::erase_if(out, [&](std::int32_t j) {
    const std::vector<std::int32_t> back = seen_from(grid, left, j);
    return std::find(back.begin(), back.end(), i) == back.end();
  });
  return out;
}

}  // namespace

std::vector<char> skeleton(const Cells& grid, const std::vector<double>& distance_m) {
  const std::size_t n = grid.cells.size();
  std::vector<char> left(n, 1);
  // Distances with their cells: nearer to the border first.
  std::vector<std::pair<double, std::int32_t>> order(n), next;
  for (std::size_t i = 0; i < n; ++i) order[i] = {distance_m[i], static_cast<std::int32_t>(i)};
  std::sort(order.begin(), order.end());
  std::vector<char> listed(n, 1);
  while (!order.empty()) {
    next.clear();
    for (const auto& [nearness_m, i] : order) {
      listed[static_cast<std::size_t>(i)] = 0;
      if (!left[static_cast<std::size_t>(i)]) continue;
      const auto& around = grid.cells[static_cast<std::size_t>(i)].around;
      std::array<bool, 8> there{};
      int count = 0;
      for (std::size_t k = 0; k < 8; ++k) {
        there[k] = around[k] != kNoCell && left[static_cast<std::size_t>(around[k])];
        count += there[k] ? 1 : 0;
      }
      if (count <= 1) continue;  // an end
      int parts = 0;
      for (std::size_t k = 0; k < 8; k += 2)
        parts += !there[k] && (there[k + 1] || there[(k + 2) % 8]) ? 1 : 0;
      if (parts != 1) continue;
      left[static_cast<std::size_t>(i)] = 0;
      for (const std::int32_t j : around) {  // they may go now
        if (j == kNoCell || !left[static_cast<std::size_t>(j)] ||
            listed[static_cast<std::size_t>(j)])
          continue;
        listed[static_cast<std::size_t>(j)] = 1;
        next.emplace_back(distance_m[static_cast<std::size_t>(j)], j);
      }
    }
    std::sort(next.begin(), next.end());
    std::swap(order, next);
  }
  return left;
}

RoadGraph chains(const Cells& grid, const std::vector<double>& distance_m,
                 const std::vector<char>& left) {
  RoadGraph graph;
  graph.cell_m = grid.cell_m();
  const auto neighbours = [&](std::int32_t i) { return neighbours_of(grid, left, i); };
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
    branch.length_m = plan_length_m(branch.points_m);
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

}  // namespace road
