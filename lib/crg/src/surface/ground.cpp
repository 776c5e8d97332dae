// What a wheel asks of a surface, without the rest of a Sample.
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "surface_data.h"

namespace crg {

// Where the cursor does not lead, and where the usual height is not known.
[[gnu::noinline]] Ground Surface::Data::ground_far(double x_m, double y_m,
                                                   Cursor& cursor) const noexcept {
  return Ground(sample_far(x_m, y_m, cursor));
}
[[gnu::noinline]] Ground Surface::Data::ground_there(const Place& place, double x_m,
                                                     double y_m) const noexcept {
  return Ground(sample(place, x_m, y_m));
}

Ground Surface::ground_at_xy(double x_m, double y_m, Cursor& cursor) const noexcept {
  const Data& data = *data_;
  const HeightField& heights = data.heights;
  const bool back = leads_back(cursor);
  Place place;
  if (!data.quick || !data.locator.locate_ahead(x_m, y_m, cursor, place)) [[unlikely]]
    return data.ground_far(x_m, y_m, cursor);
  const GridPlace cell = heights.place_simple(place.segment, place.fraction, place.v_m);
  heights.prefetch(back, heights.node(cell.row, cell.column));
  const Height height = heights.at_simple(cell, place.v_m);
  const double width = data.locator.records()[place.segment].frame.width(place.v_m);
  // Positive, so that the bits have the order of the numbers.
  if (std::isnan(height.z_m) || std::bit_cast<std::int64_t>(width) <
                                    std::bit_cast<std::int64_t>(data.least_width_m)) [[unlikely]] {
    const Place copy = place;  // its address leads out, so that of `place` need not
    return data.ground_there(copy, x_m, y_m);
  }
  const Two slope = data.gradient(place, height, data.line.u_step_m / width);
  Ground out;
  out.valid = out.inside = true;
  out.u_m = data.u_of({place.segment, place.fraction, place.v_m, 0.0});
  out.v_m = place.v_m;
  out.z_m = height.z_m;
  out.dzdx = slope[0];
  out.dzdy = slope[1];
  out.friction = data.friction_constant;
  return out;
}

bool Surface::ground_of_four(const std::array<Point2, 4>& points,
                             const std::array<Cursor*, 4>& cursors,
                             FourGrounds& out) const noexcept {
  out.friction = data_->friction_constant;
  return data_->quick && data_->fours &&
         ground_of_four_points(data_->locator, data_->heights, data_->least_width_m, points.data(),
                               cursors.data(), out);
}

}  // namespace crg
