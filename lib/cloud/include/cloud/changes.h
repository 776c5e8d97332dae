// What changed between two campaigns, by the heights of cells that both saw.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/progress.h"
#include "cloud/read_cloud.h"

namespace cloud {

struct ChangeOptions {
  /// Side of a cell; 0: 0.25 m doubled until half of the cells hold 12 points or more of each.
  double cell_m = 0.0;
  double min_change_m = 0.01;  ///< smallest change at the middle of a place that is told
  /// Differences that are even over this width are taken out: drift between the campaigns. 0: none.
  double level_m = 30.0;
  base::Progress progress;
};

/// A cell that both campaigns saw.
struct ChangeCell {
  double x_m = 0.0, y_m = 0.0, z_m = 0.0;  ///< middle, map frame; height of the old surface
  double change_m = 0.0;                   ///< new less old, without the level
  double stddev_m = 0.0;
  double level_m = 0.0;  ///< that was taken out
};

/// Neighbouring cells that changed, all up or all down.
struct ChangePlace {
  double x_m = 0.0, y_m = 0.0, z_m = 0.0;  ///< of the middle
  double area_m2 = 0.0;
  double change_m = 0.0, stddev_m = 0.0;            ///< mean of the place
  double peak_change_m = 0.0, peak_stddev_m = 0.0;  ///< of its most changed cell
  bool object = false;  ///< more than 0.3 m: something that stands there, or is gone
};

struct ChangeResult {
  double cell_m = 0.0;
  std::size_t old_points = 0, new_points = 0;
  std::size_t old_alone = 0, new_alone = 0;  ///< cells that one campaign alone saw well enough
  std::size_t unclear = 0;                   ///< cells that show no one surface: left out
  std::vector<ChangeCell> cells;             ///< by y, then x
  std::vector<ChangePlace> places;           ///< the most certain first
  double level_median_m = 0.0, level_low_m = 0.0, level_high_m = 0.0;  ///< 1 % and 99 %
  double stddev_factor = 1.0;  ///< median; scatter of what did not change over what was expected
  double smallest_told_m =
      0.0;  ///< median over the cells: what a place of two cells must change by
  std::vector<std::string> remarks;
};

/// Both in the map frame; each is read twice with cell_m 0, else once. Per cell one plane is fitted
/// to both clouds with a height for each (Tukey's weights, from the lower quarter on: what passed
/// by does not count), from 64 points of each at most. Deviations come from the scatter about the
/// planes, grow where a fit from the middle of the heights on says something else, and are scaled
/// by how much cells differ that did not change. A place has two cells or more at three deviations,
/// six together. Memory grows with the cells, not with the points. Throws Error: fewer than
/// 100 cells in common (says where both lie), or more than 20 million.
ChangeResult find_changes(const CloudSource& before, const CloudSource& after,
                          const ChangeOptions& options = {});

}  // namespace cloud
