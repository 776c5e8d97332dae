// Whether topics of ROS 2 can be spoken: Eclipse Cyclone DDS is used where it was found when this
// was built.
#pragma once

#include <string>

namespace sim {

/// Of Cyclone DDS; empty where this was built without it.
std::string dds_version();

/// Throws Error, naming the option, where this was built without it.
void require_dds(const std::string& option);

}  // namespace sim
