// The smooth interpolant: cubic Hermite along v, then along u, with slopes at the nodes from the
// parabola through a node and its two neighbours (Catmull-Rom where the spacing is even). At the
// edge of the road, where a neighbour is missing, the slope is that of the last interval.
#include <cmath>

#include "height.h"

namespace crg {
namespace {

struct Curve {
  double value, derivative;  // derivative by the length of the interval's unit
};

// Between b and c, which lie h apart; a lies ha before b, d lies hd behind c. NaN neighbours are
// continued in a straight line.
Curve hermite(double a, double b, double c, double d, double ha, double h, double hd, double t) {
  const double step = (c - b) / h;
  const auto slope_at = [](double before, double after, double h_before, double h_after) {
    return (before * h_after + after * h_before) / (h_before + h_after);
  };
  const double slope_b = std::isnan(a) ? step : slope_at((b - a) / ha, step, ha, h);
  const double slope_c = std::isnan(d) ? step : slope_at(step, (d - c) / hd, h, hd);
  const double t2 = t * t, t3 = t2 * t;
  const double value = (2.0 * t3 - 3.0 * t2 + 1.0) * b + (t3 - 2.0 * t2 + t) * h * slope_b +
                       (3.0 * t2 - 2.0 * t3) * c + (t3 - t2) * h * slope_c;
  const double derivative = 6.0 * (t2 - t) * step * -1.0 + (3.0 * t2 - 4.0 * t + 1.0) * slope_b +
                            (3.0 * t2 - 2.0 * t) * slope_c;
  return {value, derivative};
}

}  // namespace

Height HeightField::smooth_grid_height(const GridPlace& p) const noexcept {
  const double nan = Sample::kNaN;
  const double h = v_step_m(p.column);
  const double before = p.column > 0 ? v_step_m(p.column - 1) : h;
  const double after = p.column + 2 < columns_ ? v_step_m(p.column + 1) : h;
  const auto along_v = [&](std::size_t row) -> Curve {
    const float* z = node(row, p.column);
    const double a = p.column > 0 ? static_cast<double>(z[-1]) : nan;
    const double d = p.column + 2 < columns_ ? static_cast<double>(z[2]) : nan;
    if (p.fv == 0.0 && std::isnan(z[1])) return {z[0], 0.0};
    if (p.fv == 1.0 && std::isnan(z[0])) return {z[1], 0.0};
    return hermite(a, z[0], z[1], d, before, h, after, p.fv);
  };
  const Curve low = along_v(p.row), high = along_v(p.row + 1);
  if (p.fu == 0.0 && std::isnan(high.value)) return {low.value, 0.0, low.derivative};
  if (p.fu == 1.0 && std::isnan(low.value)) return {high.value, 0.0, high.derivative};
  Curve first{nan, nan}, last{nan, nan};
  if (p.row > 0) first = along_v(p.row - 1);
  if (p.row + 2 < rows_) last = along_v(p.row + 2);
  if (joined_ && p.row == 0) first = along_v(rows_ - 2);
  if (joined_ && p.row + 2 == rows_) last = along_v(1);
  const double step = u_step_m_;
  const Curve z = hermite(first.value, low.value, high.value, last.value, step, step, step, p.fu);
  // d/dv runs through the same weights along u.
  const bool open_first = std::isnan(first.value), open_last = std::isnan(last.value);
  const Curve dzdv = hermite(open_first ? nan : first.derivative, low.derivative, high.derivative,
                             open_last ? nan : last.derivative, step, step, step, p.fu);
  return {z.value, z.derivative, dzdv.value};
}

void HeightField::add_smooth_line(Height& height, std::size_t row, double fu,
                                  double v_m) const noexcept {
  const auto along_u = [&](double LineNode::*part) -> Curve {
    double first = Sample::kNaN, last = Sample::kNaN;
    if (row > 0) first = line_[row - 1].*part;
    if (row + 2 < rows_) last = line_[row + 2].*part;
    if (joined_ && row == 0) first = line_[rows_ - 2].*part;
    if (joined_ && row + 2 == rows_) last = line_[1].*part;
    return hermite(first, line_[row].*part, line_[row + 1].*part, last, u_step_m_, u_step_m_,
                   u_step_m_, fu);
  };
  const Curve z = along_u(&LineNode::z_m), banking = along_u(&LineNode::banking);
  height.z_m += z.value + banking.value * v_m;
  height.dzdu += z.derivative + banking.derivative * v_m;
  height.dzdv += banking.value;
}

}  // namespace crg
