// Points of a LiDAR cloud: plain arrays in double, relative to a local origin.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace cloud {

/// Map position of point i = origin_m + (x_m[i], y_m[i], z_m[i]). time_s, intensity,
/// classification and sigma_m are empty where the source has none, else as long as x_m. Points with
/// a coordinate that is not finite never get in.
struct Cloud {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  std::vector<double> x_m, y_m, z_m;
  std::vector<double> time_s;    ///< the source's clock: trajectory's, or GPS time of LAS
  std::vector<float> intensity;  ///< as in the file, no unit
  std::vector<std::uint8_t> classification;  ///< ASPRS: 2 ground, 6 building, 7 noise ...
  std::vector<float> sigma_m;  ///< standard deviation of the height, of refined surfaces

  std::size_t size() const { return x_m.size(); }
  Eigen::Vector3d point(std::size_t i) const { return {x_m[i], y_m[i], z_m[i]}; }
};

}  // namespace cloud
