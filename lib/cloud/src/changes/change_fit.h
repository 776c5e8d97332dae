// The surface of both campaigns in one cell.
#pragma once

#include "change_cells.h"

namespace cloud {

/// Heights of both campaigns at the middle of a cell, with one slope.
struct CellFit {
  bool done = false;
  double old_m = 0.0, change_m = 0.0, stddev_m = 0.0;
  double points = 0.0;  ///< that count: twice the harmonic mean of both campaigns'
};

/// From low and from the middle: where these differ, as on cars and grass, the cell says little.
CellFit fit_cell(const Held& cell);

}  // namespace cloud
