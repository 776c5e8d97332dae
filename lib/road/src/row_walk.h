// 16 neighbouring rows of a grid walking outwards from the line over the surface: the inner loop of sampling.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "road/sample.h"

namespace road {

constexpr std::size_t kWalkRows = 16;

/// z and half width of the road per row, from the centreline stations by share of length.
struct RowGuide {
  std::vector<double> z_m, half_width_m;
};

/// How far a row may reach to each side before it folds over itself or comes nearer to another leg
/// of the line: the smallest circle that touches the line at the row and passes through another point
/// of it (nearby points give the osculating circle, hence the fold).
struct RowLimits {
  std::vector<float> left_m, right_m;
  std::vector<char> left_is_fold, right_is_fold;
};

/// Rows that were still on the surface when their limit ended them.
struct RowsCut {
  std::array<bool, kWalkRows> left, right;
};

/// Every row walks on its own layer of the surface. What is done for all rows has neither branches nor calls,
/// so that it costs little beside the casts; rows are looked at one by one only where one of them misses,
/// steps or ends. One object per thread: it owns the buffers.
class RowWalk {
 public:
  /// Keeps references to all of them.
  RowWalk(const RoadMesh& road, const RaySurface& surface, const crg::ReferenceLine& line, const RowGuide& guide,
          const RowLimits& limits, const SampleOptions& options, SampledGrid& out);

  /// Fills `rows` <= kWalkRows rows of the grid, all their columns.
  RowsCut sample(std::size_t first_row, std::size_t rows);

 private:
  using Heights = std::array<float, kWalkRows>;
  using Classes = std::array<SurfaceClass, kWalkRows>;

  /// The way to one side.
  struct Side {
    RayPacket16 packet;  // its active lanes are the rows that still walk
    alignas(64) Heights last_z_m;
    alignas(64) std::array<std::uint32_t, kWalkRows> triangle;
    std::array<double, kWalkRows> last_v_m;
    std::array<bool, kWalkRows> cut;
    const float* limit_m = nullptr;
    std::ptrdiff_t step = 0, column = 0;  // the column of the rays in the packet
    std::size_t class_column = 0;         // where the classes of these triangles are
    double nearest_limit_m = 0.0;         // infinity when no row walks any more
    bool all_near = false;                // then last_v_m is not up to date: it is before_m everywhere
    double before_m = 0.0;
  };

  void start_rows(std::size_t first_row, std::size_t rows);
  void start_side(Side& side, std::size_t column, std::ptrdiff_t step, const float* limit_m);
  void walk_all();
  bool cast(Side& side);
  void take(Side& side);
  bool take_if_all_near(Side& side);
  void take_one_by_one(Side& side);
  void update_last_v(Side& side) const;
  void find_nearest_limit(Side& side) const;
  void write();
  void write_tile(std::size_t first_column, std::size_t width);

  const RoadMesh& road_;
  const RaySurface& surface_;
  const crg::ReferenceLine& line_;
  const RowGuide& guide_;
  const RowLimits& limits_;
  const SampleOptions& options_;
  SampledGrid& out_;
  const std::vector<double>& v_m_;  // of the columns
  double origin_z_m_;

  std::size_t first_row_ = 0, rows_ = 0;
  Side left_, right_;
  alignas(64) std::array<double, kWalkRows> x0_m_{}, y0_m_{}, normal_x_{}, normal_y_{};
  Heights start_z_m_{};
  // What was found, column by column: written to the rows of the grid at the end, a whole row at a time.
  // Single nodes written to 16 rows at once would keep the next cast waiting for memory.
  std::vector<Heights> z_m_;
  std::vector<Classes> class_;
  std::vector<char> whole_;  // columns where all 16 rows have a height
};

}  // namespace road
