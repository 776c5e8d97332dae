#include "inspect/track_widths.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "mesh/error.h"

namespace road {
namespace {

double reach_m(const crg::ReferenceLine& line, const crg::Grid& grid, std::size_t row,
               std::size_t column) {
  const crg::Point2 edge = crg::node_position(line, row, grid.v_m[column]);
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
  std::vector<TrackWidth> widths;
  widths.reserve(grid.rows());
  for (std::size_t row = 0; row < grid.rows(); ++row) {
    if (std::isnan(grid.at(row, left)) || std::isnan(grid.at(row, right)))
      throw Error(fmt::format("no road on the reference line at u = {:.3f} m: widths need one",
                              grid.u_of(row)));
    std::size_t l = left, r = right;
    const auto goes_on = [&](std::size_t j) {
      return !std::isnan(grid.at(row, j)) && edges.has(row, v_m[j]);
    };
    while (l + 1 < grid.columns() && goes_on(l + 1)) ++l;
    while (r > 0 && goes_on(r - 1)) --r;
    widths.push_back(
        {line.x_m[row], line.y_m[row], reach_m(line, grid, row, r), reach_m(line, grid, row, l)});
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
