#include "mesh_topology.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

namespace road {

DisjointSets::DisjointSets(std::size_t count) : parent_(count) {
  std::iota(parent_.begin(), parent_.end(), 0u);
}

std::uint32_t DisjointSets::find(std::uint32_t item) {
  while (parent_[item] != item) {
    parent_[item] = parent_[parent_[item]];
    item = parent_[item];
  }
  return item;
}

void DisjointSets::join(std::uint32_t a, std::uint32_t b) {
  a = find(a);
  b = find(b);
  if (a != b) parent_[std::max(a, b)] = std::min(a, b);
}

std::vector<std::uint32_t> weld(const std::vector<Eigen::Vector3d>& vertices_m, double horizontal_m,
                                double vertical_m) {
  // Cells much larger than the tolerance: nearly every vertex needs to look into one cell only.
  const double cell_m = std::max(16.0 * std::max(horizontal_m, vertical_m), 1e-6);
  using Cell = std::array<std::int64_t, 3>;
  std::vector<std::uint32_t> target(vertices_m.size());
  std::vector<std::uint32_t> before(vertices_m.size());  // the one kept before it in its cell
  const auto cell_of = [cell_m](double value) {
    return static_cast<std::int64_t>(std::floor(value / cell_m));
  };
  // The vertex kept last in each cell: a hash table, half full at most.
  std::vector<std::uint32_t> cells(std::bit_ceil(2 * vertices_m.size() + 2), kNoIndex);
  const int shift = 64 - std::countr_zero(cells.size());
  const auto last_in = [&](const Cell& cell) -> std::uint32_t& {
    std::uint64_t hash = 0;
    for (const std::int64_t c : cell)
      hash = (hash ^ static_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15u;
    for (std::size_t slot = hash >> shift;; slot = (slot + 1) & (cells.size() - 1)) {
      if (cells[slot] == kNoIndex) return cells[slot];
      const Eigen::Vector3d& v = vertices_m[cells[slot]];
      if (cell == Cell{cell_of(v.x()), cell_of(v.y()), cell_of(v.z())}) return cells[slot];
    }
  };
  const Eigen::Vector3d reach(horizontal_m, horizontal_m, vertical_m);
  for (std::uint32_t i = 0; i < vertices_m.size(); ++i) {
    const Eigen::Vector3d& v = vertices_m[i];
    std::uint32_t found = kNoIndex;
    Cell low, high;
    for (int axis = 0; axis < 3; ++axis) {
      low[static_cast<std::size_t>(axis)] = cell_of(v[axis] - reach[axis]);
      high[static_cast<std::size_t>(axis)] = cell_of(v[axis] + reach[axis]);
    }
    const auto look_into = [&](std::uint32_t last) {
      for (std::uint32_t other = last; other != kNoIndex; other = before[other]) {
        const Eigen::Vector3d d = vertices_m[other] - v;
        if (other < found && d.head<2>().norm() <= horizontal_m && std::abs(d.z()) <= vertical_m)
          found = other;
      }
    };
    std::uint32_t& own = last_in({cell_of(v.x()), cell_of(v.y()), cell_of(v.z())});
    if (low == high)
      look_into(own);
    else
      for (std::int64_t x = low[0]; x <= high[0]; ++x)
        for (std::int64_t y = low[1]; y <= high[1]; ++y)
          for (std::int64_t z = low[2]; z <= high[2]; ++z) look_into(last_in({x, y, z}));
    target[i] = found == kNoIndex ? i : found;
    if (found == kNoIndex) before[i] = std::exchange(own, i);
  }
  return target;
}

std::vector<EdgeUse> edge_uses(const std::vector<Triangle>& triangles) {
  // By the lower vertex first: what is left to sort is small.
  std::vector<std::size_t> first(1, 0);
  const auto each = [&](const auto& use) {
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
      for (std::uint8_t c = 0; c < 3; ++c) {
        const std::uint32_t a = triangles[t][c], b = triangles[t][(c + 1u) % 3u];
        use(std::min(a, b), EdgeUse{undirected(a, b), t, c});
      }
  };
  each([&](std::uint32_t low, const EdgeUse&) {
    if (first.size() < low + 2u) first.resize(low + 2u, 0);
    ++first[low + 1];
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<EdgeUse> uses(first.back());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  each([&](std::uint32_t low, const EdgeUse& use) { uses[next[low]++] = use; });
  for (std::size_t v = 0; v + 1 < first.size(); ++v)
    std::sort(uses.begin() + static_cast<std::ptrdiff_t>(first[v]),
              uses.begin() + static_cast<std::ptrdiff_t>(first[v + 1]),
              [](const EdgeUse& l, const EdgeUse& r) {
                return l.key != r.key ? l.key < r.key : l.t < r.t;
              });
  return uses;
}

Components components(const std::vector<Triangle>& triangles) {
  DisjointSets sets(triangles.size());
  std::vector<std::array<std::uint32_t, 2>> shared;  // the first triangle and its corner
  const std::vector<EdgeUse> uses = edge_uses(triangles);
  for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
    while (end < uses.size() && uses[end].key == uses[i].key) sets.join(uses[i].t, uses[end++].t);
    if (end - i > 2) shared.push_back({uses[i].t, uses[i].c});
  }
  std::sort(shared.begin(), shared.end());

  Components out;
  for (const auto& [t, corner] : shared) out.at_non_manifold_edges.push_back(t);
  out.of_triangle.reserve(triangles.size());
  std::vector<std::uint32_t> number(triangles.size(), kNoIndex);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    std::uint32_t& own = number[sets.find(t)];
    if (own == kNoIndex) own = out.count++;
    out.of_triangle.push_back(own);
  }
  return out;
}

std::size_t count_borders(const std::vector<Triangle>& triangles) {
  std::uint32_t vertices = 0;
  for (const Triangle& t : triangles) vertices = std::max({vertices, t[0] + 1, t[1] + 1, t[2] + 1});
  DisjointSets sets(vertices);
  std::vector<std::uint32_t> on_border;
  const std::vector<EdgeUse> uses = edge_uses(triangles);
  for (std::size_t i = 0; i < uses.size(); ++i) {
    const bool shared = (i > 0 && uses[i - 1].key == uses[i].key) ||
                        (i + 1 < uses.size() && uses[i + 1].key == uses[i].key);
    if (shared) continue;
    const auto a = static_cast<std::uint32_t>(uses[i].key >> 32);
    const auto b = static_cast<std::uint32_t>(uses[i].key & 0xffffffffu);
    sets.join(a, b);
    on_border.push_back(a);
  }
  for (std::uint32_t& vertex : on_border) vertex = sets.find(vertex);
  std::sort(on_border.begin(), on_border.end());
  return static_cast<std::size_t>(std::unique(on_border.begin(), on_border.end()) -
                                  on_border.begin());
}

std::vector<std::vector<std::uint32_t>> border_loops(
    const std::vector<Triangle>& triangles, const std::vector<Eigen::Vector3d>& vertices_m) {
  struct Out {
    std::uint32_t from, to;
    bool used = false;
  };
  std::vector<Out> edges;
  const std::vector<EdgeUse> uses = edge_uses(triangles);
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t end = i + 1;
    while (end < uses.size() && uses[end].key == uses[i].key) ++end;
    if (end - i == 1) {
      const Triangle& t = triangles[uses[i].t];
      edges.push_back({t[uses[i].c], t[(uses[i].c + 1u) % 3u]});
    }
    i = end;
  }
  std::sort(edges.begin(), edges.end(), [](const Out& l, const Out& r) {
    return l.from != r.from ? l.from < r.from : l.to < r.to;
  });
  const auto first_from = [&](std::uint32_t vertex) {
    return std::lower_bound(edges.begin(), edges.end(), vertex,
                            [](const Out& edge, std::uint32_t v) { return edge.from < v; });
  };
  std::vector<std::vector<std::uint32_t>> loops;
  for (Out& start : edges) {
    if (start.used) continue;
    std::vector<std::uint32_t> loop;
    Out* edge = &start;
    while (edge != nullptr && !edge->used) {
      edge->used = true;
      loop.push_back(edge->from);
      // The surface lies on the left: the next border edge of the same surface part is the one
      // farthest to the left when several leave a pinch vertex.
      const Eigen::Vector2d in = (vertices_m[edge->to] - vertices_m[edge->from]).head<2>();
      Out* next = nullptr;
      double best = -10.0;
      for (auto it = first_from(edge->to); it != edges.end() && it->from == edge->to; ++it) {
        if (it->used) continue;
        const Eigen::Vector2d out = (vertices_m[it->to] - vertices_m[it->from]).head<2>();
        const double turn = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
        if (turn > best) {
          best = turn;
          next = &*it;
        }
      }
      edge = next;
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

}  // namespace road
