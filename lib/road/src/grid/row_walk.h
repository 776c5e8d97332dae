// 16 neighbouring rows of a grid walking outwards from the line over the surface: the inner loop of
// sampling.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "road/sample.h"
#include "wide.h"

namespace road {

constexpr std::size_t kWalkRows = 16;

/// z and half width of the road per row, from the centreline stations by share of length.
struct RowGuide {
  std::vector<double> z_m, half_width_m;
};
RowGuide guide_rows(const crg::ReferenceLine& line, const Centreline& centreline);

/// How far a row may reach to each side before it folds over itself or comes nearer to another leg
/// of the line: the smallest circle that touches the line at the row and passes through another
/// point of it (nearby points give the osculating circle, hence the fold).
struct RowLimits {
  std::vector<float> left_m, right_m;
  std::vector<char> left_is_fold, right_is_fold;
};

/// How far 16 rows came.
struct RowsReached {
  std::array<bool, kWalkRows> left_cut,
      right_cut;                         // still on the surface when their limit ended them
  std::size_t first_column, end_column;  // all their nodes with a height lie in between
  bool empty() const { return first_column >= end_column; }
};

/// Every row walks on its own layer of the surface. What is done for all rows has neither branches
/// nor calls, so that it costs little beside the casts; rows are looked at one by one only where
/// one of them misses, steps or ends. One object per thread: it owns the buffers.
class RowWalk {
 public:
  /// Keeps references to all of them.
  RowWalk(const RoadMesh& road, const RaySurface& surface, const crg::ReferenceLine& line,
          const RowGuide& guide, const RowLimits& limits, const SampleOptions& options,
          SampledGrid& out);

  /// Heights (local to the surface's origin, NaN without) and classes of `rows` <= kWalkRows rows,
  /// in the memory of these rows in the grid but column by column: a column's nodes are written at
  /// once, and nothing is kept twice.
  RowsReached sample(std::size_t first_row, std::size_t rows);

 private:
  /// The way to one side.
  struct Side {
    RayPacket16 packet;  // its active lanes are the rows that still walk
    Floats16 last_z_m;
    Ints16 triangle;
    const SurfaceClass* surface_class = nullptr;  // of these triangles
    std::array<double, kWalkRows> last_v_m;
    std::array<bool, kWalkRows> cut;
    const float* limit_m = nullptr;
    std::ptrdiff_t step = 0, column = 0, end = 0;  // the column of the rays in the packet
    double nearest_limit_m = 0.0;                  // negative when no row walks any more
    double all_near_v_m = 0.0;  // unless NaN, last_v_m is not up to date: it is this everywhere
  };

  void start_rows(std::size_t first_row, std::size_t rows);
  void start_side(Side& side, std::size_t column, std::ptrdiff_t step, const float* limit_m);
  RowsReached walk_all();
  bool cast(Side& side);
  bool end_rows(Side& side, double v_m) const;
  void take(Side& side);
  bool take_if_all_near(Side& side);
  void take_one_by_one(Side& side);
  void update_last_v(Side& side) const;
  void find_nearest_limit(Side& side) const;
  void leave_out_empty_columns(RowsReached& reached) const;

  Floats16 start_z_m_{};
  alignas(64) std::array<double, kWalkRows> x0_m_{}, y0_m_{}, normal_x_{}, normal_y_{};
  const RoadMesh& road_;
  const RaySurface& surface_;
  const crg::ReferenceLine& line_;
  const RowGuide& guide_;
  const RowLimits& limits_;
  const SampleOptions& options_;
  SampledGrid& out_;
  const double* v_m_;  // of the columns
  std::size_t columns_;
  double origin_z_m_;

  std::size_t first_row_ = 0, rows_ = 0;
  float* z_m_ = nullptr;           // of these rows, column by column
  SurfaceClass* class_ = nullptr;  // likewise
};

/// Makes rows of what walks left column by column in the first `rows` rows, with the columns from
/// `first_column` to before `end_column` only: heights in the map frame, and where they come from.
void turn_into_rows(SampledGrid& out, std::size_t rows, const std::vector<RowsReached>& reached,
                    std::size_t first_column, std::size_t end_column, double origin_z_m);

}  // namespace road
