// Moving average of z along u, v or both that leaves kerbs alone.
#pragma once

#include <optional>
#include <vector>

#include "road/sample.h"

namespace road {

struct SmoothOptions {
  double window_u_m = 0.0;  ///< full length of the window along u; 0 = off
  double window_v_m = 0.0;  ///< full length of the window along v; 0 = off
  double max_change_road_m =
      0.002;  ///< no road node moves further than this, by both windows together
  double max_change_kerb_m = 0.0;  ///< nor a kerb node further than this
  bool closed = false;             ///< the window continues over the seam
  unsigned threads = 0;
};

/// Roughness of the wheel paths in one third-octave band, before and after.
struct SmoothedBand {
  double n_cpm = 0.0;  ///< centre, cycles per metre along u
  double before_m3 = 0.0, after_m3 = 0.0;
};

struct WaveRange {
  double shortest_m = 0.0, longest_m = 0.0;
};

struct SmoothReport {
  double largest_change_road_m = 0.0;
  double largest_change_u_m = 0.0, largest_change_v_m = 0.0;  ///< where the road moved most
  double largest_change_kerb_m = 0.0;
  std::size_t nodes_at_bound = 0;   ///< nodes whose change was cut to a bound above 0
  std::vector<SmoothedBand> bands;  ///< of both wheel paths, v = +-0.8 m; empty on roads below 50 m
  /// From the shortest to the longest wave of the bands that lost more than half of their power
  /// (and held more than 2 um); empty when none did.
  std::optional<WaveRange> halved_waves_m;
};

/// NaN nodes stay NaN and do not enter any average; a window never reaches across a hole, the road
/// border or a kerb edge: it shrinks on both sides alike, so that slopes stay what they are.
/// First along u, then along v; heights between the columns, which need not be even, are taken as
/// straight. Takes a copy of the heights.
void smooth(SampledGrid& sampled, const SmoothOptions& options, SmoothReport* report = nullptr);

}  // namespace road
