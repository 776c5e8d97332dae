#include "surface_cells.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace road {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Of a cell: heights at one place that are this near are one surface.
constexpr double kOneLayer = 0.3;
// Of a cell: cells beside each other are joined up to this difference in height.
constexpr double kSteepestCell = 1.2;

bool before(const Cell& a, const Cell& b) {
  return std::tie(a.y, a.x, a.z_m) < std::tie(b.y, b.x, b.z_m);
}

/// A triangle over the middle of a cell.
struct Hit {
  std::int32_t y, x;
  double z_m;
  bool operator<(const Hit& other) const {
    return std::tie(y, x, z_m) < std::tie(other.y, other.x, other.z_m);
  }
};

void add_triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, double cell_m,
                  std::vector<Hit>& hits) {
  const double area = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  if (std::abs(area) < 1e-12) return;
  const auto first = [&](double v) {
    return static_cast<std::int32_t>(std::ceil(v / cell_m - 0.5 - 1e-9));
  };
  const auto last = [&](double v) {
    return static_cast<std::int32_t>(std::floor(v / cell_m - 0.5 + 1e-9));
  };
  const std::int32_t y0 = first(std::min({a.y(), b.y(), c.y()})),
                     y1 = last(std::max({a.y(), b.y(), c.y()}));
  const std::int32_t x0 = first(std::min({a.x(), b.x(), c.x()})),
                     x1 = last(std::max({a.x(), b.x(), c.x()}));
  for (std::int32_t y = y0; y <= y1; ++y) {
    for (std::int32_t x = x0; x <= x1; ++x) {
      const Vector2d p((x + 0.5) * cell_m, (y + 0.5) * cell_m);
      const auto weight = [&](const Vector3d& q, const Vector3d& r) {
        return ((q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x())) / area;
      };
      const double wa = weight(b, c), wb = weight(c, a), wc = weight(a, b);
      if (std::min({wa, wb, wc}) < -1e-9) continue;
      hits.push_back({y, x, wa * a.z() + wb * b.z() + wc * c.z()});
    }
  }
}

/// Cells by the squares of their distances, of equal ones the lowest first. Most squares are small:
/// each of these has a list of its own, sorted when it is reached.
class NearestFirst {
 public:
  using Entry = std::pair<std::int64_t, std::int32_t>;

  void push(std::int64_t square, std::int32_t cell) {
    if (square < at_ || square >= static_cast<std::int64_t>(lists_.size()) ||
        (square == at_ && is_sorted_))
      others_.emplace(square, cell);
    else
      lists_[static_cast<std::size_t>(square)].push_back(cell);
  }
  std::optional<Entry> pop() {
    while (at_ < static_cast<std::int64_t>(lists_.size())) {
      std::vector<std::int32_t>& list = lists_[static_cast<std::size_t>(at_)];
      if (!is_sorted_) std::sort(list.begin(), list.end(), std::greater<>());
      is_sorted_ = true;
      if (!others_.empty() &&
          (list.empty() ? others_.top().first <= at_ : others_.top() < Entry(at_, list.back())))
        break;
      if (!list.empty()) {
        const Entry next(at_, list.back());
        list.pop_back();
        return next;
      }
      is_sorted_ = false;
      ++at_;
    }
    if (others_.empty()) return {};
    const Entry next = others_.top();
    others_.pop();
    return next;
  }

 private:
  std::vector<std::vector<std::int32_t>> lists_{1 << 14};
  std::int64_t at_ = 0;     ///< the list that is taken from
  bool is_sorted_ = false;  ///< it is
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> others_;
};

}  // namespace

Cells::Cells(const Mesh& mesh, double cell_m, double headroom_m)
    : cell_m_(cell_m), origin_m_(mesh.origin_m) {
  std::vector<Hit> hits;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    add_triangle(mesh.vertex(t, 0), mesh.vertex(t, 1), mesh.vertex(t, 2), cell_m, hits);
  std::sort(hits.begin(), hits.end());
  for (const Hit& hit : hits) {
    const bool above_last = !cells.empty() && cells.back().x == hit.x && cells.back().y == hit.y;
    // One surface drawn twice, or one that no car fits on under the next: the upper one counts.
    if (above_last && hit.z_m - cells.back().z_m < std::max(kOneLayer * cell_m, headroom_m))
      cells.back().z_m = hit.z_m;
    else
      cells.push_back({hit.x, hit.y, hit.z_m, {}});
  }
  index_rows();
  link();
}

void Cells::fill_holes(double largest_m2) {
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
      if (border.around[k] != kNoCell) continue;
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
          if (there != kNoCell) {
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

Vector3d Cells::point_m(std::int32_t i) const {
  const Cell& c = cells[static_cast<std::size_t>(i)];
  return origin_m_ + Vector3d((c.x + 0.5) * cell_m_, (c.y + 0.5) * cell_m_, c.z_m);
}

bool Cells::has_surface_at(const Vector3d& map_m) const {
  const Vector3d p = map_m - origin_m_;
  return find(static_cast<std::int32_t>(std::floor(p.x() / cell_m_)),
              static_cast<std::int32_t>(std::floor(p.y() / cell_m_)), p.z()) != kNoCell;
}

void Cells::index_rows() {
  row_begin_.clear();
  if (cells.empty()) return;
  first_row_ = cells.front().y;
  row_begin_.assign(static_cast<std::size_t>(cells.back().y - first_row_) + 2, cells.size());
  for (std::size_t i = cells.size(); i-- > 0;)
    row_begin_[static_cast<std::size_t>(cells[i].y - first_row_)] = i;
  for (std::size_t r = row_begin_.size() - 1; r-- > 0;)
    row_begin_[r] = std::min(row_begin_[r], row_begin_[r + 1]);
}

std::pair<std::size_t, std::size_t> Cells::row(std::int64_t y) const {
  const std::int64_t r = y - first_row_;
  if (r < 0 || r + 1 >= static_cast<std::int64_t>(row_begin_.size())) return {0, 0};
  return {row_begin_[static_cast<std::size_t>(r)], row_begin_[static_cast<std::size_t>(r) + 1]};
}

std::int32_t Cells::nearest(std::size_t at, std::size_t end, std::int32_t x, double z_m) const {
  std::int32_t best = kNoCell;
  double best_m = kSteepestCell * cell_m_;
  for (; at != end && cells[at].x == x; ++at) {
    if (std::abs(cells[at].z_m - z_m) >= best_m) continue;
    best_m = std::abs(cells[at].z_m - z_m);
    best = static_cast<std::int32_t>(at);
  }
  return best;
}

std::int32_t Cells::find(std::int32_t x, std::int32_t y, double z_m) const {
  const auto [begin, end] = row(y);
  const auto at = std::lower_bound(cells.begin() + static_cast<std::ptrdiff_t>(begin),
                                   cells.begin() + static_cast<std::ptrdiff_t>(end), x,
                                   [](const Cell& c, std::int32_t wanted) { return c.x < wanted; });
  return nearest(static_cast<std::size_t>(at - cells.begin()), end, x, z_m);
}

void Cells::link() {
  // Cells lie in rows and in these from west to east: in each row beside, what lies beside the next
  // cell is not behind what lay beside the last.
  std::array<std::pair<std::size_t, std::size_t>, 3> beside;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Cell& c = cells[i];
    if (i == 0 || cells[i - 1].y != c.y)
      for (std::size_t k = 0; k < 3; ++k) beside[k] = row(c.y + static_cast<std::int64_t>(k) - 1);
    for (auto& [at, end] : beside)
      while (at != end && cells[at].x < c.x - 1) ++at;
    for (std::size_t k = 0; k < 8; ++k) {
      auto [at, end] = beside[kAround[k][1] < 0 ? 0 : (kAround[k][1] == 0 ? 1 : 2)];
      while (at != end && cells[at].x < c.x + kAround[k][0]) ++at;
      c.around[k] = nearest(at, end, c.x + kAround[k][0], c.z_m);
    }
  }
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(cells.size()); ++i) {
    for (std::size_t k = 0; k < 8; ++k) {
      std::int32_t& n = cells[static_cast<std::size_t>(i)].around[k];
      if (n != kNoCell && cells[static_cast<std::size_t>(n)].around[(k + 4) % 8] != i) n = kNoCell;
    }
  }
}

std::vector<double> distances_m(const Cells& grid) {
  const std::size_t n = grid.cells.size();
  // Squares of distances in cells are whole numbers.
  constexpr auto kFar = std::numeric_limits<std::int64_t>::max();
  std::vector<std::int64_t> far(n, kFar);
  std::vector<std::int32_t> source(n, kNoCell);
  NearestFirst open;
  for (std::size_t i = 0; i < n; ++i) {
    const auto& around = grid.cells[i].around;
    if (around[0] != kNoCell && around[2] != kNoCell && around[4] != kNoCell &&
        around[6] != kNoCell)
      continue;
    far[i] = 0;
    source[i] = static_cast<std::int32_t>(i);
    open.push(0, static_cast<std::int32_t>(i));
  }
  while (const auto next = open.pop()) {
    const auto i = static_cast<std::size_t>(next->second);
    if (next->first > far[i]) continue;
    const Cell& from = grid.cells[static_cast<std::size_t>(source[i])];
    for (const std::int32_t k : grid.cells[i].around) {
      if (k == kNoCell) continue;
      const auto j = static_cast<std::size_t>(k);
      const std::int64_t x = grid.cells[j].x - from.x, y = grid.cells[j].y - from.y;
      if (x * x + y * y >= far[j]) continue;
      far[j] = x * x + y * y;
      source[j] = source[i];
      open.push(far[j], k);
    }
  }
  std::vector<double> out(n, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < n; ++i)
    if (far[i] != kFar) out[i] = (std::sqrt(static_cast<double>(far[i])) + 0.5) * grid.cell_m();
  return out;
}

}  // namespace road
