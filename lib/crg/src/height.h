// z(u, v): grid, reference line height and banking, with border modes, offsets and smoothing.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "closing.h"
#include "crg/file.h"
#include "crg/options.h"
#include "crg/surface.h"

namespace crg {

/// Height and its derivatives along u and v; NaN where there is no road.
struct Height {
  double z_m;
  double dzdu, dzdv;
};

/// A place within the grid: cell and fractions, both in [0, 1].
struct GridPlace {
  std::size_t row, column;
  double fu, fv;
};

/// Everything that height needs. Refers to the vectors of a Crg and a ReferenceLine that must
/// outlive it.
class HeightField {
 public:
  HeightField(const Grid& grid, const ReferenceLine& line, const Options& options,
              Interpolation interpolation = Interpolation::Bilinear);

  Height at(double u_m, double v_m) const noexcept;

  /// The same for places known to lie on the grid, where no border matters: row and fu of a u in
  /// range, v within the sections. z0, z1: height of the line at the row and the next.
  Height on_grid(std::size_t row, double fu, double v_m, double z0_m, double z1_m) const noexcept;
  double z_on_grid(std::size_t row, double fu, double v_m, double z0_m, double z1_m) const noexcept;
  /// The same where simple(): bilinear, even columns, no smoothing zones. `node` receives the
  /// address of the cell's first node.
  double z_simple(std::size_t row, double fu, double v_m, double z0_m, double z1_m, const float*& node) const noexcept;
  bool simple() const { return simple_; }
  /// False where on_grid() must not be used: smoothing zones.
  bool plain() const { return plain_; }

  /// u of a closed track within [begin - before, end + after); other tracks unchanged.
  double wrap_u(double u_m) const noexcept;

  GridPlace place(std::size_t row, double fu, double v_m) const noexcept {
    if (per_v_step_ > 0.0) [[likely]] {
      const double columns = (v_m - v_right_m_) * per_v_step_;
      const std::size_t column = std::min(static_cast<std::size_t>(columns > 0.0 ? columns : 0.0), columns_ - 2);
      return {row, column, fu, columns - static_cast<double>(column)};
    }
    return place_uneven(row, fu, v_m);
  }

  const float* node(std::size_t row, std::size_t column) const { return z_m_ + row * columns_ + column; }
  std::size_t columns() const { return columns_; }
  std::size_t rows() const { return rows_; }
  double u_end_m() const { return u_end_m_; }
  double v_right_m() const { return v_right_m_; }
  double v_left_m() const { return v_left_m_; }
  double v_step_m(std::size_t column) const { return per_v_step_ > 0.0 ? v_step_m_ : v_m_[column + 1] - v_m_[column]; }
  double per_v_step() const { return per_v_step_; }  ///< 0 where v spacing varies
  bool bilinear() const { return interpolation_ == Interpolation::Bilinear; }
  double banking(std::size_t row) const { return banking_.empty() ? 0.0 : banking_[row]; }

 private:
  GridPlace place_uneven(std::size_t row, double fu, double v_m) const noexcept;
  Height grid_height(const GridPlace& place) const noexcept;
  double grid_z(const GridPlace& place) const noexcept;
  Height smooth_grid_height(const GridPlace& place) const noexcept;
  Height edge_height(const GridPlace& place) const noexcept;
  void add_line(Height& height, std::size_t row, double fu, double v_m) const noexcept;
  void add_smooth_line(Height& height, std::size_t row, double fu, double v_m) const noexcept;

  const float* z_m_;
  const std::vector<double>& v_m_;
  const std::vector<double>& line_z_m_;
  const std::vector<double>& banking_;
  Options options_;
  Interpolation interpolation_;
  std::size_t rows_, columns_;
  double u_begin_m_, u_end_m_, u_step_m_;
  double v_right_m_, v_left_m_;
  double v_step_m_ = 0.0, per_v_step_ = 0.0;
  double period_m_ = 0.0;      ///< 0 where the track is not closed
  double wrap_begin_m_ = 0.0;
  bool joined_ = false;        ///< the last row repeats the first
  bool plain_ = true;
  bool simple_ = true;
};

inline double HeightField::grid_z(const GridPlace& p) const noexcept {
  const float* low = node(p.row, p.column);
  const float* high = low + columns_;
  const double z0 = low[0] + p.fv * (static_cast<double>(low[1]) - low[0]);
  const double z1 = high[0] + p.fv * (static_cast<double>(high[1]) - high[0]);
  return z0 + p.fu * (z1 - z0);
}

inline double HeightField::z_on_grid(std::size_t row, double fu, double v_m, double z0_m, double z1_m) const noexcept {
  const GridPlace p = place(row, fu, v_m);
  double z;
  if (interpolation_ == Interpolation::Bilinear) [[likely]] {
    z = grid_z(p);
    if (z != z) [[unlikely]] z = edge_height(p).z_m;
  } else {
    Height height = smooth_grid_height(p);
    add_smooth_line(height, row, fu, v_m);
    return height.z_m;
  }
  z += z0_m + fu * (z1_m - z0_m);
  if (!banking_.empty()) z += (banking_[row] + fu * (banking_[row + 1] - banking_[row])) * v_m;
  return z;
}

inline double HeightField::z_simple(std::size_t row, double fu, double v_m, double z0_m, double z1_m, const float*& node_at) const noexcept {
  const double columns = (v_m - v_right_m_) * per_v_step_;
  const auto whole = std::min(static_cast<std::ptrdiff_t>(columns), static_cast<std::ptrdiff_t>(columns_) - 2);
  const GridPlace p{row, static_cast<std::size_t>(whole), fu, columns - static_cast<double>(whole)};
  node_at = node(p.row, p.column);
  double z = grid_z(p);
  if (z != z) [[unlikely]] z = edge_height(p).z_m;
  z += z0_m + fu * (z1_m - z0_m);
  if (!banking_.empty()) z += (banking_[row] + fu * (banking_[row + 1] - banking_[row])) * v_m;
  return z;
}

inline Height HeightField::grid_height(const GridPlace& p) const noexcept {
  if (interpolation_ != Interpolation::Bilinear) [[unlikely]] return smooth_grid_height(p);
  const float* low = node(p.row, p.column);
  const float* high = low + columns_;
  const double step0 = static_cast<double>(low[1]) - low[0];
  const double step1 = static_cast<double>(high[1]) - high[0];
  const double z0 = low[0] + p.fv * step0;
  const double z1 = high[0] + p.fv * step1;
  const double z = z0 + p.fu * (z1 - z0);
  if (z != z) [[unlikely]] return edge_height(p);
  const double per_step = per_v_step_ > 0.0 ? per_v_step_ : 1.0 / v_step_m(p.column);
  return {z, (z1 - z0) / u_step_m_, (step0 + p.fu * (step1 - step0)) * per_step};
}

inline Height HeightField::on_grid(std::size_t row, double fu, double v_m, double z0_m, double z1_m) const noexcept {
  Height height = grid_height(place(row, fu, v_m));
  if (interpolation_ != Interpolation::Bilinear) [[unlikely]] {
    add_smooth_line(height, row, fu, v_m);
    return height;
  }
  const double step = z1_m - z0_m;
  height.z_m += z0_m + fu * step;
  height.dzdu += step / u_step_m_;
  if (!banking_.empty()) {
    const double change = banking_[row + 1] - banking_[row];
    const double banking = banking_[row] + fu * change;
    height.z_m += banking * v_m;
    height.dzdu += change / u_step_m_ * v_m;
    height.dzdv += banking;
  }
  return height;
}

}  // namespace crg
