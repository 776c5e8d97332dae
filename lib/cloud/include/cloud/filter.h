// Scans without stray points, and thinned, before they are mapped.
#pragma once

#include <cstddef>

#include "cloud/read_cloud.h"
#include "cloud/trajectory.h"

namespace cloud {

struct FilterOptions {
  int outlier_neighbours = 0;  ///< 0: no outliers are taken out (pcl.h)
  double outlier_sigma = 2.0;
  double voxel_m = 0.0;  ///< 0: not thinned
  bool wanted() const { return outlier_neighbours > 0 || voxel_m > 0.0; }
};

struct FilterReport {
  std::size_t points = 0, outliers = 0, thinned = 0;  ///< read; taken out by each
};

/// The scans with whatever the options take out left out: statistical_inliers(), then
/// voxel_representatives(), of each chunk by itself, where the points lie in the map. `trajectory`
/// null: they are in the map frame; else points without a pose stay. What is kept is decided at the
/// first reading and remembered, one bit a point. The report counts the first reading; it and the
/// trajectory must live as long as the source. Throws as these two.
CloudSource filtered(CloudSource scans, const Trajectory* trajectory, const FilterOptions& options,
                     FilterReport* report = nullptr);

}  // namespace cloud
