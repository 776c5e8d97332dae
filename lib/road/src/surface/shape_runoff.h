// The run-off of a road without names. Private to classify_by_shape.
#pragma once

#include <vector>

#include "fans.h"

namespace road {

// A fold sharper than this (cosine of 20 degrees) is the foot of a bank.
inline constexpr double kHill = 0.94;

/// Marks with 2 what hangs on the sides of the road (1) without a wall between.
void grow_runoff(const FlatSurface& flat, const Fans& fans, std::vector<char>& mark);

}  // namespace road
