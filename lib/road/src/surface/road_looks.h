// Looks of a mesh, and which of them are the road's.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "look_shares.h"
#include "road/clean.h"

namespace road {

/// Look of every triangle, and the names of the looks.
struct Looks {
  std::vector<std::uint32_t> of_object;
  std::vector<std::string> names;
};

Looks looks_of(const Mesh& mesh);

/// Where names call nearly everything under the guide road, what they call otherwise is another
/// look: pit lanes and aprons have the asphalt of the road. Whether they do.
/// `source`: the triangles of the mesh that are those of the surface.
bool part_by_names(const Guide& guide, const RaySurface& surface, const Mesh& mesh,
                   const std::vector<std::uint32_t>& source,
                   const std::vector<SurfaceClass>& by_names, Looks& looks,
                   std::vector<std::uint32_t>& look_of_triangle);

/// Looks of which each lies under so little of the guide that it tells nothing (a picture for each
/// piece of road) become one where their colours are alike. Whether any did.
bool join_rare_looks(const Mesh& mesh, const LookShares& shares, Looks& looks,
                     std::vector<std::uint32_t>& look_of_triangle);

/// The looks that lie under the guide rather than beside it, along the whole of it and where they
/// lie: sand that the road leads through for a while does not lie beside the rest of it.
/// `called_road`: so many of the looks, the first, are what names call road; 0: names do not know.
std::vector<bool> road_looks(const LookShares& shares, std::size_t called_road);

}  // namespace road
