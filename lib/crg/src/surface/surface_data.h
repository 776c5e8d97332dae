// What a Surface holds, and the parts of its answers.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include "crg/surface.h"
#include "directions.h"
#include "height.h"
#include "locator.h"
#include "same_shape.h"
#include "wheels_kernel.h"

namespace crg {

struct Surface::Data {
  Data(Crg crg, SurfaceOptions& options);

  // Made for whoever asks, once, from the tables below: bit for bit what the file said and the line
  // that it means. They would take 64 bytes a row beside 707 that the queries need.
  const Crg& whole_file() const;
  const ReferenceLine& whole_line() const;

  // On the grid, with no smoothing zone near: the place found is all that height needs.
  bool on_grid(const Place& place) const noexcept {
    return place.beyond_m == 0.0 && place.v_m >= heights.v_right_m() &&
           place.v_m <= heights.v_left_m();
  }
  Heading direction(const Place& place) const noexcept;
  Sample sample(const Place& place, double x_m, double y_m) const noexcept;
  Sample sample_ahead(const Place& place, double x_m, double y_m, bool back) const noexcept;
  Sample sample_far(double x_m, double y_m, Cursor& cursor) const noexcept;
  Sample answer(const Place& place, const Height& height, bool inside, double x_m, double y_m,
                double u_per_metre, double friction_there) const noexcept;
  Sample at(double x_m, double y_m, Cursor& cursor) const noexcept;
  Ground ground_far(double x_m, double y_m, Cursor& cursor) const noexcept;
  Ground ground_there(const Place& place, double x_m, double y_m) const noexcept;
  Two gradient(const Place& place, const Height& height, double u_per_metre) const noexcept;
  double z_of(const Place& place) const noexcept;
  template <typename PointAt>
  void many(std::size_t count, const PointAt& point_at, Sample* out, Cursor& cursor) const noexcept;
  template <typename PointAt>
  void many(std::size_t count, const PointAt& point_at, double* z_m, Cursor& cursor) const noexcept;
  double z_far(double x_m, double y_m, Cursor& cursor) const noexcept;
  double z_anywhere(double x_m, double y_m, Cursor& cursor) const noexcept;
  Place locate_far(double x_m, double y_m, Cursor& cursor) const noexcept;
  double friction_of(const Place& place) const noexcept;
  Place place_of(double u_m, double v_m) const noexcept;
  double u_of(const Place& place) const noexcept {
    const auto segment = static_cast<std::ptrdiff_t>(place.segment);  // signed: one instruction
    const double u =
        line.u_begin_m + (static_cast<double>(segment) + place.fraction) * line.u_step_m;
    return place.beyond_m == 0.0 ? u : u + place.beyond_m;
  }

  double friction_constant;
  std::vector<float> friction;  ///< empty: constant
  mutable Crg file;             ///< phi, slope and banking only in whole_file()
  mutable ReferenceLine line;   ///< nodes only in whole_line(); the numbers always
  HeightField heights;
  Locator locator;
  Headings headings;
  std::vector<double> curvatures_1pm;  ///< one per segment
  bool curvature_of_reference_line;
  double least_width_m;  ///< of a cell whose gradient along the line is known
  bool quick;            ///< sample_ahead() may be asked
  bool fours;            ///< z_of_four_wheels() may be asked

 private:
  // What the tables do not say of file and line.
  struct Rest {
    bool has_heading, has_banking;  ///< whether the file has the channel
    double heading_rad = 0.0;       ///< row 0 of the file's channel
    std::vector<float> slope;       ///< where each of its values is a float
    bool line_has_z, line_has_banking;
  };
  void spare_channels();
  void spare_heights();
  std::vector<double> bankings() const;

  Rest rest_;
  mutable std::once_flag file_made_, line_made_;
};

// In map axes.
[[gnu::always_inline]] inline Two Surface::Data::gradient(const Place& place, const Height& height,
                                                          double u_per_metre) const noexcept {
  const SegmentFrame& frame = locator.records()[place.segment].frame;
  // Along the mitre line both v and the place along the segment change.
  const double lean = frame.begin_lean + place.fraction * frame.lean_change;
  const double along = height.dzdu * u_per_metre;
  const double across = height.dzdv - lean * along;
  const Two direction = two_at(&frame.cos);
  return both(along) * direction +
         Two{-across, across} * __builtin_shufflevector(direction, direction, 1, 0);
}

}  // namespace crg
