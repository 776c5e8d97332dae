#include "height.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

HeightField::HeightField(const Grid& grid, const ReferenceLine& line, const Options& options)
    : z_m_(grid.z_m.data()),
      v_m_(grid.v_m),
      line_z_m_(line.z_m),
      banking_(line.banking),
      options_(options),
      rows_(grid.rows()),
      columns_(grid.columns()),
      u_begin_m_(grid.u_begin_m),
      u_end_m_(grid.u_of(grid.rows() - 1)),
      u_step_m_(grid.u_step_m) {
  const double step = (v_m_.back() - v_m_.front()) / static_cast<double>(columns_ - 1);
  bool uniform = true;
  for (std::size_t j = 0; j < columns_; ++j) {
    uniform &= std::abs(v_m_.front() + static_cast<double>(j) * step - v_m_[j]) < 1e-9 * step;
  }
  if (uniform) uniform_v_step_m_ = step;
  if (line.closed) {
    const Closing closing = find_closing(line).value_or(Closing{});
    wrap_begin_m_ = u_begin_m_ - closing.before_start_m;
    period_m_ = u_end_m_ + closing.after_end_m - wrap_begin_m_;
  }
}

double HeightField::wrap_u(double u_m) const noexcept {
  if (period_m_ <= 0.0) return u_m;
  const double offset = u_m - wrap_begin_m_;
  if (offset >= 0.0 && offset < period_m_) return u_m;
  return wrap_begin_m_ + (offset - period_m_ * std::floor(offset / period_m_));
}

std::size_t HeightField::column_of(double v_m) const noexcept {
  if (uniform_v_step_m_ > 0.0) {
    const double column = (v_m - v_m_.front()) / uniform_v_step_m_;
    return static_cast<std::size_t>(std::clamp(column, 0.0, static_cast<double>(columns_ - 2)));
  }
  const auto above = std::upper_bound(v_m_.begin() + 1, v_m_.end() - 1, v_m);
  return static_cast<std::size_t>(above - v_m_.begin()) - 1;
}

Height HeightField::at(double u_m, double v_m) const noexcept {
  if (!std::isfinite(u_m) || !std::isfinite(v_m)) return {kNaN, kNaN, kNaN};
  const Folded u = fold(wrap_u(u_m), u_begin_m_, u_end_m_ - u_begin_m_, options_.border_mode_u);
  const Folded v = fold(v_m, v_right_m(), v_left_m() - v_right_m(), options_.border_mode_v);

  const double rows = (u.value - u_begin_m_) / u_step_m_;
  const std::size_t row = static_cast<std::size_t>(std::clamp(rows, 0.0, static_cast<double>(rows_ - 2)));
  const double fu = std::clamp(rows - static_cast<double>(row), 0.0, 1.0);
  const std::size_t column = column_of(v.value);
  const double v_step = v_m_[column + 1] - v_m_[column];
  const double fv = std::clamp((v.value - v_m_[column]) / v_step, 0.0, 1.0);
  const bool beyond_u = rows < -kEdge || rows > static_cast<double>(rows_ - 1) + kEdge;
  const bool beyond_v = v.value < v_right_m() - kEdge * v_step || v.value > v_left_m() + kEdge * v_step;
  if ((beyond_u && options_.border_mode_u == BorderMode::None) ||
      (beyond_v && options_.border_mode_v == BorderMode::None)) {
    return {kNaN, kNaN, kNaN};
  }

  const float* nodes = z_m_ + row * columns_ + column;
  double z00 = nodes[0], z01 = nodes[1], z10 = nodes[columns_], z11 = nodes[columns_ + 1];
  if (std::isnan(z00 + z01 + z10 + z11)) {
    // Nodes with no weight do not count: a NaN beside the edge does not reach onto it.
    if (fu == 0.0) z10 = z00, z11 = z01;
    if (fu == 1.0) z00 = z10, z01 = z11;
    if (fv == 0.0) z01 = z00, z11 = z10;
    if (fv == 1.0) z00 = z01, z10 = z11;
  }
  const double low = (1.0 - fv) * z00 + fv * z01;
  const double high = (1.0 - fv) * z10 + fv * z11;
  double z = (1.0 - fu) * low + fu * high;
  double dzdu = (high - low) / u_step_m_;
  double dzdv = ((1.0 - fu) * (z01 - z00) + fu * (z11 - z10)) / v_step;

  if (!line_z_m_.empty()) {
    const double step = line_z_m_[row + 1] - line_z_m_[row];
    z += line_z_m_[row] + fu * step;
    dzdu += step / u_step_m_;
  }
  if (!banking_.empty()) {
    const double step = banking_[row + 1] - banking_[row];
    const double banking = banking_[row] + fu * step;
    // Banking ends at the sides of the grid, also where the grid repeats beyond them.
    const double clipped = std::clamp(v_m, v_right_m(), v_left_m());
    z += banking * clipped;
    dzdu += step / u_step_m_ * clipped;
    if (clipped == v_m) dzdv += v.sign * banking;  // v.sign is undone below
  }
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
  smooth(u.value - u_begin_m_, options_.smooth_begin_m, line_z_m_.empty() ? 0.0 : line_z_m_.front(), 1.0);
  smooth(u_end_m_ - u.value, options_.smooth_end_m, line_z_m_.empty() ? 0.0 : line_z_m_.back(), -1.0);
  return {z, u.sign * dzdu, v.sign * dzdv};
}

}  // namespace crg
