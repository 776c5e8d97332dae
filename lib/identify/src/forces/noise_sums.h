// What a smoothed stretch says of noises and of what stays as it is. Private to the smoother.
#pragma once

#include "car_smoother.h"

namespace identify {

/// Of their uncertainty, what the filter lets stated numbers have.
inline constexpr double kHeld = 0.03;

/// What stays as it is over the stretch, by its first row. Of parts without an uncertain rest see
/// add_parts. `variance`: of the row, the stated numbers being right.
void add_constants(const CarPoint& point, const PlaceVector& variance, const SmootherBegin& begin,
                   NoiseSums& sums);

/// Rests that are held, by how the parts are about them.
void add_parts(const CarPoint& point, const PlaceVector& variance, const SmootherBegin& begin,
               NoiseSums& sums);

/// What the stretch says of the stated numbers, by its first row: the filter lets them move a
/// little, and how far they went against how far they might have is what it says. `covariance`: of
/// the row, before they are held.
void add_stated(const PlaceVector& moved, const PlaceMatrix& covariance, const SmootherBegin& begin,
                NoiseSums& sums);

}  // namespace identify
