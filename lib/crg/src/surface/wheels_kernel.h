// Heights under four wheels at once.
#pragma once

#include <cstddef>

#include "height.h"
#include "locator.h"

namespace crg {

/// Four times the common case of Surface::z_at_xy(), with AVX2: every point lies certainly in the
/// cell predicted by its cursor, on a road whose height is simple(). Then writes z_m and moves the
/// cursors; otherwise false, and nothing is changed. The same operations in the same order as for
/// one point (no fused multiply-add), so the same bits. Only where four_wheels_available(),
/// on grids whose nodes an int can count.
bool z_of_four_wheels(const Locator& locator, const HeightField& heights, const Point2* points,
                      Cursor* cursors, double* z_m) noexcept;

/// The same of Surface::ground_of_four(), but its friction; `least_width_m`: of a cell whose slope
/// is known.
bool ground_of_four_points(const Locator& locator, const HeightField& heights, double least_width_m,
                           const Point2* points, Cursor* const* cursors, FourGrounds& out) noexcept;

bool four_wheels_available() noexcept;

}  // namespace crg
