// Cells of the map that two campaigns fill, and what each keeps of their points.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <unordered_map>
#include <vector>

#include "cloud/read_cloud.h"

namespace cloud {

using Key = std::array<std::int64_t, 2>;  ///< row (y), column (x)
struct KeyHash {
  std::size_t operator()(const Key& key) const {
    std::uint64_t mixed = 0;
    for (const std::int64_t part : key)
      mixed = (mixed ^ static_cast<std::uint64_t>(part)) * 0x9e3779b97f4a7c15u,
      mixed ^= mixed >> 32;
    return static_cast<std::size_t>(mixed);
  }
};

/// The cell in which a place lies.
Key key_of(double x_m, double y_m, double cell_m);

struct Box {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()),
                  high = -low;
  std::string text() const;
};

/// Each point in the map frame; counts, and grows the box.
template <typename Each>
std::size_t read_all(const CloudSource& source, Box& box, const Each& each) {
  std::size_t points = 0;
  source([&](Cloud&& chunk) {
    points += chunk.size();
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      const Eigen::Vector3d p = chunk.origin_m + chunk.point(i);
      box.low = box.low.cwiseMin(p), box.high = box.high.cwiseMax(p);
      each(p);
    }
  });
  return points;
}

/// The cell in half of which, of those with points of both, there are a dozen of each.
double cell_for(const CloudSource& before, const CloudSource& after);

/// What a cell keeps of its points, relative to its corner and first height.
struct Held {
  double z0_m = 0.0;
  std::array<std::vector<Eigen::Vector3f>, 2> points;
  std::array<std::uint32_t, 2> seen{};
};

using HeldCells = std::unordered_map<Key, Held, KeyHash>;

/// The first 64 points, then each of the later ones in place of any with the right chance: a
/// fair draw, the same for the same cloud.
void hold(HeldCells& cells, const Eigen::Vector3d& p, double cell_m, std::size_t which);

}  // namespace cloud
