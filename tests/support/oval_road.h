// A closed road with known heights: two straights, two half circles, hills, banking, kerbs,
// run-off.
#pragma once

#include <functional>

#include "crg/file.h"
#include "mesh/mesh.h"

namespace test_support {

struct OvalOptions {
  double straight_m = 300.0;
  double radius_m = 60.0;
  double u_step_m = 0.1;  ///< wanted; changed a little to close
  double v_step_m = 0.1;
  double half_width_m = 9.0;  ///< of the grid: road to 6 m, kerbs to 7 m, run-off beyond
  char iso_class = 'B';       ///< roughness between 0.02 and 2 cycle/m; 0: none
  unsigned seed = 1;
  double kerb_height_m = 0.06;
};

struct Oval {
  crg::ReferenceLine line;  ///< z_m and banking empty: all heights are in the grid
  crg::Grid grid;
};

/// Kerbs lie at v = 6..7 m on both sides, over [20, 60] m of each half circle, with 2 m tapers.
Oval oval_road(const OvalOptions& options = {});

/// Adds height(u, v) to every node; NaN makes a hole.
void plant(Oval& oval, const std::function<double(double u_m, double v_m)>& height);

/// A mesh with a vertex at every stride-th node of the grid, closed where the road closes. `stride`
/// must divide the columns less one.
road::Mesh mesh_of(const Oval& oval, std::size_t stride);

}  // namespace test_support
