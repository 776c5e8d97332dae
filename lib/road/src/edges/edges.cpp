#include "road/edges.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/statistics.h"
#include "edge_curve.h"
#include "edge_grid.h"
#include "edge_rungs.h"
#include "edge_sections.h"
#include "mesh/error.h"
#include "road/crossings.h"
#include "road/reference_line.h"
#include "u_ranges.h"

namespace road {
namespace {

using Eigen::Vector2d;

constexpr double kFoldMargin = 0.1;  // rows keep at least this share of their spacing

/// How far given points lie from the road's edges, and where the farthest does.
struct PointErrors {
  std::vector<double> off_m;
  double worst_m = 0.0;
  std::string worst;
};

/// Distance of the given points from the polyline of the rows' edge.
void point_errors(const EdgeCurve& curve, const std::vector<Vector2d>& rows,
                  const std::vector<double>& s_m, bool closed, PointErrors& errors) {
  for (std::size_t k = 0; k < curve.given_m.size(); ++k) {
    double s = curve.s_of_given_m[k];
    if (closed && s < s_m.front()) s += curve.length_m;
    const auto next = std::upper_bound(s_m.begin(), s_m.end(), s);
    if (next == s_m.begin() || next == s_m.end())
      continue;  // before the first or after the last row
    const auto i = static_cast<std::size_t>(next - s_m.begin()) - 1;
    const Vector2d p = curve.given_m[k].head<2>() - rows[i], along = rows[i + 1] - rows[i];
    const double t = std::clamp(p.dot(along) / std::max(along.squaredNorm(), 1e-18), 0.0, 1.0);
    errors.off_m.push_back((p - t * along).norm());
    if (errors.off_m.back() <= errors.worst_m) continue;
    errors.worst_m = errors.off_m.back();
    errors.worst =
        fmt::format("{}: the point ({:.3f}, {:.3f}) lies {:.2f} m off the road's edge", curve.path,
                    curve.given_m[k].x(), curve.given_m[k].y(), errors.worst_m);
  }
}

void check_pair(const EdgeCurve& left, const EdgeCurve& right, const Edge& left_edge,
                const Edge& right_edge) {
  if (left.closed != right.closed) {
    const auto name = [](const EdgeCurve& c) {
      return fmt::format("{} is {} ({:.1f} m from its last point to its first)", c.path,
                         c.closed ? "closed" : "open",
                         (c.given_m.front() - c.given_m.back()).head<2>().norm());
    };
    throw Error(
        fmt::format("{}, but {}; wanted both closed or both open: is one of them cut short?",
                    name(left), name(right)));
  }
  if (left_edge.has_z != right_edge.has_z) {
    throw Error(fmt::format("{} has a column z_m, {} has none; wanted it in both or in neither",
                            (left_edge.has_z ? left : right).path,
                            (left_edge.has_z ? right : left).path));
  }
}

/// Both edges, the right one turned round where it runs against the left one.
struct EdgePair {
  EdgeCurve left, right;
  double right_s_at_start_m = 0.0;
};

EdgePair pair_of(const Edge& left_edge, const Edge& right_edge, EdgesReport& result) {
  EdgePair pair{edge_curve(left_edge), edge_curve(right_edge), 0.0};
  const EdgeCurve& left = pair.left;
  EdgeCurve& right = pair.right;
  check_pair(left, right, left_edge, right_edge);
  Relation relation = relate(left, right);
  result.right_reversed = relation.backward > relation.forward;
  if (result.right_reversed) {
    right = edge_curve(right_edge, true);
    relation = relate(left, right);
    result.remarks.push_back(
        fmt::format("{}: its rows run against those of {}; turned round", right.path, left.path));
  }
  if (relation.on_left > relation.on_right) {
    throw Error(
        fmt::format("{} lies on the left of {} in the direction of its rows; exchange the two "
                    "files, or turn the rows "
                    "of the left edge round",
                    right.path, left.path));
  }
  pair.right_s_at_start_m = relation.right_s_at_start_m;
  return pair;
}

/// The edges as the rows of the road meet them.
struct EdgeRows {
  std::vector<EdgeSection> sections;
  std::vector<Vector2d> left_xy, right_xy;
  std::vector<double> left_s, right_s;
};

EdgeRows rows_between(const EdgeCurve& left, const EdgeCurve& right, const crg::ReferenceLine& line,
                      Rung guess) {
  EdgeRows rows;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const crg::Point2 p = crg::node_position(line, i, 0.0), q = crg::node_position(line, i, 1.0);
    const Vector2d at(p.x_m, p.y_m), normal(q.x_m - p.x_m, q.y_m - p.y_m);
    const EdgeSection section = cut_edges(left, right, guess, at, normal);
    refuse_missed(section, left, right, line.u_step_m * static_cast<double>(i));
    guess = {section.left.s_m, section.right.s_m};
    rows.left_xy.push_back(at + section.left.v_m * normal);
    rows.right_xy.push_back(at + section.right.v_m * normal);
    rows.left_s.push_back(section.left.s_m);
    rows.right_s.push_back(section.right.s_m);
    rows.sections.push_back(section);
  }
  return rows;
}

/// Cuts rows short where the bend is tighter than the road is wide; gives back which.
std::vector<char> cut_folds(const crg::ReferenceLine& line, std::vector<EdgeSection>& sections) {
  const std::size_t rows = line.size();
  std::vector<char> folded(rows, 0);
  const auto reach = static_cast<std::size_t>(std::ceil(1.0 / line.u_step_m));
  for (std::size_t i = 0; i < rows; ++i) {
    const std::size_t a = i > reach ? i - reach : 1, b = std::min(rows - 1, i + reach);
    if (b <= a) continue;
    const double curvature =
        (line.heading_rad[b] - line.heading_rad[a]) / (line.u_step_m * static_cast<double>(b - a));
    EdgeMeeting& inner = curvature > 0.0 ? sections[i].left : sections[i].right;
    if (curvature * inner.v_m <= 1.0 - kFoldMargin) continue;
    inner.v_m = (1.0 - kFoldMargin) / curvature;
    folded[i] = 1;
  }
  return folded;
}

/// What of an open road's edge has no other edge beside it.
void report_ends(const EdgeCurve& curve, const std::vector<double>& used_s, EdgesReport& result) {
  const double rest = curve.length_m - used_s.back();
  if (rest > 1.0)
    result.remarks.push_back(fmt::format(
        "{}: the last {:.1f} m have no other edge beside them; left out", curve.path, rest));
  const double used_from = used_s.front();
  if (used_from < -0.5)
    result.remarks.push_back(fmt::format(
        "{}: begins {:.1f} m after the other edge; continued straight", curve.path, -used_from));
  if (used_from < -result.width_max_m) {
    throw Error(
        fmt::format("{}: begins {:.1f} m after the first row of the left edge; wanted at "
                    "most one width of the road, {:.1f} m",
                    curve.path, -used_from, result.width_max_m));
  }
}

void report_sizes(const EdgePair& edges, const EdgeRows& rows, const EdgeGridReport& grid,
                  const crg::ReferenceLine& line, EdgesReport& result) {
  PointErrors errors;
  point_errors(edges.left, rows.left_xy, rows.left_s, line.closed, errors);
  point_errors(edges.right, rows.right_xy, rows.right_s, line.closed, errors);
  const auto quantile = [](const std::vector<double>& values, double share) {
    return values.empty() ? 0.0 : base::quantile(values, share);
  };
  result.width_min_m = quantile(grid.widths_m, 0.0);
  result.width_median_m = quantile(grid.widths_m, 0.5);
  result.width_max_m = quantile(grid.widths_m, 1.0);
  result.point_error_p99_m = quantile(errors.off_m, 0.99);
  result.point_error_max_m = errors.worst_m;
  result.edge_gap_median_m = quantile(grid.gaps_m, 0.5);
  result.edge_gap_max_m = quantile(grid.gaps_m, 1.0);
  constexpr double kFar_m = 0.5, kWide = 2.5;
  if (errors.worst_m > kFar_m) result.remarks.push_back(errors.worst);
  if (result.width_max_m > kWide * result.width_median_m)
    result.remarks.push_back(fmt::format(
        "{:.1f} m wide at u = {:.1f} m, {:.1f} times as usual: do points stick out there?",
        result.width_max_m,
        line.u_step_m *
            static_cast<double>(std::max_element(grid.widths_m.begin(), grid.widths_m.end()) -
                                grid.widths_m.begin()),
        result.width_max_m / result.width_median_m));
}

}  // namespace

EdgeRoad road_between_edges(const Edge& left_edge, const Edge& right_edge,
                            const EdgeOptions& options, EdgesReport* report) {
  EdgesReport result;
  const EdgePair edges = pair_of(left_edge, right_edge, result);
  const EdgeCurve &left = edges.left, &right = edges.right;

  const std::vector<Rung> rungs = climb(left, right, edges.right_s_at_start_m);
  constexpr double kDraftStep_m = 0.5;
  EdgeRoad road;
  road.centreline = along(left, right, rungs);
  // Each round turns the normals a little; the middle moves by less than 0.1 mm after three.
  // Where the edges turn more tightly than they lie apart it would swing: there in ever smaller
  // steps.
  for (const double share : {1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 0.25, 0.25}) {
    const crg::ReferenceLine draft = fit_reference_line(road.centreline, {kDraftStep_m});
    road.centreline = recut(left, right, draft, rungs.front(), share);
  }
  road.line = fit_reference_line(road.centreline, {options.u_step_m});
  const crg::ReferenceLine& line = road.line;

  EdgeRows rows = rows_between(left, right, line, rungs.front());
  const std::vector<char> folded = cut_folds(line, rows.sections);
  refuse_narrow(rows.sections, line.u_step_m, 2.0 * options.v_step_m);
  EdgeGridReport grid;
  road.sampled = grid_between(line, rows.sections, options, grid);

  result.left_points = left_edge.points_m.size();
  result.right_points = right_edge.points_m.size();
  result.dropped_points = left.dropped + right.dropped;
  result.closed = line.closed;
  result.has_z = left_edge.has_z;
  report_sizes(edges, rows, grid, line, result);
  result.start_offset_m =
      (left.at(0.0).head<2>() - Vector2d(line.x_m[0], line.y_m[0]))
          .dot(Vector2d(std::cos(line.heading_rad[0]), std::sin(line.heading_rad[0])));
  result.folds = ranges_of(folded, line.u_step_m);
  std::vector<double> middle_z_m;
  for (const EdgeSection& section : rows.sections)
    middle_z_m.push_back(0.5 * (section.left.z_m + section.right.z_m));
  for (const Crossing& crossing : find_crossings(line, middle_z_m))
    result.remarks.push_back(describe(crossing));
  for (const bool of_left : {true, false}) {
    const EdgeCurve& curve = of_left ? left : right;
    result.remarks.insert(result.remarks.end(), curve.remarks.begin(), curve.remarks.end());
    if (!line.closed) report_ends(curve, of_left ? rows.left_s : rows.right_s, result);
  }
  if (report != nullptr) *report = std::move(result);
  return road;
}

}  // namespace road
