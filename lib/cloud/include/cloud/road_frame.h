// A road's grid as the frame in which points are compared with it: fast (u, v) near a known place,
// height and gradient between the nodes.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "crg/surface.h"

namespace cloud {

/// Place on the grid: u counts in rows, row 0 = 0.0; on a closed road 0 <= row < rows - 1.
struct GridPlace {
  double row = 0.0;
  double v_m = 0.0;
};

/// Immutable after construction; shared by threads.
class RoadFrame {
 public:
  /// Heights in the map frame, modifiers applied. Throws crg::Error.
  explicit RoadFrame(const crg::Crg& road);

  std::size_t rows() const { return rows_.size(); }
  std::size_t columns() const { return v_m_.size(); }
  bool closed() const { return closed_; }
  double u_begin_m() const { return u_begin_m_; }
  double u_step_m() const { return u_step_m_; }
  double length_m() const { return u_step_m_ * static_cast<double>(rows() - 1); }
  const std::vector<double>& v_m() const { return v_m_; }
  double z_origin_m() const { return z_origin_m_; }
  /// Height of a node above z_origin_m(); NaN for a hole.
  float node(std::size_t row, std::size_t column) const { return z_m_[row * v_m_.size() + column]; }
  Eigen::Vector2d node_position(std::size_t row, double v_m) const;
  double heading_rad(double row) const;
  /// Unit vector along the road.
  Eigen::Vector2d ahead(double row) const;

  /// (u, v) of a map point whose row is within some 100 m of `hint` along the road; empty where the
  /// walk does not settle, or beyond the ends of an open road. Legs of a track that cross do not
  /// mix.
  std::optional<GridPlace> project(double x_m, double y_m, double hint) const;
  /// Slow search over the whole road: the row nearest to a map point.
  double nearest_row(double x_m, double y_m) const;

  /// The column left of v and the share on the way to the next; false beyond the sides.
  bool column_of(double v_m, std::size_t& column, double& share) const {
    if (!(v_m >= v_m_.front() && v_m <= v_m_.back())) return false;
    std::size_t j = column_table_[std::min(column_table_.size() - 1,
                                           static_cast<std::size_t>(static_cast<std::ptrdiff_t>(
                                               (v_m - v_m_.front()) / table_step_m_)))];
    while (j + 2 < v_m_.size() && v_m_[j + 1] < v_m) ++j;
    column = j, share = (v_m - v_m_[j]) / (v_m_[j + 1] - v_m_[j]);
    return true;
  }
  /// Bilinear height above z_origin_m(); NaN on holes and beyond the sides.
  double height(const GridPlace& place) const;
  /// Gradient in map axes over +-reach_m; NaN where a neighbour is missing.
  Eigen::Vector2d gradient(const GridPlace& place, double reach_m) const;
  double wrapped(double row) const;

 private:
  /// Of the reference line: a place and the unit tangent there.
  struct Row {
    double x_m = 0.0, y_m = 0.0, tx = 0.0, ty = 0.0;
  };
  /// Between the nodes of a row and the next, so far on from a column; NaN beyond the ends.
  double height_in(double row, std::size_t column, double share) const;

  std::vector<Row> rows_;
  std::vector<double> v_m_;
  std::vector<float> z_m_;
  std::vector<std::uint32_t> column_table_;
  double u_begin_m_ = 0.0, u_step_m_ = 1.0, z_origin_m_ = 0.0, table_step_m_ = 0.01;
  bool closed_ = false;
};

}  // namespace cloud
