#include "road/edges.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/statistics.h"
#include "edge_curve.h"
#include "road/error.h"
#include "road/reference_line.h"
#include "u_ranges.h"

namespace road {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRungStep_m = 0.5;
constexpr double kStationStep_m = 1.0;
constexpr double kWidest_m = 200.0;
constexpr double kReach_m = 30.0;            // along an edge, around where it should be met
constexpr double kFoldMargin = 0.1;          // rows keep at least this share of their spacing
constexpr double kColumnTolerance_m = 2e-3;  // a column this near to an edge stands for it
constexpr double kSteadyShare =
    0.02;  // of the rows with one edge position: it gets a column of its own
// A closed line starts this much before the first row of LEFT: between its last node and its first
// is a gap of 1 mm, wider on the outside of a bend, in which a query finds no height.
constexpr double kSeamMargin_m = 5e-3;
constexpr double kFinestColumn_m = 5e-3;

/// A line from one edge to the other, by length along both.
struct Rung {
  double left_s_m, right_s_m;
};

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// How RIGHT lies along LEFT: which way its rows run, on which side, and where it begins.
struct Relation {
  int forward = 0, backward = 0, on_right = 0, on_left = 0;
  double right_s_at_start_m = 0.0;
};

Relation relate(const EdgeCurve& left, const EdgeCurve& right) {
  Relation relation;
  const std::size_t stride = std::max<std::size_t>(1, right.points_m.size() / 8000);
  const auto nearest = [&](const Vector2d& p, const auto& allowed) {
    double best = std::numeric_limits<double>::infinity(), best_s = 0.0;
    for (std::size_t k = 0; k < right.points_m.size(); k += stride) {
      const double distance = (right.points_m[k].head<2>() - p).squaredNorm();
      if (distance < best && allowed(k)) {
        best = distance;
        best_s = right.s_m[k];
      }
    }
    return best_s;
  };
  constexpr int kProbes = 200;
  for (int k = 0; k < kProbes; ++k) {
    const double s = left.length_m * k / kProbes;
    const Vector2d p = left.at(s).head<2>(), ahead = left.at(s + 1.0).head<2>() - p;
    const auto any = [](std::size_t) { return true; };
    const double at = nearest(p, any), after = nearest(p + ahead * 10.0, any);
    double moved = after - at;
    if (right.closed) moved = std::remainder(moved, right.length_m);
    (moved >= 0.0 ? relation.forward : relation.backward) += 1;
    (cross(ahead, right.at(at).head<2>() - p) < 0.0 ? relation.on_right : relation.on_left) += 1;
  }
  // The start of a figure-eight may lie on its crossing: only an edge that runs the same way
  // counts.
  const Vector2d start = left.at(0.0).head<2>(), ahead = left.at(1.0).head<2>() - start;
  const auto beside_start = [&](std::size_t k) {
    const Vector2d p = right.points_m[k].head<2>(),
                   along = right.at(right.s_m[k] + 1.0).head<2>() - p;
    return cross(ahead, p - start) < 0.0 &&
           std::abs(along.dot(ahead)) > 0.7 * along.norm() * ahead.norm();
  };
  relation.right_s_at_start_m = std::clamp(nearest(start, beside_start), 0.0, right.length_m);
  return relation;
}

/// Rungs from the start on, each time forward on the side that gives the shorter rung: works
/// without any correspondence of points, through hairpins and figure-eights, as long as the edges
/// run beside each other.
std::vector<Rung> climb(const EdgeCurve& left, const EdgeCurve& right, double right_s_m) {
  std::vector<Rung> rungs{{0.0, right_s_m}};
  const double left_end = left.length_m,
               right_end = right.closed ? right_s_m + right.length_m : right.length_m;
  while (true) {
    Rung next = rungs.back();
    const bool left_done = next.left_s_m >= left_end, right_done = next.right_s_m >= right_end;
    if (left_done && right_done) break;
    if (!left.closed && (left_done || right_done)) break;
    const Rung by_left{std::min(left_end, next.left_s_m + kRungStep_m), next.right_s_m},
        by_right{next.left_s_m, std::min(right_end, next.right_s_m + kRungStep_m)};
    const auto length = [&](const Rung& r) {
      return (left.at(r.left_s_m) - right.at(r.right_s_m)).head<2>().norm();
    };
    next = left_done                             ? by_right
           : right_done                          ? by_left
           : length(by_left) <= length(by_right) ? by_left
                                                 : by_right;
    if (const double wide = length(next); !(wide <= kWidest_m)) {
      throw Error(
          fmt::format("the edges lie {:.0f} m apart {:.0f} m after the start of {}; wanted two "
                      "edges of one road, "
                      "at most {:.0f} m wide: are both files of one track, and complete?",
                      wide, next.left_s_m, left.path, kWidest_m));
    }
    rungs.push_back(next);
  }
  return rungs;
}

Centreline along(const EdgeCurve& left, const EdgeCurve& right, const std::vector<Rung>& rungs) {
  Centreline centreline;
  centreline.closed = left.closed;
  for (const Rung& rung : rungs) {
    const Vector3d l = left.at(rung.left_s_m), r = right.at(rung.right_s_m), middle = 0.5 * (l + r);
    auto& points = centreline.points_m;
    const double step = points.empty() ? kStationStep_m : (middle - points.back()).head<2>().norm();
    const bool round = centreline.closed && points.size() > 3 && &rung == &rungs.back();
    if (round || step < kStationStep_m) continue;
    points.push_back(middle);
    centreline.half_width_m.push_back(0.5 * (l - r).head<2>().norm());
    centreline.length_m += points.size() > 1 ? step : 0.0;
  }
  auto& points = centreline.points_m;
  while (centreline.closed && points.size() > 4 &&
         (points.back() - points.front()).head<2>().norm() < 0.5 * kStationStep_m) {
    points.pop_back();
    centreline.half_width_m.pop_back();
  }
  return centreline;
}

/// A place on the line or straight on beyond it; u from its first node.
struct Pose {
  Vector2d at, heading;
};

Pose pose(const crg::ReferenceLine& line, double u) {
  if (line.closed) {
    const double length = line.u_step_m * static_cast<double>(line.size() - 1);
    u -= std::floor(u / length) * length;
  }
  const double position = u / line.u_step_m;
  const auto i =
      static_cast<std::size_t>(std::clamp(position, 0.0, static_cast<double>(line.size() - 2)));
  const double t = position - static_cast<double>(i);
  const Vector2d a(line.x_m[i], line.y_m[i]), b(line.x_m[i + 1], line.y_m[i + 1]);
  const double h0 = line.heading_rad[i + 1];  // of this segment
  const bool inside = t >= 0.0 && t <= 1.0;
  double before = h0, after = h0;
  if (i > 0)
    before = line.heading_rad[i];
  else if (line.closed)
    before = h0 - std::remainder(h0 - line.heading_rad.back(), 2.0 * std::numbers::pi);
  if (i + 2 < line.size())
    after = line.heading_rad[i + 2];
  else if (line.closed)
    after = h0 + std::remainder(line.heading_rad[1] - h0, 2.0 * std::numbers::pi);
  const double heading = !inside   ? h0
                         : t < 0.5 ? h0 + (before - h0) * (0.5 - t)
                                   : h0 + (after - h0) * (t - 0.5);
  return {a + t * (b - a), {std::cos(heading), std::sin(heading)}};
}

/// u of the place whose normal goes through p, searched from u_guess.
double beside(const crg::ReferenceLine& line, const Vector2d& p, double u_guess) {
  double u = u_guess;
  for (int i = 0; i < 50; ++i) {
    const Pose here = pose(line, u);
    const double step = std::clamp((p - here.at).dot(here.heading), -5.0, 5.0);
    u += step;
    if (std::abs(step) < 1e-7) break;
  }
  return u;
}

/// Both edges as met by one normal.
struct CrossSection {
  EdgeMeeting left, right;
};

CrossSection cut(const EdgeCurve& left, const EdgeCurve& right, const Rung& guess,
                 const Vector2d& at, const Vector2d& normal) {
  return {meet_edge(left, guess.left_s_m, kReach_m, at, normal),
          meet_edge(right, guess.right_s_m, kReach_m, at, normal)};
}

void refuse_missed(const CrossSection& section, const EdgeCurve& left, const EdgeCurve& right,
                   double u) {
  if (section.left.found && section.right.found) return;
  throw Error(
      fmt::format("{}: the edge does not run beside the road at u = {:.1f} m; wanted both edges "
                  "all along: a piece "
                  "may be missing, or a point far off",
                  (section.left.found ? right : left).path, u));
}

/// Stations where the normals of `line` meet both edges, from the first row of LEFT on.
Centreline recut(const EdgeCurve& left, const EdgeCurve& right, const crg::ReferenceLine& line,
                 Rung guess) {
  const double u_begin =
      beside(line, left.at(0.0).head<2>(), 0.0) - (left.closed ? kSeamMargin_m : 0.0);
  const double length = line.u_step_m * static_cast<double>(line.size() - 1);
  double u_end = u_begin + length;
  if (!left.closed) {
    u_end = std::min(beside(line, left.at(left.length_m).head<2>(), length),
                     beside(line, right.at(right.length_m).head<2>(), length));
  }
  const auto count =
      static_cast<std::size_t>(std::max(4.0, std::round((u_end - u_begin) / kStationStep_m)));
  Centreline out;
  out.closed = left.closed;
  for (std::size_t k = 0; k < (out.closed ? count : count + 1); ++k) {
    const double u =
        u_begin + (u_end - u_begin) * static_cast<double>(k) / static_cast<double>(count);
    const Pose here = pose(line, u);
    const Vector2d normal(-here.heading.y(), here.heading.x());
    const CrossSection section = cut(left, right, guess, here.at, normal);
    refuse_missed(section, left, right, u - u_begin);
    guess = {section.left.s_m, section.right.s_m};
    const Vector2d middle = here.at + 0.5 * (section.left.v_m + section.right.v_m) * normal;
    if (!out.points_m.empty()) out.length_m += (middle - out.points_m.back().head<2>()).norm();
    out.points_m.emplace_back(middle.x(), middle.y(), 0.5 * (section.left.z_m + section.right.z_m));
    out.half_width_m.push_back(0.5 * (section.left.v_m - section.right.v_m));
  }
  if (out.closed) out.length_m += (out.points_m.front() - out.points_m.back()).head<2>().norm();
  return out;
}

/// Columns: even ones, finer where an edge moves, and one exactly where an edge stays.
std::vector<double> columns_for(std::vector<double> left_m, std::vector<double> right_m,
                                double v_step_m) {
  std::vector<double> exact, fine;
  for (std::vector<double>* side : {&left_m, &right_m}) {
    std::sort(side->begin(), side->end());
    const double band = side->back() - side->front();
    const auto pieces =
        static_cast<int>(std::clamp(std::ceil(band / (0.25 * v_step_m)), 1.0, 400.0));
    for (int k = 0; k <= pieces; ++k) fine.push_back(side->front() + band * k / pieces);
    const auto wanted = std::max<std::size_t>(
        2, static_cast<std::size_t>(kSteadyShare * static_cast<double>(side->size())));
    for (std::size_t i = 0; i + wanted <= side->size();) {
      std::size_t end = i;
      while (end < side->size() && (*side)[end] - (*side)[i] <= kColumnTolerance_m) ++end;
      if (end - i < wanted) {
        ++i;
        continue;
      }
      // It stands for all that is near it, so that the next is further away than what a file may
      // hold.
      exact.push_back((*side)[(i + end) / 2]);
      while (i < side->size() && (*side)[i] <= exact.back() + kColumnTolerance_m) ++i;
    }
  }
  std::vector<double> columns = exact;
  const auto add = [&](double v) {
    const bool near = std::any_of(columns.begin(), columns.end(),
                                  [&](double c) { return std::abs(c - v) < kFinestColumn_m; });
    if (!near) columns.push_back(v);
  };
  for (const double v : fine) add(v);
  const auto first = static_cast<int>(std::ceil(right_m.front() / v_step_m)),
             last = static_cast<int>(std::floor(left_m.back() / v_step_m));
  for (int j = first; j <= last; ++j) add(j * v_step_m);
  std::sort(columns.begin(), columns.end());
  return columns;
}

void refuse_narrow(const std::vector<CrossSection>& sections, double u_step_m, double least_m) {
  std::size_t first = sections.size(), last = 0;
  double narrowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const double width = sections[i].left.v_m - sections[i].right.v_m;
    if (width >= least_m) {
      if (first < sections.size()) break;
      continue;
    }
    first = std::min(first, i);
    last = i;
    narrowest = std::min(narrowest, width);
  }
  if (first == sections.size()) return;
  const double from = u_step_m * static_cast<double>(first),
               to = u_step_m * static_cast<double>(last);
  if (narrowest <= 0.0) {
    throw Error(
        fmt::format("the edges cross: from u = {:.1f} to {:.1f} m the left edge lies up to {:.2f} "
                    "m to the right of the "
                    "right one; look at both files there",
                    from, to, -narrowest));
  }
  throw Error(
      fmt::format("from u = {:.1f} to {:.1f} m the road is down to {:.3f} m wide; wanted at least "
                  "two steps across, "
                  "{} m; take a smaller --v-step-m or look at the edges there",
                  from, to, narrowest, least_m));
}

/// Distance of the given points from the polyline of the rows' edge.
void point_errors(const EdgeCurve& curve, const std::vector<Vector2d>& rows,
                  const std::vector<double>& s_m, bool closed, std::vector<double>& errors) {
  for (std::size_t k = 0; k < curve.given_m.size(); ++k) {
    double s = curve.s_of_given_m[k];
    if (closed && s < s_m.front()) s += curve.length_m;
    const auto next = std::upper_bound(s_m.begin(), s_m.end(), s);
    if (next == s_m.begin() || next == s_m.end())
      continue;  // before the first or after the last row
    const auto i = static_cast<std::size_t>(next - s_m.begin()) - 1;
    const Vector2d p = curve.given_m[k].head<2>() - rows[i], along = rows[i + 1] - rows[i];
    const double t = std::clamp(p.dot(along) / std::max(along.squaredNorm(), 1e-18), 0.0, 1.0);
    errors.push_back((p - t * along).norm());
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

}  // namespace

EdgeRoad road_between_edges(const Edge& left_edge, const Edge& right_edge,
                            const EdgeOptions& options, EdgesReport* report) {
  EdgesReport result;
  const EdgeCurve left = edge_curve(left_edge);
  EdgeCurve right = edge_curve(right_edge);
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

  const std::vector<Rung> rungs = climb(left, right, relation.right_s_at_start_m);
  constexpr double kDraftStep_m = 0.5;
  EdgeRoad road;
  road.centreline = along(left, right, rungs);
  // Each round turns the normals a little; the middle moves by less than 0.1 mm after three.
  for (int round = 0; round < 4; ++round) {
    const crg::ReferenceLine draft = fit_reference_line(road.centreline, {kDraftStep_m});
    road.centreline = recut(left, right, draft, rungs.front());
  }
  road.line = fit_reference_line(road.centreline, {options.u_step_m});
  const crg::ReferenceLine& line = road.line;

  // Rows.
  const std::size_t rows = line.size();
  std::vector<CrossSection> sections(rows);
  std::vector<char> folded(rows, 0);
  std::vector<Vector2d> left_xy, right_xy;
  std::vector<double> left_s, right_s, left_v, right_v;
  Rung guess = rungs.front();
  for (std::size_t i = 0; i < rows; ++i) {
    const crg::Point2 p = crg::node_position(line, i, 0.0), q = crg::node_position(line, i, 1.0);
    const Vector2d at(p.x_m, p.y_m), normal(q.x_m - p.x_m, q.y_m - p.y_m);
    CrossSection& section = sections[i];
    section = cut(left, right, guess, at, normal);
    refuse_missed(section, left, right, line.u_step_m * static_cast<double>(i));
    guess = {section.left.s_m, section.right.s_m};
    left_xy.push_back(at + section.left.v_m * normal);
    right_xy.push_back(at + section.right.v_m * normal);
    left_s.push_back(section.left.s_m);
    right_s.push_back(section.right.s_m);
  }
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
  refuse_narrow(sections, line.u_step_m, 2.0 * options.v_step_m);
  for (const CrossSection& section : sections) {
    left_v.push_back(section.left.v_m);
    right_v.push_back(section.right.v_m);
  }

  crg::Grid& grid = road.sampled.grid;
  grid.u_begin_m = line.u_begin_m;
  grid.u_step_m = line.u_step_m;
  grid.v_m = columns_for(left_v, right_v, options.v_step_m);
  const std::size_t columns = grid.v_m.size();
  if (static_cast<double>(rows) * static_cast<double>(columns) >
      static_cast<double>(options.max_nodes)) {
    throw Error(
        fmt::format("the grid would have {:.3g} nodes, more than the limit of {:.3g}; take larger "
                    "steps (--u-step-m, "
                    "--v-step-m)",
                    static_cast<double>(rows) * static_cast<double>(columns),
                    static_cast<double>(options.max_nodes)));
  }
  grid.z_m.assign(rows * columns, std::numeric_limits<float>::quiet_NaN());
  road.sampled.provenance.assign(rows * columns, Provenance::none);
  road.sampled.surface_class.assign(rows * columns, SurfaceClass::road);
  std::vector<double> gaps, widths, errors;
  for (std::size_t i = 0; i < rows; ++i) {
    // The last row of a closed line stands for the first.
    const CrossSection& section = sections[line.closed && i + 1 == rows ? 0 : i];
    const double from = section.right.v_m, to = section.left.v_m;
    const auto begin =
        std::lower_bound(grid.v_m.begin(), grid.v_m.end(), from - kColumnTolerance_m) -
        grid.v_m.begin();
    const auto end = std::upper_bound(grid.v_m.begin(), grid.v_m.end(), to + kColumnTolerance_m) -
                     grid.v_m.begin();
    for (auto j = static_cast<std::size_t>(begin); j < static_cast<std::size_t>(end); ++j) {
      const double share = (grid.v_m[j] - from) / (to - from);
      grid.at(i, j) =
          static_cast<float>(section.right.z_m + share * (section.left.z_m - section.right.z_m));
      road.sampled.provenance[i * columns + j] = Provenance::mesh;
    }
    gaps.push_back(std::max(0.0, grid.v_m[static_cast<std::size_t>(begin)] - from));
    gaps.push_back(std::max(0.0, to - grid.v_m[static_cast<std::size_t>(end) - 1]));
    widths.push_back(to - from);
  }
  point_errors(left, left_xy, left_s, line.closed, errors);
  point_errors(right, right_xy, right_s, line.closed, errors);

  result.left_points = left_edge.points_m.size();
  result.right_points = right_edge.points_m.size();
  result.dropped_points = left.dropped + right.dropped;
  result.closed = line.closed;
  result.has_z = left_edge.has_z;
  const auto quantile = [](const std::vector<double>& values, double share) {
    return values.empty() ? 0.0 : base::quantile(values, share);
  };
  result.width_min_m = quantile(widths, 0.0);
  result.width_median_m = quantile(widths, 0.5);
  result.width_max_m = quantile(widths, 1.0);
  result.point_error_p99_m = quantile(errors, 0.99);
  result.point_error_max_m = quantile(errors, 1.0);
  result.edge_gap_median_m = quantile(gaps, 0.5);
  result.edge_gap_max_m = quantile(gaps, 1.0);
  result.start_offset_m =
      (left.at(0.0).head<2>() - Vector2d(line.x_m[0], line.y_m[0]))
          .dot(Vector2d(std::cos(line.heading_rad[0]), std::sin(line.heading_rad[0])));
  result.folds = ranges_of(folded, line.u_step_m);
  std::vector<double> middle_z_m;
  for (const CrossSection& section : sections)
    middle_z_m.push_back(0.5 * (section.left.z_m + section.right.z_m));
  for (const Crossing& crossing : find_crossings(line, middle_z_m))
    result.remarks.push_back(describe(crossing));
  for (const EdgeCurve* curve : {&left, static_cast<const EdgeCurve*>(&right)}) {
    result.remarks.insert(result.remarks.end(), curve->remarks.begin(), curve->remarks.end());
    if (line.closed) continue;
    const double used_to = curve == &left ? left_s.back() : right_s.back(),
                 used_from = curve == &left ? left_s.front() : right_s.front();
    const double rest = curve->length_m - used_to;
    if (rest > 1.0)
      result.remarks.push_back(fmt::format(
          "{}: the last {:.1f} m have no other edge beside them; left out", curve->path, rest));
    if (used_from < -0.5)
      result.remarks.push_back(fmt::format(
          "{}: begins {:.1f} m after the other edge; continued straight", curve->path, -used_from));
    if (used_from < -result.width_max_m) {
      throw Error(
          fmt::format("{}: begins {:.1f} m after the first row of the left edge; wanted at most "
                      "one width of the road, {:.1f} m",
                      curve->path, -used_from, result.width_max_m));
    }
  }
  if (report != nullptr) *report = std::move(result);
  return road;
}

}  // namespace road
