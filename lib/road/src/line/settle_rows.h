// What the rows of a guide say together: where each is unlike its neighbours, they speak for it.
#pragma once

#include <vector>

#include "guide_rows.h"

namespace road {

/// Fills what is NaN from the nearest known values on both sides; all zero where nothing is known.
void fill_between(std::vector<double>& values, bool closed);

/// Middle and width of every row, from itself where it is like its neighbours, else from them.
void settle(GuideRows& all, double scale);

}  // namespace road
