// Moving average of z along u that leaves kerbs alone.
#pragma once

#include "road/sample.h"

namespace road {

struct SmoothOptions {
  double window_m = 0.0;            ///< full length of the window along u; 0 = off
  double max_change_road_m = 0.002; ///< no road node moves further than this
  double max_change_kerb_m = 0.0;   ///< nor a kerb node further than this
  bool closed = false;              ///< the window continues over the seam
  unsigned threads = 0;
};

struct SmoothReport {
  double largest_change_road_m = 0.0;
  double largest_change_kerb_m = 0.0;
  std::size_t nodes_at_bound = 0;   ///< nodes whose change was cut to the bound
};

/// NaN nodes stay NaN and do not enter any average; a window never reaches across a hole, the road
/// border or a kerb edge.
void smooth(SampledGrid& sampled, const SmoothOptions& options, SmoothReport* report = nullptr);

}  // namespace road
