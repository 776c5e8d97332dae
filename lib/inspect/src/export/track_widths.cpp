#include "inspect/track_widths.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "mesh/error.h"

namespace road {
namespace {

double reach_m(const crg::ReferenceLine& line, std::size_t row, double v_m) {
  const crg::Point2 edge = crg::node_position(line, row, v_m);
  return std::hypot(edge.x_m - line.x_m[row], edge.y_m - line.y_m[row]);
}

}  // namespace

std::vector<TrackWidth> track_widths(const crg::ReferenceLine& line, const crg::Grid& grid,
                                     const RoadEdges& edges) {
  if (grid.rows() != line.size() || grid.rows() < 2)
    throw Error(fmt::format("{} rows of heights, {} nodes of the line: want as many, at least 2",
                            grid.rows(), line.size()));
  const auto& v_m = grid.v_m;
  if (v_m.front() > 0.0 || v_m.back() < 0.0)
    throw Error(fmt::format("columns from v = {:.3f} to {:.3f} m: want some on both sides of v = 0",
                            v_m.front(), v_m.back()));
  // The columns on either side of the line; one and the same where a column lies on it.
  const auto begin = v_m.begin();
  const auto left = static_cast<std::size_t>(std::lower_bound(begin, v_m.end(), 0.0) - begin);
  const std::size_t right = v_m[left] == 0.0 ? left : left - 1;
  if (!edges.empty() && (edges.left_m.size() != grid.rows() || edges.right_m.size() != grid.rows()))
    throw Error(
        fmt::format("edges of {} rows seen, {} wanted: summary.json beside the road is not "
                    "its own; take it away",
                    edges.left_m.size(), grid.rows()));
  std::vector<TrackWidth> widths;
  widths.reserve(grid.rows());
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    if (std::isnan(grid.at(row, left)) || std::isnan(grid.at(row, right)))
      throw Error(fmt::format("no road on the reference line at u = {:.3f} m: widths need one",
                              grid.u_of(row)));
    std::size_t l = left, r = right;
    while (l + 1 < grid.columns() && !std::isnan(grid.at(row, l + 1))) ++l;
    while (r > 0 && !std::isnan(grid.at(row, r - 1))) --r;
    double right_v_m = v_m[r], left_v_m = v_m[l];
    if (!edges.empty()) {
      right_v_m = std::max(right_v_m, edges.right_m[row]);
      left_v_m = std::min(left_v_m, edges.left_m[row]);
    }
    widths.push_back({line.x_m[row], line.y_m[row], reach_m(line, row, right_v_m),
                      reach_m(line, row, left_v_m), right_v_m, left_v_m});
  }
  const double gap_m =
      std::hypot(line.x_m.back() - line.x_m.front(), line.y_m.back() - line.y_m.front());
  if (line.closed && gap_m < 0.5 * line.u_step_m) widths.pop_back();
  return widths;
}

std::string track_widths_csv(const std::vector<TrackWidth>& widths) {
  std::string text = "# x_m,y_m,w_tr_right_m,w_tr_left_m\n";
  for (const TrackWidth& w : widths)
    fmt::format_to(std::back_inserter(text), "{:.4f},{:.4f},{:.4f},{:.4f}\n", w.x_m, w.y_m,
                   w.right_m, w.left_m);
  return text;
}

}  // namespace road
