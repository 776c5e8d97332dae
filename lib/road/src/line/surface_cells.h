// A surface in plan as square cells, layer by layer. Private to road_graph.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "mesh/mesh.h"

namespace road {

inline constexpr std::int32_t kNoCell = -1;
// East, then counter-clockwise: even ones share a side with the cell.
inline constexpr std::array<std::array<int, 2>, 8> kAround{
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

struct Cell {
  std::int32_t x = 0, y = 0;
  double z_m = 0.0;
  std::array<std::int32_t, 8> around{};
};

/// The surface as square cells, several above each other where it has layers.
class Cells {
 public:
  /// Of layers nearer above each other than `headroom_m` the upper one counts.
  Cells(const Mesh& mesh, double cell_m, double headroom_m);

  /// Cells for what is empty, at most this large, and surrounded by one layer.
  void fill_holes(double largest_m2);

  Eigen::Vector3d point_m(std::int32_t i) const;
  double cell_m() const { return cell_m_; }
  bool has_surface_at(const Eigen::Vector3d& map_m) const;

  std::vector<Cell> cells;

 private:
  /// Of a row its first cell and the one behind its last.
  std::pair<std::size_t, std::size_t> row(std::int64_t y) const;
  /// Of the cells from `at` on that lie at x, the one whose height is nearest to z_m.
  std::int32_t nearest(std::size_t at, std::size_t end, std::int32_t x, double z_m) const;
  /// The cell at (x, y) whose height is nearest to z_m.
  std::int32_t find(std::int32_t x, std::int32_t y, double z_m) const;
  void index_rows();
  void link();

  double cell_m_;
  Eigen::Vector3d origin_m_;
  std::int32_t first_row_ = 0;
  std::vector<std::size_t> row_begin_;  ///< of each row from first_row_ on, and the end
};

/// Distance of every cell's middle to the border of its layer.
std::vector<double> distances_m(const Cells& grid);

}  // namespace road
