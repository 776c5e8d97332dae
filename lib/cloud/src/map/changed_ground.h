// Ground that changed between two passes, told from the drift that is left between them.
#pragma once

#include "drift.h"

namespace cloud {

/// By cell of the road, as HeightCells has them.
struct ChangedGround {
  std::vector<ChangedPlace> places;       ///< those that are sure, the largest first
  std::vector<std::uint16_t> first_pass;  ///< the ground of the last pass is that of the passes
                                          ///< from this one on; empty: nothing changed anywhere
  /// Beside changed ground: how far from the later ground what an earlier pass saw may lie to be
  /// the same; 0: no word of that pass counts. Empty as first_pass.
  std::vector<float> agrees_m;
  std::vector<std::uint8_t> unsure;  ///< passes differ here by more than elsewhere: 1 and 0
};

/// From the last pass back: cells in which it differs, over 2 m^2 and by 8 mm or more, from what
/// the passes behind it show. What is even over the whole width is drift.
ChangedGround find_changed_ground(const Sections& sections,
                                  const std::vector<Correction>& corrections,
                                  const RoadFrame& frame, unsigned threads);

/// As estimate_drift(); where passes differ their views do not tie the poses to each other, so that
/// the ground beside does not bend. Says in `sections` which these are.
Drift estimate_drift_apart(Sections& sections, const RoadFrame& frame, const MapOptions& options,
                           const std::vector<Correction>& before, MapReport& report,
                           std::optional<double> base_tilt, ChangedGround& changed);

}  // namespace cloud
