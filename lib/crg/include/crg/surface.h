// Queries of a road: immutable Surface shared by all threads, one Cursor per wheel.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "crg/file.h"

namespace crg {

/// Everything a query answers. Where there is no road, valid is false and the numbers are NaN.
struct Sample {
  bool valid = false;
  double u_m, v_m;
  double x_m, y_m, z_m;
  double dzdx, dzdy;           ///< gradient in map axes
  double heading_rad;          ///< of the reference line segment, CCW from +x
  double curvature_1pm;        ///< of the line through the point, left turn positive
};

/// Where the last query was found; only speeds up the next one, never changes its answer.
struct Cursor {
  std::size_t segment = 0;
};

struct UV { double u_m, v_m; };

class Surface {
 public:
  /// Applies modifiers and options of the file. Throws Error when the file cannot be evaluated.
  explicit Surface(Crg crg);
  ~Surface();
  Surface(Surface&&) noexcept;
  Surface& operator=(Surface&&) noexcept;

  /// z at (u, v); NaN outside the road or on a hole.
  double z_at_uv(double u_m, double v_m) const noexcept;
  Point2 xy_of_uv(double u_m, double v_m) const noexcept;
  /// The (u, v) of a map point: the leg of the track nearest to it. NaN where there is none.
  UV uv_of_xy(double x_m, double y_m, Cursor& cursor) const noexcept;
  Sample at_xy(double x_m, double y_m, Cursor& cursor) const noexcept;
  Sample at_uv(double u_m, double v_m) const noexcept;

  const Crg& file() const noexcept;
  const ReferenceLine& reference_line() const noexcept;  ///< after modifiers

 private:
  struct Data;
  std::unique_ptr<const Data> data_;
};

}  // namespace crg
