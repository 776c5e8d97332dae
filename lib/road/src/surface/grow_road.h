// Goes on from a strip that is road, where the chains beside it broke and over gaps. Private to
// classify_by_shape.
#pragma once

#include <vector>

#include "band_strips.h"

namespace road {

/// A mark, 1, for every triangle of the road that `chosen` is a part of: with the columns that go
/// on from its ends, and pieces as wide that face one of them over a gap, `strips` or shorter ones.
std::vector<char> grow_road(const FlatSurface& flat, const Fans& fans,
                            const std::vector<Chain>& chains, const std::vector<Strip>& strips,
                            const Strip& chosen);

}  // namespace road
