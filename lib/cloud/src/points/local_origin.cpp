#include "local_origin.h"

#include <algorithm>

namespace cloud {

Eigen::Vector3d middle_of(const Cloud& cloud) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < cloud.size(); ++i) sum += cloud.point(i);
  return cloud.origin_m + sum / static_cast<double>(std::max<std::size_t>(1, cloud.size()));
}

Eigen::Isometry3d in_map(const Eigen::Matrix4f& found, const Eigen::Vector3d& target_origin,
                         const Eigen::Vector3d& source_origin) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  // A rotation to the last bit of double, which float32 is not.
  const Eigen::Matrix3d turn = found.topLeftCorner<3, 3>().cast<double>();
  T.linear() = Eigen::Quaterniond(turn).normalized().toRotationMatrix();
  T.translation() =
      found.topRightCorner<3, 1>().cast<double>() + target_origin - T.linear() * source_origin;
  return T;
}

}  // namespace cloud
