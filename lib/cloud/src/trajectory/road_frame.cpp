#include "cloud/road_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloud {
namespace {

constexpr int kFastSteps = 8;

}  // namespace

RoadFrame::RoadFrame(const crg::Crg& road) {
  const crg::Surface surface(road);
  const crg::ReferenceLine& line = surface.reference_line();
  const crg::Grid& grid = surface.grid();
  u_begin_m_ = grid.u_begin_m;
  u_step_m_ = grid.u_step_m;
  closed_ = line.closed;
  v_m_ = grid.v_m;
  const std::size_t n = line.x_m.size();
  rows_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    // The mitre tangent of the standard; on a closed road the seam is no end.
    const std::size_t before = i > 0     ? i - 1
                               : closed_ ? n - 2
                                         : 0,
                      after = i + 1 < n ? i + 1
                              : closed_ ? 1
                                        : n - 1;
    const Eigen::Vector2d t =
        Eigen::Vector2d(line.x_m[after] - line.x_m[before], line.y_m[after] - line.y_m[before])
            .normalized();
    rows_[i] = {line.x_m[i], line.y_m[i], t.x(), t.y()};
  }
  z_origin_m_ = line.z_m.empty() ? 0.0 : line.z_m.front();
  z_m_.resize(n * v_m_.size());
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < v_m_.size(); ++j)
      z_m_[i * v_m_.size() + j] = static_cast<float>(
          static_cast<double>(grid.at(i, j)) + (line.z_m.empty() ? 0.0 : line.z_m[i]) +
          (line.banking.empty() ? 0.0 : line.banking[i] * v_m_[j]) - z_origin_m_);
  const auto cells = static_cast<std::size_t>((v_m_.back() - v_m_.front()) / table_step_m_) + 1;
  column_table_.resize(cells);
  std::size_t column = 0;
  for (std::size_t k = 0; k < cells; ++k) {
    while (column + 2 < v_m_.size() &&
           v_m_[column + 1] <= v_m_.front() + static_cast<double>(k) * table_step_m_)
      ++column;
    column_table_[k] = static_cast<std::uint32_t>(column);
  }
}

Eigen::Vector2d RoadFrame::node_position(std::size_t row, double v_m) const {
  const Row& at = rows_[row];
  return {at.x_m - v_m * at.ty, at.y_m + v_m * at.tx};
}

double RoadFrame::heading_rad(double row) const {
  const auto i = static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(rows() - 1)));
  return std::atan2(rows_[i].ty, rows_[i].tx);
}

Eigen::Vector2d RoadFrame::ahead(double row) const {
  const auto i = static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(rows() - 1)));
  return {rows_[i].tx, rows_[i].ty};
}

double RoadFrame::wrapped(double row) const {
  const auto period = static_cast<double>(rows() - 1);
  if (!closed_ || (row >= 0.0 && row < period)) return row;
  row = std::fmod(row, period);
  return row < 0.0 ? row + period : row;
}

std::optional<GridPlace> RoadFrame::project(double x_m, double y_m, double hint) const {
  const auto last = static_cast<std::ptrdiff_t>(rows()) - 2;  // of the segments
  auto i = static_cast<std::ptrdiff_t>(wrapped(hint));
  i = std::clamp<std::ptrdiff_t>(i, 0, last);
  for (int step = 0; step < 60; ++step) {
    const auto k = static_cast<std::size_t>(i);
    const Row &here = rows_[k], &next = rows_[k + 1];
    const double dx = x_m - here.x_m, dy = y_m - here.y_m;
    const double a = dx * here.tx + dy * here.ty;
    const double b = (x_m - next.x_m) * next.tx + (y_m - next.y_m) * next.ty;
    if (a >= 0.0 && b < 0.0) {
      const double f = a / (a - b);
      const double px = dx - f * (next.x_m - here.x_m), py = dy - f * (next.y_m - here.y_m);
      const double nx = -(here.ty + f * (next.ty - here.ty)),
                   ny = here.tx + f * (next.tx - here.tx);
      return GridPlace{static_cast<double>(i) + f, (px * nx + py * ny) / (nx * nx + ny * ny)};
    }
    // Far away the tangent tells how many segments to go, on a straight exactly. Where that does
    // not settle, as inside of a tight bend, less than it says; near, one at a time.
    const double way = step < kFastSteps ? a : 0.9 * (a < 0.0 ? a : b);
    auto jump = static_cast<std::ptrdiff_t>(way / u_step_m_);
    if (step < kFastSteps && a < 0.0) --jump;
    if (jump == 0) jump = a < 0.0 ? -1 : 1;
    i += jump;
    if (closed_) {
      // A division takes as long as all else here, and is hardly ever wanted.
      if (i < 0 || i > last) i %= last + 1;
      if (i < 0) i += last + 1;
    } else if (i < 0 || i > last) {
      if ((i < 0 && k == 0) || (i > last && static_cast<std::ptrdiff_t>(k) == last))
        return std::nullopt;
      i = std::clamp<std::ptrdiff_t>(i, 0, last);
    }
  }
  return std::nullopt;
}

double RoadFrame::nearest_row(double x_m, double y_m) const {
  double best = std::numeric_limits<double>::infinity();
  std::size_t row = 0;
  for (std::size_t i = 0; i < rows(); ++i) {
    const double dx = rows_[i].x_m - x_m, dy = rows_[i].y_m - y_m, d = dx * dx + dy * dy;
    if (d < best) best = d, row = i;
  }
  return static_cast<double>(row);
}

double RoadFrame::height_in(double row, std::size_t column, double share) const {
  if (!(row >= 0.0) || row > static_cast<double>(rows() - 1))
    return std::numeric_limits<double>::quiet_NaN();
  const auto i =
      std::min(static_cast<std::ptrdiff_t>(row), static_cast<std::ptrdiff_t>(rows()) - 2);
  const double f = row - static_cast<double>(i), g = share;
  const float* const z = z_m_.data() + static_cast<std::size_t>(i) * v_m_.size() + column;
  const float* const next = z + v_m_.size();
  return (1.0 - f) * ((1.0 - g) * static_cast<double>(z[0]) + g * static_cast<double>(z[1])) +
         f * ((1.0 - g) * static_cast<double>(next[0]) + g * static_cast<double>(next[1]));
}

double RoadFrame::height(const GridPlace& place) const {
  std::size_t column = 0;
  double share = 0.0;
  return column_of(place.v_m, column, share) ? height_in(place.row, column, share)
                                             : std::numeric_limits<double>::quiet_NaN();
}

Eigen::Vector2d RoadFrame::gradient(const GridPlace& place, double reach_m) const {
  const double reach_rows = reach_m / u_step_m_;
  const auto k = static_cast<std::size_t>(place.row);
  // Rows are nearer to each other on the inside of a bend.
  const std::size_t k1 = std::min(k + 1, rows() - 1);
  const Eigen::Vector2d step = node_position(k1, place.v_m) - node_position(k1 - 1, place.v_m);
  const double shrink = std::max(0.05, step.norm() / u_step_m_);
  std::size_t column = 0;
  double share = 0.0, along = std::numeric_limits<double>::quiet_NaN();
  if (column_of(place.v_m, column, share))
    along = (height_in(wrapped(place.row + reach_rows), column, share) -
             height_in(wrapped(place.row - reach_rows), column, share)) /
            (2.0 * reach_m * shrink);
  const double across =
      (height({place.row, place.v_m + reach_m}) - height({place.row, place.v_m - reach_m})) /
      (2.0 * reach_m);
  const Row& here = rows_[k];
  return {along * here.tx - across * here.ty, along * here.ty + across * here.tx};
}

}  // namespace cloud
