// A driven lap as a guide: the positions of a logger, whatever the order and number of its rows.
#pragma once

#include <string>

#include "road/guide.h"

namespace road {

/// The channels called latitude and longitude. Throws Error where there are none, or no log.
GuideFile guide_of_log(const std::string& path);
/// The columns that a mapping.yaml has for x_m and y_m (z_m), else for latitude_rad and
/// longitude_rad. Delays and filters do not count: a guide may be metres off.
GuideFile guide_of_log(const std::string& path, const std::string& mapping_path);

}  // namespace road
