// The part of a file of devices that has sensors of the road. Private.
#pragma once

#include "base/settings.h"
#include "vehicle/road_sensors.h"

namespace vehicle {

/// Keys scans, edges and pose of `top`. Throws Error with file:line on unknown keys and numbers
/// that cannot be.
RoadSensorFile read_road_sensors(const base::Section& top);

/// Keys at_m and turned_deg of a sensor.
Mounting read_mounting(const base::Section& entry, const std::string& name,
                       const std::string& where);

}  // namespace vehicle
