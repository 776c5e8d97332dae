// Small coordinates about an origin near the points, as float32 needs them.
#pragma once

#include <Eigen/Geometry>

#include "cloud/cloud.h"

namespace cloud {

/// Of all points, in the map frame.
Eigen::Vector3d middle_of(const Cloud& cloud);

/// From coordinates about one origin each to the map frame of both.
Eigen::Isometry3d in_map(const Eigen::Matrix4f& found, const Eigen::Vector3d& target_origin,
                         const Eigen::Vector3d& source_origin);

}  // namespace cloud
