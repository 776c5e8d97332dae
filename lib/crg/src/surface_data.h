// What a Surface holds, and the parts of its answers.
#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "crg/surface.h"
#include "directions.h"
#include "height.h"
#include "locator.h"
#include "same_shape.h"
#include "wheels_kernel.h"

namespace crg {

inline Crg with_modifiers(Crg crg, ModifierUse use) {
  if (use == ModifierUse::None) {
    crg.modifiers.clear();
    return crg;
  }
  if (use == ModifierUse::ReferenceDefaults && !crg.has_modifier_section) {
    crg.modifiers = reference_default_modifiers(crg);
  }
  return apply_modifiers(std::move(crg));
}

struct Surface::Data {
  Data(Crg crg, SurfaceOptions& options)
      : friction_constant(options.friction),
        friction(take_friction(crg.grid, options)),
        file(with_modifiers(std::move(crg), options.modifiers)),
        line(integrate_reference_line(file)),
        heights(file.grid, line, options_of(file), options.interpolation),
        locator(line, heights.v_right_m(), heights.v_left_m()),
        directions(directions_of(line)),
        curvature_of_reference_line(options.curvature_of_reference_line),
        least_width_m(1e-9 * line.u_step_m),
        quick(heights.simple() && friction.empty()),
        fours(heights.simple() && four_wheels_available() &&
              file.grid.z_m.size() <= std::numeric_limits<std::int32_t>::max()) {}

  static std::vector<float> take_friction(const Grid& road, SurfaceOptions& options) {
    if (!options.friction_map) return {};
    want_same_shape(road, options.friction_map->grid);
    return std::move(options.friction_map->grid.z_m);
  }

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
  Crg file;
  ReferenceLine line;
  HeightField heights;
  Locator locator;
  std::vector<Direction> directions;  ///< one per segment
  bool curvature_of_reference_line;
  double least_width_m;  ///< of a cell whose gradient along the line is known
  bool quick;            ///< sample_ahead() may be asked
  bool fours;            ///< z_of_four_wheels() may be asked
};

}  // namespace crg
