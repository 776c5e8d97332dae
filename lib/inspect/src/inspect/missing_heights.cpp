#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "defects.h"

namespace road {
namespace {

struct RowRun {
  std::size_t begin, end;  ///< end is one past the last
};

/// Rows that lose at least half of the road's width at once and get it back at once, or all of it.
std::vector<RowRun> find_bare_rows(const std::vector<RowExtent>& extents, double u_step_m) {
  const std::size_t rows = extents.size();
  const auto reach = std::max<std::size_t>(2, static_cast<std::size_t>(10.0 / u_step_m));
  const auto largest_between = [&](std::size_t begin, std::size_t end) {
    std::size_t largest = 0;
    for (std::size_t i = begin; i < end; ++i) largest = std::max(largest, extents[i].count);
    return largest;
  };
  std::vector<RowRun> runs;
  for (std::size_t i = 0; i < rows;) {
    const std::size_t before = i > 0 ? extents[i - 1].count : 0;
    if (extents[i].empty() || 2 * extents[i].count < before) {
      std::size_t end = i + 1;
      while (end < rows && (extents[end].empty() || 2 * extents[end].count < before) &&
             (end - i < reach || extents[end].empty()))
        ++end;
      const std::size_t behind = end < rows ? largest_between(end, std::min(rows, end + 2)) : 0;
      const std::size_t inside = largest_between(i, end);
      if (inside == 0 || (2 * inside < before && 2 * inside < behind)) {
        runs.push_back({i, end});
        i = end;
        continue;
      }
    }
    ++i;
  }
  return runs;
}

/// How far apart the ends of the road are at rows without any: a gap that runs aslant is longer in
/// each column than its bare rows.
double gap_m(const HeightMap& road, const RowRun& run) {
  const auto most = static_cast<std::size_t>(30.0 / road.line.u_step_m);
  std::size_t longest = run.end - run.begin;
  for (std::size_t j = 0; j < road.columns(); ++j) {
    std::size_t begin = run.begin, end = run.end;
    while (begin > 0 && end - begin <= most && std::isnan(road.at(begin - 1, j))) --begin;
    while (end < road.rows() && end - begin <= most && std::isnan(road.at(end, j))) ++end;
    if (end - begin <= most) longest = std::max(longest, end - begin);
  }
  return static_cast<double>(longest) * road.line.u_step_m;
}

/// An open road may end aslant to its rows.
bool is_end(const HeightMap& map, std::size_t first, std::size_t last,
            const FindingOptions& options) {
  constexpr double kEnd_m = 1.0;
  return !options.closed && (first == 0 || last + 1 == map.rows()) &&
         static_cast<double>(last - first + 1) * map.line.u_step_m <= kEnd_m;
}

}  // namespace

std::vector<Finding> find_missing(const HeightMap& map, const HeightMap& road,
                                  const FindingOptions& options, std::vector<Finding>& stripes) {
  const std::size_t rows = map.rows(), columns = map.columns();
  const std::vector<RowExtent> extents = row_extents(map), of_road = row_extents(road);
  std::vector<std::uint8_t> bare(rows, 0);
  for (const RowRun& run : find_bare_rows(of_road, map.line.u_step_m)) {
    std::fill(bare.begin() + static_cast<std::ptrdiff_t>(run.begin),
              bare.begin() + static_cast<std::ptrdiff_t>(run.end), 1);
    const double length_m = static_cast<double>(run.end - run.begin) * map.line.u_step_m;
    const auto first = of_road.begin() + static_cast<std::ptrdiff_t>(run.begin),
               end = of_road.begin() + static_cast<std::ptrdiff_t>(run.end);
    const bool is_gap = std::any_of(first, end, [](const RowExtent& e) { return e.empty(); });
    stripes.push_back(finding(
        map, "nan_stripe", map.u_of(run.begin), map.u_of(run.end - 1), length_m, "m",
        Severity::error,
        fmt::format("No road over {:.2f} m from u = {:.1f} m: {}", length_m, map.u_of(run.begin),
                    is_gap ? fmt::format("all of the width is missing; where the mesh has a gap, "
                                         "--bridge-gap-m {:.0f} closes it",
                                         std::ceil(gap_m(road, run)) + 1.0)
                           : "more than half of the width is missing")));
  }

  // Nodes without height between the outermost heights of their row, joined to pieces.
  std::vector<Finding> holes;
  std::vector<std::uint8_t> seen;
  const auto is_hole = [&](std::size_t i, std::size_t j) {
    return !bare[i] && std::isnan(map.at(i, j)) &&
           ((j > extents[i].first && j < extents[i].last) ||
            (!options.edges.empty() && j > 0 && j + 1 < columns &&
             options.edges.has(i, map.v_m[j])));
  };
  std::vector<std::pair<std::size_t, std::size_t>> stack;
  for (std::size_t i = 0; i < rows; ++i) {
    const RowExtent& extent = extents[i];
    if (bare[i] || extent.empty()) continue;
    if (options.edges.empty() && extent.count == extent.last - extent.first + 1) continue;
    for (std::size_t j = 0; j < columns; ++j) {
      if (!is_hole(i, j)) continue;
      if (seen.empty()) seen.resize(rows * columns, 0);
      if (seen[i * columns + j]) continue;
      std::size_t nodes = 0, i_low = i, i_high = i, j_low = j, j_high = j;
      stack.assign(1, {i, j});
      seen[i * columns + j] = 1;
      while (!stack.empty()) {
        const auto [a, b] = stack.back();
        stack.pop_back();
        ++nodes;
        i_low = std::min(i_low, a), i_high = std::max(i_high, a);
        j_low = std::min(j_low, b), j_high = std::max(j_high, b);
        for (std::size_t p = a > 0 ? a - 1 : 0; p <= std::min(rows - 1, a + 1); ++p) {
          for (std::size_t q = b > 0 ? b - 1 : 0; q <= std::min(columns - 1, b + 1); ++q) {
            if (seen[p * columns + q] || !is_hole(p, q)) continue;
            seen[p * columns + q] = 1;
            stack.emplace_back(p, q);
          }
        }
      }
      // The hole reaches halfway to the nodes around it.
      const double length_m = static_cast<double>(i_high - i_low + 1) * map.line.u_step_m;
      const double width_m =
          0.5 * (map.v_m[j_high + 1] - map.v_m[j_low - 1] + map.v_m[j_high] - map.v_m[j_low]);
      const double size_m = std::max(length_m, width_m);
      const bool stripe = size_m >= 5.0 && size_m > 5.0 * std::min(length_m, width_m);
      Finding f = finding(
          map, stripe ? "nan_stripe" : "hole", map.u_of(i_low), map.u_of(i_high), size_m, "m",
          size_m > options.max_hole_m && !is_end(map, i_low, i_high, options) ? Severity::error
                                                                              : Severity::remark,
          fmt::format(
              "{} of {:.2f} m x {:.2f} m ({} nodes without height) at u = {:.1f} m, v = {:.1f} m",
              stripe ? "Stripe" : "Hole", length_m, width_m, nodes, map.u_of(i_low),
              0.5 * (map.v_m[j_low] + map.v_m[j_high])));
      f.v_begin_m = map.v_m[j_low];
      f.v_end_m = map.v_m[j_high];
      (stripe ? stripes : holes).push_back(std::move(f));
    }
  }
  return holes;
}

}  // namespace road
