#include "road/sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <unordered_map>

#include "base/parallel.h"
#include "check_sampling.h"
#include "crg/huge_pages.h"
#include "mesh/error.h"
#include "road/reference_line.h"
#include "road/stretch.h"
#include "row_walk.h"
#include "u_ranges.h"

namespace road {

namespace {

using Eigen::Vector2d;

constexpr double kLayerGap_m =
    2.5;  // legs of the track closer in height than this are neighbours, else bridges
constexpr double kFoldMargin = 0.1;  // rows keep at least this share of their spacing
constexpr double kCrossingReach =
    2.0;  // times the grid's half width: how far from its middle a level crossing is one
constexpr double kCoarseStep_m = 1.0;  // of the search for folds and neighbours along u

/// How far a row reaches on one side, and whether a fold is the reason.
struct Side {
  double limit_m;
  bool fold;
};

/// From every `stride`th row to all rows: the nearer limit of the two around.
void spread(const std::vector<Side>& sides, std::size_t stride, const crg::ReferenceLine& line,
            std::vector<float>& limit, std::vector<char>& fold) {
  limit.resize(line.size());
  fold.resize(line.size());
  for (std::size_t i = 0; i < line.size(); ++i) {
    const std::size_t a = std::min(i / stride, sides.size() - 1);
    const std::size_t b = a + 1 < sides.size() ? a + 1 : (line.closed ? 0 : a);
    const Side& side = sides[a].limit_m < sides[b].limit_m ? sides[a] : sides[b];
    limit[i] = static_cast<float>(side.limit_m);
    fold[i] = side.fold ? 1 : 0;
  }
}

RowLimits limit_rows(const crg::ReferenceLine& line, const RowGuide& guide,
                     const std::vector<Crossing>& crossings, double v_max_m) {
  const auto stride = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::lround(kCoarseStep_m / line.u_step_m)));
  std::vector<std::size_t> coarse;
  for (std::size_t i = 0; i + (line.closed ? 1 : 0) < line.size(); i += stride) coarse.push_back(i);

  const double cell_m = 2.0 * v_max_m;
  struct Place {
    Vector2d p_m;
    std::size_t row;
  };
  std::unordered_map<std::int64_t, std::vector<Place>> cells;
  const auto index = [&](double x) { return static_cast<std::int64_t>(std::floor(x / cell_m)); };
  const auto key = [](std::int64_t ix, std::int64_t iy) { return (ix << 32) ^ (iy & 0xffffffff); };
  for (const std::size_t i : coarse)
    cells[key(index(line.x_m[i]), index(line.y_m[i]))].push_back({{line.x_m[i], line.y_m[i]}, i});

  const double period_m = static_cast<double>(line.size() - 1) * line.u_step_m;
  const auto along_m = [&](double u, double other_u) {
    const double du = std::abs(u - other_u);
    return line.closed ? std::min(du, period_m - du) : du;
  };
  // At a level crossing both legs are the road: neither ends where the other is nearer.
  const auto cross_here = [&](std::size_t i, std::size_t j) {
    const double a = line.u_begin_m + static_cast<double>(i) * line.u_step_m,
                 b = line.u_begin_m + static_cast<double>(j) * line.u_step_m;
    const double reach_m = kCrossingReach * v_max_m;
    return std::any_of(crossings.begin(), crossings.end(), [&](const Crossing& c) {
      return is_level(c) &&
             ((along_m(a, c.u_first_m) < reach_m && along_m(b, c.u_second_m) < reach_m) ||
              (along_m(b, c.u_first_m) < reach_m && along_m(a, c.u_second_m) < reach_m));
    });
  };
  std::vector<Side> left(coarse.size()), right(coarse.size());
  for (std::size_t k = 0; k < coarse.size(); ++k) {
    const std::size_t i = coarse[k];
    const crg::Point2 p = crg::node_position(line, i, 0.0), q = crg::node_position(line, i, 1.0);
    const Vector2d here(p.x_m, p.y_m), normal(q.x_m - p.x_m, q.y_m - p.y_m);
    left[k] = right[k] = {2.0 * v_max_m, true};
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        const auto found = cells.find(key(index(here.x()) + dx, index(here.y()) + dy));
        if (found == cells.end()) continue;
        for (const auto& [p_m, j] : found->second) {
          const Vector2d d = p_m - here;
          const double across = d.dot(normal);
          Side& side = across > 0.0 ? left[k] : right[k];
          // Surely no nearer than what is known, fold or not; most are not, so this is asked first.
          if ((1.0 - kFoldMargin) * d.squaredNorm() > 2.001 * std::abs(across) * side.limit_m ||
              std::abs(across) < 1e-9)
            continue;
          if (std::abs(guide.z_m[i] - guide.z_m[j]) > kLayerGap_m || cross_here(i, j)) continue;
          const double du = along_m(static_cast<double>(i) * line.u_step_m,
                                    static_cast<double>(j) * line.u_step_m);
          // Half a circle round the touching circle is the same bend; further is another leg.
          const double radius_m = d.squaredNorm() / (2.0 * std::abs(across));
          const bool fold = du < 3.2 * radius_m;
          const double limit_m = fold ? (1.0 - kFoldMargin) * radius_m : radius_m;
          if (limit_m < side.limit_m) side = {limit_m, fold};
        }
      }
    }
  }
  RowLimits limits;
  spread(left, stride, line, limits.left_m, limits.left_is_fold);
  spread(right, stride, line, limits.right_m, limits.right_is_fold);
  return limits;
}

/// Columns of the outermost nodes of a row with a height (none when first > last) and the nodes
/// without one between.
struct Span {
  std::size_t first, last, holes;
  bool empty() const { return first > last; }
  bool operator==(const Span&) const = default;
};

/// Of a row whose nodes with a height lie in [first, end).
Span span_of(const Provenance* row, std::size_t first, std::size_t end) {
  while (first < end && row[first] == Provenance::none) ++first;
  if (first >= end) return {1, 0, 0};
  while (row[end - 1] == Provenance::none) --end;
  // Nearly every row is whole, which is quickly seen.
  if (std::memchr(row + first, static_cast<int>(Provenance::none), end - first) == nullptr)
    return {first, end - 1, 0};
  return {first, end - 1,
          static_cast<std::size_t>(std::count(row + first, row + end, Provenance::none))};
}

/// Fills runs of missing nodes between two nodes of one class, first across, then along. `spans` of
/// the rows before.
std::size_t fill_gaps(SampledGrid& sampled, const std::vector<Span>& spans, double max_gap_m) {
  const std::size_t rows = sampled.grid.rows(), columns = sampled.grid.columns();
  std::size_t filled = 0;
  const auto fill = [&](std::size_t a, std::size_t b, std::size_t stride, const auto& coordinate) {
    // Nodes a + stride, a + 2 stride, ... before b lie between the known nodes a and b.
    const double from = coordinate(a), to = coordinate(b);
    if (to - from > max_gap_m + 1e-9 || sampled.surface_class[a] != sampled.surface_class[b] ||
        sampled.surface_class[a] == SurfaceClass::kerb) {
      return;
    }
    const float za = sampled.grid.z_m[a], zb = sampled.grid.z_m[b];
    if (static_cast<double>(std::abs(zb - za)) > 0.02 + 0.5 * (to - from)) return;
    for (std::size_t node = a + stride; node < b; node += stride) {
      const double t = (coordinate(node) - from) / (to - from);
      sampled.grid.z_m[node] =
          static_cast<float>(static_cast<double>(za) + t * static_cast<double>(zb - za));
      sampled.provenance[node] = Provenance::filled;
      sampled.surface_class[node] = sampled.surface_class[a];
      ++filled;
    }
  };
  // Nearly every row is whole and like the one before it: both passes look closely at the others
  // only.
  for (std::size_t i = 0; i < rows; ++i) {
    const Provenance* row = sampled.provenance.data() + i * columns;
    const Span& span = spans[i];
    if (span.holes == 0) continue;
    std::size_t known = span.first;
    for (std::size_t j = span.first; j <= span.last; ++j) {
      if (row[j] == Provenance::none) continue;
      if (j > known + 1) {
        fill(i * columns + known, i * columns + j, 1,
             [&](std::size_t k) { return sampled.grid.v_m[k % columns]; });
      }
      known = j;
    }
  }
  const auto reach = static_cast<std::size_t>(std::floor(max_gap_m / sampled.grid.u_step_m + 1e-9));
  for (std::size_t i = 1; i < rows; ++i) {
    const Provenance *row = sampled.provenance.data() + i * columns, *before = row - columns;
    if (spans[i].holes == 0 && spans[i] == spans[i - 1]) continue;
    for (std::size_t j = 0; j < columns; ++j) {
      if (row[j] == Provenance::none || before[j] != Provenance::none) continue;
      // A gap of this column ends here: where did it begin?
      for (std::size_t back = 2; back <= std::min(reach, i); ++back) {
        const std::size_t node = (i - back) * columns + j;
        if (sampled.provenance[node] == Provenance::none) continue;
        fill(node, i * columns + j, columns, [&](std::size_t k) {
          const std::size_t row_of_node = k / columns;
          return static_cast<double>(row_of_node) * sampled.grid.u_step_m;
        });
        break;
      }
    }
  }
  return filled;
}

/// The last row is the first again.
void close_grid(SampledGrid& out) {
  const std::size_t kept = out.grid.columns();
  const std::size_t last = (out.grid.rows() - 1) * kept;
  std::copy_n(out.grid.z_m.begin(), kept, out.grid.z_m.begin() + static_cast<std::ptrdiff_t>(last));
  std::copy_n(out.provenance.begin(), kept,
              out.provenance.begin() + static_cast<std::ptrdiff_t>(last));
  std::copy_n(out.surface_class.begin(), kept,
              out.surface_class.begin() + static_cast<std::ptrdiff_t>(last));
}

/// `spans` hold as long as nothing was filled.
SampleReport report_of_nodes(const SampledGrid& out, const std::vector<Span>& spans,
                             std::size_t filled) {
  SampleReport result;
  const std::size_t kept = out.grid.columns();
  result.nodes = out.grid.z_m.size();
  result.filled = filled;
  for (std::size_t i = 0; i < out.grid.rows(); ++i) {
    const Span span = filled > 0 ? span_of(&out.provenance[i * kept], 0, kept) : spans[i];
    if (span.empty()) continue;
    result.holes += span.holes;
    result.nodes_with_z += span.last - span.first + 1 - span.holes;
  }
  return result;
}

/// The steps that the centreline asks for where none are given.
SampleOptions with_steps(const SampleOptions& asked, const Centreline& centreline) {
  const double automatic_m = automatic_step_m(centreline), scale = automatic_m / 0.1;
  SampleOptions options = asked;
  options.v_step_m = asked.v_step_m.value_or(automatic_m);
  options.max_step_m = asked.max_step_m.value_or(0.3 * scale);
  options.max_gap_m = asked.max_gap_m.value_or(0.3 * scale);
  return options;
}

/// A grid of the line with room for its nodes.
void reserve_grid(const crg::ReferenceLine& line, const SampleOptions& options, SampledGrid& out) {
  const double v_step_m = *options.v_step_m;
  out.grid.u_begin_m = line.u_begin_m;
  out.grid.u_step_m = line.u_step_m;
  const auto half = static_cast<std::ptrdiff_t>(std::floor(options.v_max_m / v_step_m + 1e-9));
  for (std::ptrdiff_t j = -half; j <= half; ++j)
    out.grid.v_m.push_back(static_cast<double>(j) * v_step_m);
  const std::size_t columns = out.grid.v_m.size();
  crg::reserve_huge(out.grid.z_m, line.size() * columns);
  crg::reserve_huge(out.surface_class, line.size() * columns);
  out.grid.z_m.resize(line.size() * columns);
  out.surface_class.resize(line.size() * columns);
}

/// The columns between which rays met the road, [first, end).
std::pair<std::size_t, std::size_t> columns_met(const std::vector<RowsReached>& reached,
                                                std::size_t columns) {
  std::size_t first_column = columns, end_column = 0;
  for (const RowsReached& ends : reached) {
    if (ends.empty()) continue;
    first_column = std::min(first_column, ends.first_column);
    end_column = std::max(end_column, ends.end_column);
  }
  if (first_column >= end_column) {
    throw Error(
        "no ray met the road: the centreline and the mesh do not lie in the same place (frame, "
        "unit or up axis differ)");
  }
  if (first_column + 1 == end_column)
    first_column = 0, end_column = columns;  // a grid has two columns or more
  return {first_column, end_column};
}

/// Of the whole line, or of some rows of it.
SampledGrid sample(const RoadMesh& road, const RaySurface& surface, const crg::ReferenceLine& whole,
                   const std::optional<RowRange>& rows_wanted, const Centreline& centreline,
                   const SampleOptions& asked, SampleReport* report) {
  const SampleOptions options = with_steps(asked, centreline);
  check_sampling(whole, centreline, surface, options);
  RowGuide guide = guide_rows(whole, centreline);
  std::vector<Crossing> crossings = find_crossings(whole, guide.z_m);
  RowLimits limits = limit_rows(whole, guide, crossings, options.v_max_m);
  std::optional<crg::ReferenceLine> stretch;
  if (rows_wanted) {
    stretch = line_of_rows(whole, *rows_wanted);
    const auto part = [&](const auto& of_all) { return of_rows(of_all, whole, *rows_wanted); };
    guide = {part(guide.z_m), part(guide.half_width_m)};
    limits = {part(limits.left_m), part(limits.right_m), part(limits.left_is_fold),
              part(limits.right_is_fold)};
  }
  const crg::ReferenceLine& line = stretch ? *stretch : whole;

  SampledGrid out;
  reserve_grid(line, options, out);
  const std::size_t columns = out.grid.v_m.size();
  // The last node of a closed line stands for the first: it is copied, not cast.
  const std::size_t rows = line.closed ? line.size() - 1 : line.size();
  std::vector<char> folded(rows, 0), neighboured(rows, 0);
  std::vector<RowsReached> reached((rows + kWalkRows - 1) / kWalkRows);
  base::parallel_for(rows, 4 * kWalkRows, options.threads, [&](std::size_t begin, std::size_t end) {
    RowWalk walk(road, surface, line, guide, limits, options, out);
    for (std::size_t first = begin; first < end; first += kWalkRows) {
      const std::size_t count = std::min(kWalkRows, end - first);
      const RowsReached& ends = reached[first / kWalkRows] = walk.sample(first, count);
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = first + k;
        folded[i] = (ends.left_cut[k] && limits.left_is_fold[i]) ||
                    (ends.right_cut[k] && limits.right_is_fold[i]);
        neighboured[i] = (ends.left_cut[k] && !limits.left_is_fold[i]) ||
                         (ends.right_cut[k] && !limits.right_is_fold[i]);
      }
    }
  });
  const auto [first_column, end_column] = columns_met(reached, columns);
  turn_into_rows(out, rows, reached, first_column, end_column, surface.origin_m().z());
  const std::size_t kept = out.grid.columns();
  std::vector<Span> spans(line.size(), Span{1, 0, 0});
  for (std::size_t i = 0; i < rows; ++i) {
    const RowsReached& ends = reached[i / kWalkRows];
    if (!ends.empty())
      spans[i] = span_of(&out.provenance[i * kept], ends.first_column - first_column,
                         ends.end_column - first_column);
  }
  const std::size_t filled = fill_gaps(out, spans, *options.max_gap_m);
  if (line.closed) close_grid(out);

  if (line.closed) spans.back() = spans.front();
  SampleReport result = report_of_nodes(out, spans, filled);
  result.folds = ranges_of(folded, line.u_step_m);
  result.neighbours = ranges_of(neighboured, line.u_step_m);
  result.crossings = std::move(crossings);
  if (report != nullptr) *report = std::move(result);
  return out;
}

}  // namespace

RowGuide guide_rows(const crg::ReferenceLine& line, const Centreline& centreline) {
  const std::size_t n = centreline.points_m.size();
  std::vector<double> s{0.0};
  const std::size_t segments = centreline.closed ? n : n - 1;
  for (std::size_t i = 0; i < segments; ++i) {
    s.push_back(s.back() +
                (centreline.points_m[(i + 1) % n] - centreline.points_m[i]).head<2>().norm());
  }
  RowGuide guide;
  guide.z_m.reserve(line.size());
  guide.half_width_m.reserve(line.size());
  std::size_t at = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double here = s.back() * static_cast<double>(i) / static_cast<double>(line.size() - 1);
    while (at + 1 < segments && s[at + 1] < here) ++at;
    const double t = std::clamp((here - s[at]) / std::max(s[at + 1] - s[at], 1e-9), 0.0, 1.0);
    const std::size_t next = (at + 1) % n;
    const auto mix = [t](double a, double b) { return a + t * (b - a); };
    guide.z_m.push_back(mix(centreline.points_m[at].z(), centreline.points_m[next].z()));
    guide.half_width_m.push_back(mix(centreline.half_width_m[at], centreline.half_width_m[next]));
  }
  return guide;
}

SampledGrid sample_grid(const RoadMesh& road, const RaySurface& surface,
                        const crg::ReferenceLine& line, const Centreline& centreline,
                        const SampleOptions& options, SampleReport* report) {
  return sample(road, surface, line, std::nullopt, centreline, options, report);
}

SampledGrid sample_rows(const RoadMesh& road, const RaySurface& surface,
                        const crg::ReferenceLine& line, const RowRange& rows,
                        const Centreline& centreline, const SampleOptions& options,
                        SampleReport* report) {
  return sample(road, surface, line, rows, centreline, options, report);
}

}  // namespace road
