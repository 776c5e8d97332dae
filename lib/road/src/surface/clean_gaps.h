// Gaps in a road that is being cleaned: filled by pieces under other names, bridged by objects, or
// closed by new triangles. Private to cleaning.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "clean_soup.h"
#include "road/road_graph.h"

namespace road {

/// Where the named road has a gap that pieces of other classes fill, calls these road. True if any.
bool fill_gaps_from_other_names(const Mesh& mesh, const Soup& soup,
                                const std::vector<bool>& may_fill,
                                std::vector<SurfaceClass>& class_of_triangle, CleanReport& facts);

/// The same for pieces that begin at one end of the road and end at another, as wide as it: bridges
/// in a bend, whose ends face no other.
bool fill_gaps_from_end_to_end(const Mesh& mesh, const Soup& soup,
                               const std::vector<bool>& may_fill, const CleanOptions& options,
                               std::vector<SurfaceClass>& class_of_triangle, CleanReport& facts);

/// Triangles of the mesh that carry the road from p to q.
struct Bridge {
  Eigen::Vector3d p, q;
  std::vector<std::uint32_t> triangles;
};

/// Where two ends of the road face each other, an object of another class may carry it from one to
/// the other: a bridge that has a name or a material of its own, and is taken as road.
std::vector<Bridge> fill_gaps_between_ends(const Mesh& mesh, const RoadGraph& graph,
                                           const std::vector<bool>& flat,
                                           std::vector<SurfaceClass>& class_of_triangle,
                                           CleanReport& facts);

/// Closes gaps across the strip made of the triangles that `of` admits by triangles between the
/// ends.
void bridge_gaps(Soup& soup, const std::function<bool(std::size_t)>& of,
                 const Eigen::Vector3d& origin_m, const CleanOptions& options, CleanReport& facts);

}  // namespace road
