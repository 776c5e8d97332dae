// A road and its friction map from their files.
#pragma once

#include <string>

#include "crg/surface.h"

namespace vehicle {

struct RoadFiles {
  crg::Surface surface;
  std::string remark;  ///< how much of the road the friction map leaves without a factor, if any
};

/// Reads the road of a CRG file, with the heights of `friction_path` (empty: none) as grip factors.
/// Throws Error where the map has a value that no grip factor has, or none at all; crg::Error where
/// a file cannot be read.
RoadFiles read_road(const std::string& track_path, const std::string& friction_path);

}  // namespace vehicle
