// A road's nodes as points with normals and standard deviations, for programs that show or match
// clouds and meshes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "crg/file.h"

namespace cloud {

/// Map position of node i = origin_m + place_m[i]. place_m, normal, stddev_m have the same length.
struct NodeSurface {
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> place_m;
  std::vector<Eigen::Vector3f> normal;  ///< of length 1, upwards
  std::vector<float> stddev_m;          ///< of the height
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// The nodes that have a height, and the triangles between them; of the rows every so many that at
/// most `most_nodes` are left (the last row stays). `stddev`: standard deviations in the shape of
/// the road's grid. Normals are those of the whole grid, from the neighbours in its rows and
/// columns; upright where there are none. Throws crg::Error; Error where the shapes differ.
NodeSurface node_surface(const crg::Crg& road, const crg::Grid& stddev,
                         std::size_t most_nodes = 2'000'000);

/// Binary .ply (triangles; x y z nx ny nz sigma) or .pcd (points; normal_x normal_y normal_z for
/// nx ny nz), as the path ends; whole or not at all. sigma is stddev_m. Places are float32 relative
/// to the origin, which stands in the header as write_cloud() writes it; `doubles`: in the map
/// frame, exact; PCL 1.13 loads such a .ply as 0 0 0. `comments` follow, a line each. Throws Error
/// (another ending, disk).
void write_surface(const NodeSurface& surface, const std::string& path, bool doubles = false,
                   const std::vector<std::string>& comments = {});

}  // namespace cloud
