#include "height.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "crg/huge_pages.h"
#include "line_geometry.h"

namespace crg {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kEdge = 1e-9;  // in cells: beyond the border by more than rounding

// One coordinate brought into its range [begin, begin + length] by the border mode.
struct Folded {
  double value;
  double sign = 1.0;  // of the derivative: -1 in mirrored copies
};

Folded fold(double value, double begin, double length, BorderMode mode) {
  const double offset = value - begin;
  if (mode == BorderMode::Repeat && (offset < 0.0 || offset > length)) {
    return {begin + (offset - length * std::floor(offset / length))};
  }
  if (mode == BorderMode::Reflect && (offset < 0.0 || offset > length)) {
    const double twice = offset - 2.0 * length * std::floor(offset / (2.0 * length));
    return twice > length ? Folded{begin + (2.0 * length - twice), -1.0} : Folded{begin + twice};
  }
  return {value};
}

}  // namespace

HeightField::HeightField(const Grid& grid, const ReferenceLine& line, const Options& options,
                         Interpolation interpolation)
    : z_m_(grid.z_m.data()),
      v_m_(grid.v_m),
      options_(options),
      interpolation_(interpolation),
      rows_(grid.rows()),
      columns_(grid.columns()),
      last_column_(static_cast<std::ptrdiff_t>(grid.columns()) - 2),
      last_row_(static_cast<std::ptrdiff_t>(grid.rows()) - 2),
      ahead_bytes_{static_cast<std::ptrdiff_t>(12 * grid.columns() * sizeof(float)),
                   -static_cast<std::ptrdiff_t>(12 * grid.columns() * sizeof(float))},
      u_begin_m_(grid.u_begin_m),
      u_end_m_(grid.u_of(grid.rows() - 1)),
      u_step_m_(grid.u_step_m),
      per_u_step_(1.0 / grid.u_step_m),
      v_right_m_(grid.v_m.front()),
      v_left_m_(grid.v_m.back()),
      joined_(ends_joined(line)),
      plain_(options.smooth_begin_m == 0.0 && options.smooth_end_m == 0.0) {
  reserve_huge(line_, rows_);
  for (std::size_t i = 0; i < rows_; ++i) {
    line_.push_back(
        {line.z_m.empty() ? 0.0 : line.z_m[i], line.banking.empty() ? 0.0 : line.banking[i]});
  }
  const double step = (v_left_m_ - v_right_m_) / static_cast<double>(columns_ - 1);
  bool uniform = true;
  for (std::size_t j = 0; j < columns_; ++j) {
    uniform &= std::abs(v_right_m_ + static_cast<double>(j) * step - v_m_[j]) < 1e-9 * step;
  }
  if (uniform) {
    v_step_m_ = step;
    per_v_step_ = 1.0 / step;
  }
  simple_ = plain_ && uniform && interpolation_ == Interpolation::Bilinear;
  if (line.closed) {
    const Closing closing = closing_of(line);
    wrap_begin_m_ = u_begin_m_ - closing.before_start_m;
    period_m_ = u_end_m_ + closing.after_end_m - wrap_begin_m_;
  }
  simple_end_m_ = period_m_ > 0.0 ? std::min(u_end_m_, wrap_begin_m_ + period_m_) : u_end_m_;
}

double HeightField::wrap_u(double u_m) const noexcept {
  if (period_m_ <= 0.0) return u_m;
  const double offset = u_m - wrap_begin_m_;
  if (offset >= 0.0 && offset < period_m_) return u_m;
  return wrap_begin_m_ + (offset - period_m_ * std::floor(offset / period_m_));
}

GridPlace HeightField::place_uneven(std::size_t row, double fu, double v_m) const noexcept {
  const auto above = std::upper_bound(v_m_.begin() + 1, v_m_.end() - 1, v_m);
  const std::size_t column = static_cast<std::size_t>(above - v_m_.begin()) - 1;
  return {row, column, fu, (v_m - v_m_[column]) / (v_m_[column + 1] - v_m_[column])};
}

// A cell with NaN nodes: those without weight do not count, so that a NaN beside the edge of the
// road does not reach onto it.
Height HeightField::edge_height(const GridPlace& p) const noexcept {
  const float* nodes = node(p.row, p.column);
  double z00 = nodes[0], z01 = nodes[1], z10 = nodes[columns_], z11 = nodes[columns_ + 1];
  if (p.fu == 0.0) z10 = z00, z11 = z01;
  if (p.fu == 1.0) z00 = z10, z01 = z11;
  if (p.fv == 0.0) z01 = z00, z11 = z10;
  if (p.fv == 1.0) z00 = z01, z10 = z11;
  const double low = z00 + p.fv * (z01 - z00);
  const double high = z10 + p.fv * (z11 - z10);
  return {low + p.fu * (high - low), (high - low) * per_u_step_,
          ((1.0 - p.fu) * (z01 - z00) + p.fu * (z11 - z10)) / v_step_m(p.column)};
}

Height HeightField::grid_height(const GridPlace& p) const noexcept {
  if (interpolation_ != Interpolation::Bilinear) return smooth_grid_height(p);
  const float* low = node(p.row, p.column);
  const float* high = low + columns_;
  const double step0 = static_cast<double>(low[1]) - low[0];
  const double step1 = static_cast<double>(high[1]) - high[0];
  const double z0 = low[0] + p.fv * step0;
  const double z1 = high[0] + p.fv * step1;
  const double z = z0 + p.fu * (z1 - z0);
  if (std::isnan(z)) return edge_height(p);
  return {z, (z1 - z0) * per_u_step_, (step0 + p.fu * (step1 - step0)) / v_step_m(p.column)};
}

void HeightField::add_line(Height& height, std::size_t row, double fu, double v_m) const noexcept {
  if (interpolation_ != Interpolation::Bilinear) return add_smooth_line(height, row, fu, v_m);
  const LineNode low = line_[row], high = line_[row + 1];
  const double rise = high.z_m - low.z_m, change = high.banking - low.banking;
  const double banking = low.banking + fu * change;
  height.z_m += low.z_m + fu * rise;
  height.z_m += banking * v_m;
  height.dzdu += (rise + change * v_m) * per_u_step_;
  height.dzdv += banking;
}

Height HeightField::on_grid(std::size_t row, double fu, double v_m) const noexcept {
  Height height = grid_height(place(row, fu, v_m));
  add_line(height, row, fu, v_m);
  return height;
}

Height HeightField::at(double u_m, double v_m) const noexcept {
  if (!std::isfinite(u_m) || !std::isfinite(v_m)) return {kNaN, kNaN, kNaN};
  const Folded u = fold(wrap_u(u_m), u_begin_m_, u_end_m_ - u_begin_m_, options_.border_mode_u);
  const Folded v = fold(v_m, v_right_m_, v_left_m_ - v_right_m_, options_.border_mode_v);

  const double rows = (u.value - u_begin_m_) / u_step_m_;
  const std::size_t row =
      static_cast<std::size_t>(std::clamp(rows, 0.0, static_cast<double>(rows_ - 2)));
  const double fu = std::clamp(rows - static_cast<double>(row), 0.0, 1.0);
  GridPlace p = place(row, fu, v.value);
  const double beyond = kEdge * v_step_m(p.column);
  const bool beyond_u = rows < -kEdge || rows > static_cast<double>(rows_ - 1) + kEdge;
  const bool beyond_v = v.value < v_right_m_ - beyond || v.value > v_left_m_ + beyond;
  if ((beyond_u && options_.border_mode_u == BorderMode::None) ||
      (beyond_v && options_.border_mode_v == BorderMode::None)) {
    return {kNaN, kNaN, kNaN};
  }
  p.fv = std::clamp(p.fv, 0.0, 1.0);
  Height height = grid_height(p);
  // Banking ends at the sides of the grid, also where the grid repeats beyond them.
  const double clipped = std::clamp(v_m, v_right_m_, v_left_m_);
  const double dzdv_grid = height.dzdv;
  add_line(height, row, fu, clipped);
  double& z = height.z_m;
  double& dzdu = height.dzdu;
  double& dzdv = height.dzdv;
  // The sign of mirrored copies is applied below to the sum, but banking is not mirrored.
  dzdv = dzdv_grid + (clipped == v_m ? v.sign * (dzdv - dzdv_grid) : 0.0);
  if (beyond_u) {
    z = (options_.border_mode_u == BorderMode::Zero ? 0.0 : z) + options_.border_offset_u_m;
    dzdu = 0.0;
    if (options_.border_mode_u == BorderMode::Zero) dzdv = 0.0;
  }
  if (beyond_v) {
    z = (options_.border_mode_v == BorderMode::Zero ? 0.0 : z) + options_.border_offset_v_m;
    dzdv = 0.0;
    if (options_.border_mode_v == BorderMode::Zero) dzdu = 0.0;
  }
  const auto smooth = [&](double inside_m, double zone_m, double level_m, double direction) {
    if (!(zone_m > 0.0 && inside_m < zone_m)) return;
    const double share = std::max(0.0, inside_m) / zone_m;
    dzdu = share * dzdu + (inside_m > 0.0 ? direction * (z - level_m) / zone_m : 0.0);
    dzdv *= share;
    z = level_m + share * (z - level_m);
  };
  smooth(u.value - u_begin_m_, options_.smooth_begin_m, line_.front().z_m, 1.0);
  smooth(u_end_m_ - u.value, options_.smooth_end_m, line_.back().z_m, -1.0);
  return {z, u.sign * dzdu, v.sign * dzdv};
}

}  // namespace crg
