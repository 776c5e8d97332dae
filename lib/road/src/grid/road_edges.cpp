#include "road/road_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "base/statistics.h"
#include "road/gaps.h"
#include "row_walk.h"
#include "u_ranges.h"

namespace road {
namespace {

// A piece of the road's edge that is missing: both ends this abrupt, in columns too, since any edge
// goes from one to the next; and no longer than this.
constexpr double kAbrupt_m = 0.4, kAbruptColumns = 1.5, kLongestNotch_m = 12.0;
constexpr double kBesideCut_m = 20.0;
// The width that a road has without kerbs, lay-bys and what is lost of it: that of the narrowest
// quarter of this much before and behind, less a kerb where the road has that width elsewhere.
constexpr double kUsualWithin_m = 150.0, kUsualStep_m = 1.0, kNarrowest = 0.25, kKerb_m = 2.0;

bool is_driven(const SampledGrid& sampled, std::size_t node) {
  return sampled.provenance[node] != Provenance::none &&
         (sampled.surface_class[node] == SurfaceClass::road ||
          sampled.surface_class[node] == SurfaceClass::kerb);
}

/// Every value at least each other one less the distance in rows; at most each other one more it
/// with `sign` -1.
void limit_slope(std::vector<double>& value, double step, bool closed, double sign) {
  const std::size_t n = value.size();
  if (n < 2) return;
  const auto pull = [&](std::size_t i, std::size_t from) {
    value[i] = sign * std::max(sign * value[i], sign * value[from] - step);
  };
  const int turns = closed ? 2 : 1;  // the last row is the first again
  for (int turn = 0; turn < turns; ++turn) {
    for (std::size_t i = 1; i < n; ++i) pull(i, i - 1);
    if (closed) pull(0, n - 1);
  }
  for (int turn = 0; turn < turns; ++turn) {
    for (std::size_t i = n - 1; i > 0; --i) pull(i - 1, i);
    if (closed) pull(n - 1, 0);
  }
}

/// Between an abrupt end of the edge and where it is as abruptly back, it goes straight on.
void fill_notches(std::vector<double>& edge_m, double u_step_m, double abrupt_m, double sign) {
  const std::size_t n = edge_m.size();
  const auto longest = static_cast<std::size_t>(kLongestNotch_m / u_step_m);
  for (std::size_t a = 0; a + 1 < n; ++a) {
    if (sign * (edge_m[a] - edge_m[a + 1]) < abrupt_m) continue;
    for (std::size_t b = a + 1; b + 1 < n && b - a <= longest; ++b) {
      if (sign * (edge_m[b + 1] - edge_m[b]) < abrupt_m) continue;
      const double filled_m = sign * std::min(sign * edge_m[a], sign * edge_m[b + 1]);
      for (std::size_t i = a + 1; i <= b; ++i)
        edge_m[i] = sign * std::max(sign * edge_m[i], sign * filled_m);
      break;
    }
  }
}

/// The usual width of the road about each row.
std::vector<double> usual_width_m(const RoadEdges& edges, const crg::ReferenceLine& line) {
  const std::size_t rows = edges.left_m.size();
  const auto in_rows = [&](double length_m) {
    return static_cast<std::size_t>(std::max(1.0, length_m / line.u_step_m));
  };
  const std::size_t stride = in_rows(kUsualStep_m),
                    reach = std::min(in_rows(kUsualWithin_m), (rows - 1) / 2);
  std::vector<double> width_m(rows), usual_m(rows), around_m;
  for (std::size_t i = 0; i < rows; ++i) width_m[i] = edges.left_m[i] - edges.right_m[i];
  const double of_all_m = base::quantile(width_m, kNarrowest);
  for (std::size_t i = 0; i < rows; i += stride) {
    around_m.clear();
    for (std::size_t k = 0; k <= 2 * reach; k += stride)
      if (line.closed || (i + k >= reach && i + k - reach < rows))
        around_m.push_back(width_m[(i + rows + k - reach) % rows]);
    const double here_m = base::quantile(around_m, kNarrowest);
    std::fill_n(usual_m.begin() + static_cast<std::ptrdiff_t>(i), std::min(stride, rows - i),
                std::max(std::min(here_m, of_all_m), here_m - kKerb_m));
  }
  return usual_m;
}

/// No row is wider than usual for its neighbours' sake alone: a kerb begins where it begins.
void limit_to_usual(const RoadEdges& before, const std::vector<double>& usual_m, RoadEdges& edges) {
  for (std::size_t i = 0; i < usual_m.size(); ++i) {
    const double left_m = before.left_m[i], right_m = before.right_m[i];
    edges.left_m[i] = std::min(edges.left_m[i], std::max(left_m, right_m + usual_m[i]));
    edges.right_m[i] = std::max(edges.right_m[i], std::min(right_m, left_m - usual_m[i]));
  }
}

/// The columns of one side, from the line outwards.
struct Outwards {
  SampledGrid& sampled;
  std::ptrdiff_t step;
  std::size_t columns() const { return sampled.grid.columns(); }
  double out_m(std::size_t column) const {
    return static_cast<double>(step) * sampled.grid.v_m[column];
  }
};

/// Nodes without height beyond the edge, in rows that reach it, with one that has a height behind.
std::vector<std::uint8_t> missing_beyond(const Outwards& side, const std::vector<double>& edge_m) {
  const SampledGrid& sampled = side.sampled;
  const std::size_t rows = sampled.grid.rows(), columns = side.columns();
  std::vector<std::uint8_t> missing;
  for (std::size_t i = 0; i < rows; ++i) {
    const auto node = [&](std::size_t k) {
      return i * columns + (side.step > 0 ? k : columns - 1 - k);
    };
    const auto is_none = [&](std::size_t k) {
      return sampled.provenance[node(k)] == Provenance::none;
    };
    std::size_t begin = 0, end = columns;
    while (begin < columns && side.out_m(node(begin) % columns) <= edge_m[i] + 1e-9) ++begin;
    if (begin == 0 || is_none(begin - 1)) continue;
    while (end > begin && is_none(end - 1)) --end;
    for (std::size_t k = begin; k < end; ++k) {
      if (!is_none(k)) continue;
      if (missing.empty()) missing.resize(rows * columns, 0);
      missing[node(k)] = 1;
    }
  }
  return missing;
}

/// Takes the nodes that hang together with `start` out of `missing`.
std::vector<std::size_t> take_piece(std::vector<std::uint8_t>& missing, std::size_t columns,
                                    std::size_t start) {
  const std::size_t rows = missing.size() / columns;
  std::vector<std::size_t> piece{start};
  missing[start] = 0;
  for (std::size_t next = 0; next < piece.size(); ++next) {
    const std::size_t a = piece[next] / columns, b = piece[next] % columns;
    for (std::size_t p = a > 0 ? a - 1 : 0; p <= std::min(rows - 1, a + 1); ++p)
      for (std::size_t q = b > 0 ? b - 1 : 0; q <= std::min(columns - 1, b + 1); ++q)
        if (missing[p * columns + q] != 0)
          missing[p * columns + q] = 0, piece.push_back(p * columns + q);
  }
  return piece;
}

/// How far outwards each row is whole; infinite where no more than a crack is missing.
std::vector<double> whole_to(const Outwards& side, const std::vector<double>& edge_m,
                             double u_step_m) {
  const std::size_t columns = side.columns();
  const auto& v_m = side.sampled.grid.v_m;
  std::vector<double> limit_m(side.sampled.grid.rows(), std::numeric_limits<double>::infinity());
  std::vector<std::uint8_t> missing = missing_beyond(side, edge_m);
  for (std::size_t start = 0; start < missing.size(); ++start) {
    if (missing[start] == 0) continue;
    const std::vector<std::size_t> piece = take_piece(missing, columns, start);
    const auto [first, last] = std::minmax_element(piece.begin(), piece.end());
    const auto [low, high] = std::minmax_element(
        piece.begin(), piece.end(),
        [&](std::size_t a, std::size_t b) { return a % columns < b % columns; });
    const std::size_t rows_of_piece = *last / columns - *first / columns + 1;
    const double length_m = static_cast<double>(rows_of_piece) * u_step_m,
                 width_m = v_m[std::min(*high % columns + 1, columns - 1)] - v_m[*low % columns];
    if (std::max(length_m, width_m) <= kMaxHole_m) continue;
    for (const std::size_t node : piece) {
      double& limit = limit_m[node / columns];
      limit = std::min(limit, side.out_m(node % columns));
    }
  }
  return limit_m;
}

/// Rows whose surface ends on this side nearer than it does before and behind, by more than a
/// notch.
std::vector<char> notched(const Outwards& side, const std::vector<double>& edge_m,
                          const crg::ReferenceLine& line) {
  constexpr double kNotch_m = 1.0;
  const std::size_t rows = side.sampled.grid.rows(), columns = side.columns();
  std::vector<double> end_m = edge_m;
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j)
      if (side.sampled.provenance[i * columns + j] != Provenance::none)
        end_m[i] = std::max(end_m[i], side.out_m(j));
  std::vector<double> around_m = end_m;
  limit_slope(around_m, line.u_step_m, line.closed, 1.0);
  std::vector<char> found(rows, 0);
  for (std::size_t i = 0; i < rows; ++i) found[i] = around_m[i] - end_m[i] > kNotch_m ? 1 : 0;
  return found;
}

/// Rows that end early on this side, after those with holes have been cut.
std::vector<char> end_side(const Outwards& side, const std::vector<double>& edge_m,
                           const crg::ReferenceLine& line) {
  SampledGrid& sampled = side.sampled;
  const std::size_t rows = sampled.grid.rows(), columns = side.columns();
  std::vector<double> limit_m = whole_to(side, edge_m, line.u_step_m);
  limit_slope(limit_m, line.u_step_m, line.closed, -1.0);
  for (std::size_t i = 0; i < rows; ++i) {
    if (std::isinf(limit_m[i])) continue;
    for (std::size_t j = 0; j < columns; ++j) {
      const std::size_t node = i * columns + j;
      const double out_m = side.out_m(j);
      if (out_m <= edge_m[i] + 1e-9 || out_m < limit_m[i] - 1e-9 ||
          sampled.provenance[node] == Provenance::none)
        continue;
      sampled.grid.z_m[node] = std::numeric_limits<float>::quiet_NaN();
      sampled.provenance[node] = Provenance::none;
    }
  }
  return notched(side, edge_m, line);
}

}  // namespace

RoadEdges road_edges(const SampledGrid& sampled, const crg::ReferenceLine& line,
                     const Centreline& centreline, const SampleReport& report) {
  const std::vector<double> half_m = guide_rows(line, centreline).half_width_m;
  const std::size_t rows = sampled.grid.rows(), columns = sampled.grid.columns();
  const auto& v_m = sampled.grid.v_m;
  const auto middle =
      static_cast<std::size_t>(std::min(std::lower_bound(v_m.begin(), v_m.end(), 0.0) - v_m.begin(),
                                        static_cast<std::ptrdiff_t>(columns) - 1));
  // What is missing beside its last column ends the road: behind a wedge there begins a pit lane.
  const double column_m = (v_m.back() - v_m.front()) / static_cast<double>(columns - 1);
  RoadEdges edges{std::vector<double>(rows, 0.0), std::vector<double>(rows, 0.0)};
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t row = i * columns;
    for (std::size_t j = middle; j < columns; ++j) {
      if (is_driven(sampled, row + j))
        edges.left_m[i] = std::max(0.0, v_m[j]);
      else if (v_m[j] > half_m[i] - column_m)
        break;
    }
    for (std::size_t j = middle + 1; j-- > 0;) {
      if (is_driven(sampled, row + j))
        edges.right_m[i] = std::min(0.0, v_m[j]);
      else if (-v_m[j] > half_m[i] - column_m)
        break;
    }
  }
  // Rows that were cut short on purpose have no notch: a fold, another leg, a wall.
  const RoadEdges seen = edges;
  const double abrupt_m = std::max(kAbrupt_m, kAbruptColumns * column_m);
  fill_notches(edges.left_m, line.u_step_m, abrupt_m, 1.0);
  fill_notches(edges.right_m, line.u_step_m, abrupt_m, -1.0);
  const RoadEdges filled = edges;
  limit_slope(edges.left_m, line.u_step_m, line.closed, 1.0);
  limit_slope(edges.right_m, line.u_step_m, line.closed, -1.0);
  limit_to_usual(filled, usual_width_m(seen, line), edges);
  for (const auto* ranges : {&report.folds, &report.neighbours, &report.walls})
    for (const URange& range : *ranges)
      for (std::size_t i = 0; i < rows; ++i) {
        const double u_m = static_cast<double>(i) * line.u_step_m;
        if (u_m < range.u_begin_m - kBesideCut_m || u_m > range.u_end_m + kBesideCut_m) continue;
        edges.left_m[i] = seen.left_m[i];
        edges.right_m[i] = seen.right_m[i];
      }
  return edges;
}

bool lies_beyond(const RoadEdges& edges, std::size_t first, std::size_t last, double v_begin_m,
                 double v_end_m) {
  if (edges.empty()) return false;
  bool left = true, right = true;
  for (std::size_t i = first; i <= std::min(last, edges.left_m.size() - 1) && (left || right);
       ++i) {
    left = left && v_begin_m > edges.left_m[i];
    right = right && v_end_m < edges.right_m[i];
  }
  return left || right;
}

void end_where_whole(SampledGrid& sampled, const RoadEdges& edges, const crg::ReferenceLine& line,
                     SampleReport& report) {
  std::vector<double> right_m = edges.right_m;
  for (double& v : right_m) v = -v;
  report.cut_left = ranges_of(end_side({sampled, 1}, edges.left_m, line), line.u_step_m);
  report.cut_right = ranges_of(end_side({sampled, -1}, right_m, line), line.u_step_m);
  if (!report.cut_left.empty() || !report.cut_right.empty()) count_nodes(sampled, report);
}

}  // namespace road
