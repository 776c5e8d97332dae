// Moves one cloud onto another: generalised ICP (Segal, Haehnel, Thrun 2009), with what the data
// fixes and what it does not.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "base/progress.h"
#include "cloud/cloud.h"

namespace cloud {

struct RegisterOptions {
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();  ///< T_target_source to begin with
  double voxel_m = 0.25;        ///< both clouds are thinned to one point per such cube
  double max_distance_m = 2.0;  ///< of a pair at first; narrowed down to 2 voxel_m
  /// Ends with the near pairs, where pairs far off their planes lose their pull (Cauchy): finer
  /// where the scans show the same things, and what moved hardly counts. Else plain generalised ICP
  /// with pairs of up to 1 m follows.
  bool robust = false;
  int neighbours = 10;  ///< that a plane is fitted to
  int max_iterations = 100;
  unsigned threads = 0;
  base::Progress progress;
};

/// Directions in the target's axes through the middle of the pairs: x, y, z, about x, about y,
/// about z.
struct RegisterReport {
  bool converged = false;  ///< the last step was below 0.1 mm and 1e-5 rad
  int iterations = 0;
  std::size_t points = 0, inliers = 0;           ///< thinned source; pairs of the last iteration
  double rms_before_m = 0.0, rms_after_m = 0.0;  ///< to the planes, over the pairs before and after
  std::array<double, 6> information{};  ///< eigenvalues of the normal equations, smallest first,
                                        ///< per pair (rotations by the cloud's radius)
  std::vector<std::string>
      unfixed;  ///< directions with hardly any information; they were left alone
};

/// T_target_source near options.start (map frame of both). Throws Error where fewer than 100
/// pairs lie within max_distance_m: the clouds do not overlap. nanoflann stays private to the
/// source file.
Eigen::Isometry3d register_clouds(const Cloud& target, const Cloud& source,
                                  const RegisterOptions& options = {},
                                  RegisterReport* report = nullptr);

}  // namespace cloud
