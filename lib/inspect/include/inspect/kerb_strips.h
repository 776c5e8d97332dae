// Kerbs of a road that comes without names: strips at its sides that rise over the road's plane.
#pragma once

#include <cstdint>
#include <vector>

#include "inspect/height_map.h"

namespace road {

/// One kerb, followed along u.
struct KerbStrip {
  double u_begin_m = 0.0, u_end_m = 0.0;
  bool left = true;                       ///< side of the reference line
  double v_begin_m = 0.0, v_end_m = 0.0;  ///< medians; v_begin is the edge towards the road
  double height_m = 0.0;        ///< 90th percentile along u of the rise over the road's plane
  double width_m = 0.0;         ///< median of |v_end - v_begin|
  double u_of_profile_m = 0.0;  ///< the row whose height is nearest to height_m
};

/// Where the kerb lies in one looked-at row; NaN where it was not seen.
struct KerbRow {
  std::size_t row = 0;
  double v_begin_m = 0.0, v_end_m = 0.0, height_m = 0.0;
};

struct KerbStripOptions {
  double row_step_m = 0.5;      ///< rows looked at
  double min_height_m = 0.015;  ///< lower ones drown in the roughness of class C roads
  double max_width_m = 3.0;     ///< wider rises are run-off or terrain
  double max_height_m = 0.4;    ///< higher ones are walls
  double min_length_m = 4.0;
};

struct KerbStrips {
  std::vector<KerbStrip> strips;           ///< by u_begin
  std::vector<std::vector<KerbRow>> rows;  ///< per strip, ascending
};

/// From the middle of each row outwards: a strip begins where the height leaves the line through
/// the last 1.5 m of road by 8 mm within 0.4 m (and 3 times the scatter about that line) and ends
/// where it is back at 30 % of its height, where run-off rises again behind a fall of 40 %, or
/// where the grid ends. A rise that does neither within max_width_m, or that stays below 5 times
/// the scatter, is no kerb.
KerbStrips find_kerb_strips(const HeightMap& map, const KerbStripOptions& options = {});

}  // namespace road
