// A cloud of any size as tiles: an octree of levels of detail, to be drawn piece by piece.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cloud/cloud.h"

namespace cloud {

/// Hands out the cloud piece by piece; `pass` tells which drive or file a piece is of. May be
/// called once only.
using PassSink = std::function<void(Cloud&& chunk, std::uint16_t pass)>;
using PassSource = std::function<void(const PassSink&)>;

struct TileOptions {
  std::size_t points_per_run = 1u << 20;  ///< sorted in memory at once, 130 bytes each
  unsigned threads = 0;                   ///< 0: all cores; any number gives the same bytes
  std::function<void(double share)> progress = {};  ///< of the writing, after the reading
};

/// So many points, at `begin` of the file of points (docs/formats.md tells its bytes).
struct Tile {
  int level = 0;  ///< 0: the coarsest
  std::uint64_t begin = 0;
  std::uint32_t points = 0;
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  ///< what its coordinates are relative to
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero(), max_m = Eigen::Vector3d::Zero();
};

/// The middle part of the values, 1 % to 99 %: what fills a view or a scale of colours.
struct MostValues {
  double low = 0.0, high = 0.0;
};

struct TileSet {
  std::uint64_t points = 0;
  bool has_time = false, has_intensity = false, has_class = false, has_sigma = false;
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero(), max_m = Eigen::Vector3d::Zero();
  std::array<MostValues, 3> most_m;
  MostValues most_intensity, most_sigma_m;
  double time_begin_s = 0.0, time_end_s = 0.0;
  std::map<int, std::uint64_t> points_of_class, points_of_pass;
  double spacing_m = 0.0;   ///< of level 0, halved with each level
  std::vector<Tile> tiles;  ///< in the order of the file
  std::uint64_t bytes = 0;
};

/// Bytes of a tile with so many points.
std::uint64_t bytes_of_tile(const TileSet& set, std::uint64_t points);

/// Writes the points into `path`, whole or not at all. Each is in exactly one tile: the first in a
/// cell of a level's spacing is in that level, so that a level adds to those above it.
/// `scratch` names a file of 48 bytes a point that nobody sees. Memory does not grow with the
/// points, but by the list of tiles (100 bytes each). Throws Error: no points, a coordinate of 1e8
/// m or more, no room on the disk.
TileSet write_tiles(const PassSource& source, const std::string& path, const std::string& scratch,
                    const TileOptions& options = {});

}  // namespace cloud
