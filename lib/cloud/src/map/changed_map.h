// A plan of where the ground of a road changed between campaigns.
#pragma once

#include <string>

#include "cloud/map.h"

namespace cloud {

/// The bytes of a PNG file: newer less older height at the nodes that both have by points, in
/// squares of the plan; the changed places numbered as in the report. Empty: no such nodes.
std::string changed_map_png(const crg::Crg& base, const MapResult& newer, const OlderRoad& older);

}  // namespace cloud
