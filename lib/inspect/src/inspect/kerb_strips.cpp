#include "inspect/kerb_strips.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/statistics.h"

namespace road {

namespace {

constexpr double kBaseLength_m = 1.5, kLook_m = 0.4, kRise_m = 0.008, kReturn = 0.3;
constexpr double kLongestGap_m = 3.0;  // rows of one kerb that roughness hides

/// Heights outwards from the middle of one row on one side.
struct Half {
  std::vector<double> v, z;
};

Half half_of_row(const HeightMap& map, std::size_t row, std::size_t middle, bool left) {
  Half half;
  for (std::size_t k = 0;; ++k) {
    if (left ? middle + k >= map.columns() : k > middle) break;
    const std::size_t j = left ? middle + k : middle - k;
    const auto z = static_cast<double>(map.at(row, j));
    if (std::isnan(z)) break;
    half.v.push_back(std::abs(map.v_m[j] - map.v_m[middle]));
    half.z.push_back(z);
  }
  return half;
}

std::optional<KerbRow> kerb_of_half(const Half& half, const KerbStripOptions& options) {
  const std::size_t n = half.v.size();
  std::size_t base = 0, look = 0;
  for (std::size_t j = 0; j < n; ++j) {
    while (half.v[j] - half.v[base] > kBaseLength_m) ++base;
    if (half.v[j] < kBaseLength_m) continue;
    while (look + 1 < n && half.v[look] - half.v[j] < kLook_m) ++look;
    if (look <= j) break;
    // Cheap test with the two ends of the base before the exact line.
    const double chord = (half.z[j] - half.z[base]) / (half.v[j] - half.v[base]);
    if (half.z[look] - half.z[j] - chord * (half.v[look] - half.v[j]) < 0.5 * kRise_m) continue;
    double sv = 0, sz = 0, svv = 0, svz = 0, count = 0;
    for (std::size_t k = base; k <= j; ++k) {
      const double v = half.v[k] - half.v[j];
      sv += v, sz += half.z[k], svv += v * v, svz += v * half.z[k], count += 1;
    }
    const double spread = count * svv - sv * sv;
    if (!(spread > 0.0)) continue;
    const double slope = (count * svz - sv * sz) / spread, level = (sz - slope * sv) / count;
    const auto over = [&](std::size_t k) {
      return half.z[k] - level - slope * (half.v[k] - half.v[j]);
    };
    double square = 0.0;
    for (std::size_t k = base; k <= j; ++k) square += over(k) * over(k);
    const double scatter = std::sqrt(square / count);
    if (over(look) < std::max(kRise_m, 3.0 * scatter) ||
        std::abs(over(j)) > std::max(0.5 * kRise_m, scatter))
      continue;
    // Its top, its end, and then where the rise to that top begins: a wave of the road may lie
    // before it.
    KerbRow kerb;
    kerb.v_begin_m = half.v[j];
    const double enough = std::max(options.min_height_m, 5.0 * scatter);
    std::size_t k = j + 1;
    double lowest_m = 0.0;  // behind the top
    for (; k < n && half.v[k] - half.v[j] <= 2.0 * options.max_width_m; ++k) {
      const double height = over(k);
      if (height > kerb.height_m) {
        // A rise behind a fall is run-off: the kerb ended between them.
        if (kerb.height_m >= enough &&
            lowest_m < kerb.height_m - std::max(kRise_m, (1.0 - 2.0 * kReturn) * kerb.height_m))
          break;
        kerb.height_m = lowest_m = height;
      }
      if (height < lowest_m || height == kerb.height_m) kerb.v_end_m = half.v[k];
      lowest_m = std::min(lowest_m, height);
      if (kerb.height_m >= enough && height < kReturn * kerb.height_m) break;
      if (kerb.height_m >= enough && height > lowest_m + 0.005 &&
          lowest_m < kerb.height_m - std::max(kRise_m, (1.0 - 2.0 * kReturn) * kerb.height_m))
        break;
    }
    if (kerb.height_m < enough) continue;
    for (std::size_t q = j; q < k && over(q) < 0.1 * kerb.height_m; ++q) kerb.v_begin_m = half.v[q];
    if (kerb.v_end_m - kerb.v_begin_m > options.max_width_m || kerb.height_m > options.max_height_m)
      return std::nullopt;
    return kerb;
  }
  return std::nullopt;
}

/// Whether two rows may hold the same kerb: it moves across by less than its width between them.
bool overlap(const KerbRow& a, const KerbRow& b) {
  const auto [a_low, a_high] = std::minmax(a.v_begin_m, a.v_end_m);
  const auto [b_low, b_high] = std::minmax(b.v_begin_m, b.v_end_m);
  return a_low < b_high + 0.2 && b_low < a_high + 0.2;
}

/// The inner edge moves by no more than about a column from row to row, in most of them. Strips
/// above 40 mm, more than roughness of class C makes, may move more: roughness hides where they
/// begin.
bool is_steady(const HeightMap& map, const std::vector<KerbRow>& rows) {
  std::vector<double> moves, heights;
  for (const KerbRow& row : rows) heights.push_back(row.height_m);
  const double limit_m = base::quantile(heights, 0.5) > 0.04 ? 0.4 : 0.11;
  for (std::size_t k = 1; k < rows.size(); ++k)
    moves.push_back(std::abs(rows[k].v_begin_m - rows[k - 1].v_begin_m));
  const double column_m =
      (map.v_m.back() - map.v_m.front()) / static_cast<double>(map.columns() - 1);
  return !moves.empty() && base::quantile(moves, 0.5) <= std::max(limit_m, 1.01 * column_m);
}

/// The column of the reference line, or the middle of the road where that has no height.
std::size_t middle_column(const HeightMap& map, std::size_t i) {
  std::size_t middle = static_cast<std::size_t>(
      std::lower_bound(map.v_m.begin(), map.v_m.end(), 0.0) - map.v_m.begin());
  middle = std::min(middle, map.columns() - 1);
  if (std::isnan(map.at(i, middle))) {
    std::size_t first = 0, last = map.columns() - 1;
    while (first < last && std::isnan(map.at(i, first))) ++first;
    while (last > first && std::isnan(map.at(i, last))) --last;
    middle = (first + last) / 2;
  }
  return middle;
}

/// What the rows of a strip have in common.
KerbStrip strip_of(const HeightMap& map, const std::vector<KerbRow>& rows, bool left) {
  KerbStrip strip;
  std::vector<double> begin, end, height, width;
  for (const KerbRow& row : rows) {
    begin.push_back(row.v_begin_m);
    end.push_back(row.v_end_m);
    height.push_back(row.height_m);
    width.push_back(std::abs(row.v_end_m - row.v_begin_m));
  }
  strip.u_begin_m = map.u_of(rows.front().row);
  strip.u_end_m = map.u_of(rows.back().row);
  strip.left = left;
  strip.v_begin_m = base::quantile(begin, 0.5);
  strip.v_end_m = base::quantile(end, 0.5);
  strip.height_m = base::quantile(height, 0.9);
  strip.width_m = base::quantile(width, 0.5);
  const auto nearest =
      std::min_element(rows.begin(), rows.end(), [&](const KerbRow& a, const KerbRow& b) {
        return std::abs(a.height_m - strip.height_m) < std::abs(b.height_m - strip.height_m);
      });
  strip.u_of_profile_m = map.u_of(nearest->row);
  return strip;
}

}  // namespace

KerbStrips find_kerb_strips(const HeightMap& map, const KerbStripOptions& options) {
  const auto stride = std::max<std::size_t>(
      1, static_cast<std::size_t>(options.row_step_m / map.line.u_step_m + 0.5));
  const double row_step_m = static_cast<double>(stride) * map.line.u_step_m;
  std::vector<std::vector<KerbRow>> done;
  std::vector<bool> is_left;
  for (const bool left : {false, true}) {
    std::vector<std::vector<KerbRow>> open;
    const auto accept = [&](std::vector<KerbRow> piece) {
      if (piece.empty()) return;
      const std::size_t rows = (piece.back().row - piece.front().row) / stride + 1;
      // The edge of a kerb is a line; rises of a rough road begin elsewhere in every row and leave
      // gaps.
      if (static_cast<double>(rows) * row_step_m < options.min_length_m ||
          3 * piece.size() < 2 * rows || !is_steady(map, piece))
        return;
      done.push_back(std::move(piece));
      is_left.push_back(left);
    };
    const auto close = [&](std::size_t k) {
      // Waves of the road before and behind a kerb may have been linked to it: they are lower.
      std::vector<double> heights;
      for (const KerbRow& row : open[k]) heights.push_back(row.height_m);
      const double low_m = 0.35 * base::quantile(heights, 0.9);
      std::vector<KerbRow> piece;
      for (const KerbRow& row : open[k]) {
        if (row.height_m < low_m) continue;
        if (!piece.empty() &&
            static_cast<double>(row.row - piece.back().row) * map.line.u_step_m > kLongestGap_m) {
          accept(std::move(piece));
          piece.clear();
        }
        piece.push_back(row);
      }
      accept(std::move(piece));
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(k));
    };
    for (std::size_t i = 0; i < map.rows(); i += stride) {
      const std::size_t middle = middle_column(map, i);
      std::optional<KerbRow> kerb;
      if (!std::isnan(map.at(i, middle)))
        kerb = kerb_of_half(half_of_row(map, i, middle, left), options);
      if (kerb) {
        kerb->row = i;
        const double sign = left ? 1.0 : -1.0;
        kerb->v_begin_m = map.v_m[middle] + sign * kerb->v_begin_m;
        kerb->v_end_m = map.v_m[middle] + sign * kerb->v_end_m;
        std::size_t k = 0;
        while (k < open.size() && !overlap(open[k].back(), *kerb)) ++k;
        if (k == open.size()) open.emplace_back();
        open[k].push_back(*kerb);
      }
      for (std::size_t k = open.size(); k-- > 0;) {
        if (static_cast<double>(i - open[k].back().row) * map.line.u_step_m > kLongestGap_m)
          close(k);
      }
    }
    while (!open.empty()) close(open.size() - 1);
  }

  KerbStrips result;
  std::vector<std::size_t> order(done.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return done[a].front().row != done[b].front().row ? done[a].front().row < done[b].front().row
                                                      : a < b;
  });
  for (const std::size_t k : order) {
    result.strips.push_back(strip_of(map, done[k], is_left[k]));
    result.rows.push_back(std::move(done[k]));
  }
  return result;
}

}  // namespace road
