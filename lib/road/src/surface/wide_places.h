// Wide places along a guide, where something that looks alike may lie beside the road. Private to
// cleaning.
#pragma once

#include <optional>
#include <string>

#include "guide_rows.h"

namespace road {

/// Where the road is so much wider than usual that something lies beside it that looks alike: it
/// begins or ends abruptly, or it lies on one side of the guide more than on the other. A road that
/// grows wide on both sides is a wide road.
/// The doubt, with the place; none where less than 1 % of the rows are such.
std::optional<std::string> much_wider(const GuideRows& all);

}  // namespace road
