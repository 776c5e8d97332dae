// z(u, v): grid, reference line height and banking, with border modes, offsets and smoothing.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "closing.h"
#include "crg/file.h"
#include "crg/options.h"
#include "crg/surface.h"
#include "two.h"

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

/// The reference line's part of the height at a row.
struct LineNode {
  double z_m;
  double banking;
};

/// Prefetches the pair of nodes that lies `bytes` from a node, and two or three beside it: a pair
/// may lie on two cache lines, and whoever drives towards it moves sideways meanwhile. That may be
/// outside the grid, which prefetching does not mind; hence the integers. Always inline: gcc drops
/// calls of functions that only prefetch.
[[gnu::always_inline]] inline void prefetch_row(const float* node, std::ptrdiff_t bytes) {
  const auto at = reinterpret_cast<std::uintptr_t>(node) + static_cast<std::uintptr_t>(bytes);
  // NOLINTBEGIN(performance-no-int-to-ptr)
  __builtin_prefetch(reinterpret_cast<const void*>(at - 2 * sizeof(float)));
  __builtin_prefetch(reinterpret_cast<const void*>(at + 3 * sizeof(float)));
  // NOLINTEND(performance-no-int-to-ptr)
}

/// Everything that height needs. Refers to the grid, which must outlive it.
class HeightField {
 public:
  HeightField(const Grid& grid, const ReferenceLine& line, const Options& options,
              Interpolation interpolation = Interpolation::Bilinear);

  Height at(double u_m, double v_m) const noexcept;

  /// The same for places known to lie on the grid, where no border matters: row and fu of a u in
  /// range, v within the sections.
  Height on_grid(std::size_t row, double fu, double v_m) const noexcept;
  /// The same where simple(): bilinear, even columns, no smoothing zones. NaN also where a node of
  /// the cell is NaN but has no weight: then ask the others.
  Height at_simple(const GridPlace& place, double v_m) const noexcept;
  double z_simple(const GridPlace& place, double v_m) const noexcept;
  GridPlace place_simple(std::size_t row, double fu, double v_m) const noexcept {
    const double columns = (v_m - v_right_m_) * per_v_step_;
    const auto column = std::min(static_cast<std::ptrdiff_t>(columns), last_column_);
    return {row, static_cast<std::size_t>(column), fu, columns - static_cast<double>(column)};
  }
  /// z of a place on the grid where simple(), by the arithmetic of at(); NaN elsewhere: ask at().
  double z_at_simple(double u_m, double v_m) const noexcept;
  bool simple() const { return simple_; }
  /// False where on_grid() must not be used: smoothing zones.
  bool plain() const { return plain_; }

  /// u of a closed track within [begin - before, end + after); other tracks unchanged.
  double wrap_u(double u_m) const noexcept;

  GridPlace place(std::size_t row, double fu, double v_m) const noexcept {
    if (per_v_step_ > 0.0) [[likely]] {
      const double columns = (v_m - v_right_m_) * per_v_step_;
      // Bounded before it becomes an integer: v may be any number.
      const auto column =
          static_cast<std::size_t>(std::clamp(columns, 0.0, static_cast<double>(last_column_)));
      return {row, column, fu, columns - static_cast<double>(column)};
    }
    return place_uneven(row, fu, v_m);
  }

  /// The column left of v, 0 beyond the sides: for fetching.
  std::ptrdiff_t column_near(double v_m) const noexcept {
    const double columns = (v_m - v_right_m_) * per_v_step_;
    return columns > 0.0 && columns < static_cast<double>(columns_)
               ? static_cast<std::ptrdiff_t>(columns)
               : 0;
  }
  /// The nodes of a cell and the line beside it, for a place that is nearly known.
  [[gnu::always_inline]] void prefetch_cell(std::size_t row, double v_m) const noexcept {
    const std::int64_t column = whole((v_m - v_right_m_) * per_v_step_);
    const auto bytes =
        static_cast<std::ptrdiff_t>(static_cast<std::uint64_t>(column) * sizeof(float));
    prefetch_row(node(row, 0), bytes);
    prefetch_row(node(row + 1, 0), bytes);
    __builtin_prefetch(line() + row);
  }
  const float* node(std::size_t row, std::size_t column) const {
    return z_m_ + row * columns_ + column;
  }
  std::size_t columns() const { return columns_; }
  std::size_t rows() const { return rows_; }
  /// How far ahead to prefetch: 12 rows.
  std::ptrdiff_t ahead_bytes(bool back) const { return ahead_bytes_[back ? 1 : 0]; }
  /// What later queries will need of the row there, if they go on that way.
  [[gnu::always_inline]] void prefetch(bool back, const float* node) const noexcept {
    prefetch_row(node, ahead_bytes(back));
  }
  double u_begin_m() const { return u_begin_m_; }
  double u_end_m() const { return u_end_m_; }
  double u_step_m() const { return u_step_m_; }
  double per_u_step() const { return per_u_step_; }
  double v_right_m() const { return v_right_m_; }
  double v_left_m() const { return v_left_m_; }
  double v_m(std::size_t column) const {
    return per_v_step_ > 0.0 ? v_right_m_ + static_cast<double>(column) * v_step_m_ : v_m_[column];
  }
  double v_step_m(std::size_t column) const {
    return per_v_step_ > 0.0 ? v_step_m_ : v_m_[column + 1] - v_m_[column];
  }
  double per_v_step() const { return per_v_step_; }  ///< 0 where v spacing varies
  bool bilinear() const { return interpolation_ == Interpolation::Bilinear; }
  const LineNode* line() const { return line_.data(); }  ///< one per row

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
  Options options_;
  Interpolation interpolation_;
  std::size_t rows_, columns_;
  std::ptrdiff_t last_column_;     ///< of the cells
  std::ptrdiff_t last_row_;        ///< of the cells
  std::ptrdiff_t ahead_bytes_[2];  ///< forwards and backwards
  double u_begin_m_, u_end_m_, u_step_m_, per_u_step_;
  double v_right_m_, v_left_m_;
  double v_step_m_ = 0.0, per_v_step_ = 0.0;
  double period_m_ = 0.0;  ///< 0 where the track is not closed
  double wrap_begin_m_ = 0.0;
  double simple_end_m_ = 0.0;  ///< z_at_simple() knows what lies before
  bool joined_ = false;        ///< the last row repeats the first
  bool plain_ = true;
  bool simple_ = true;
  std::vector<LineNode> line_;
};

inline double HeightField::grid_z(const GridPlace& p) const noexcept {
  const float* nodes = node(p.row, p.column);
  const Two low = two_at(nodes), high = two_at(nodes + columns_);
  const Two right = firsts(low, high), left = seconds(low, high);
  const Two z = right + both(p.fv) * (left - right);
  return z[0] + p.fu * (z[1] - z[0]);
}

inline double HeightField::z_simple(const GridPlace& p, double v_m) const noexcept {
  const double z = grid_z(p);
  const double* low = &line_[p.row].z_m;
  const Two here = two_at(low), line = here + both(p.fu) * (two_at(low + 2) - here);
  return z + line[0] + line[1] * v_m;
}

inline double HeightField::z_at_simple(double u_m, double v_m) const noexcept {
  const double rows = (u_m - u_begin_m_) / u_step_m_;
  // A closed track may begin anew before its last row ends; what is not a number fails too.
  if (!(simple_ && rows >= 0.0 && u_m < simple_end_m_ && v_m >= v_right_m_ && v_m <= v_left_m_))
    return std::numeric_limits<double>::quiet_NaN();
  const auto row = std::min(static_cast<std::ptrdiff_t>(rows), last_row_);
  const GridPlace p =
      place_simple(static_cast<std::size_t>(row), rows - static_cast<double>(row), v_m);
  prefetch_row(node(p.row, p.column), ahead_bytes_[0]);
  return z_simple(p, v_m);
}

inline Height HeightField::at_simple(const GridPlace& p, double v_m) const noexcept {
  const float* nodes = node(p.row, p.column);
  const Two low = two_at(nodes), high = two_at(nodes + columns_);
  const Two right = firsts(low, high), step = seconds(low, high) - right;
  const Two z = right + both(p.fv) * step;  // at either row
  // Of the grid: height and step across. Of the line: height and banking.
  const Two begin = firsts(z, step), change = seconds(z, step) - begin;
  const Two grid = begin + both(p.fu) * change;
  const double* node = &line_[p.row].z_m;
  const Two here = two_at(node), line_change = two_at(node + 2) - here;
  const Two line = here + both(p.fu) * line_change;
  return {grid[0] + line[0] + line[1] * v_m,
          (change[0] + line_change[0] + line_change[1] * v_m) * per_u_step_,
          grid[1] * per_v_step_ + line[1]};
}

}  // namespace crg
