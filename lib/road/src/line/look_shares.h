// How often each look of a surface lies under a guide and beside it.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/ray_surface.h"
#include "road/guide.h"

namespace road {

/// Share of the places under the guide where a look lies on any layer, and of those far beside it;
/// of all rows, and of the rows alone where the look lies under the guide.
struct LookShares {
  std::vector<double> inside, outside;              ///< by look
  std::vector<double> inside_there, outside_there;  ///< likewise
  struct Seen {
    std::uint32_t look;
    double z_m;
  };
  std::vector<std::vector<Seen>> places;  ///< what lies at each place under the guide, from above
};
LookShares look_shares(const Guide& guide, const RaySurface& surface,
                       const std::vector<std::uint32_t>& look_of_triangle, std::size_t looks);

}  // namespace road
