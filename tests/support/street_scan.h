// Scans of a made-up street by a spinning LiDAR: ground, houses, poles, trees, cars.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "cloud/cloud.h"

namespace support {

/// What a sensor at `pose` sees, in its own frame: 64 beams, 900 shots a turn, 1.5 cm range noise.
/// `scene` makes the street; `visit` the noise, where cars stand that move, and stray points (1 in
/// 500, anywhere along the ray).
cloud::Cloud scan_street(const Eigen::Isometry3d& pose, std::uint32_t scene, std::uint32_t visit);

}  // namespace support
