// An independent ruler: vertical lines against triangles in double precision, no Embree, no sampler
// code.
#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "mesh/mesh.h"

namespace support {

class BruteForce {
 public:
  explicit BruteForce(const road::Mesh& mesh);

  /// Heights of all triangles that cover (x, y) in map coordinates, unsorted.
  std::vector<double> heights(double x_m, double y_m) const;

  /// The height nearest to z_m; nothing where no triangle covers the point.
  std::optional<double> nearest(double x_m, double y_m, double z_m) const;

  /// Whether a mesh edge folded by more than `angle_deg` (or an open edge with nothing beyond it)
  /// passes within distance_m of the point, at a height within 1 m of z_m.
  bool near_fold(double x_m, double y_m, double z_m, double distance_m) const;

  /// Finds the folded edges once; welds vertices closer than 1 mm for this only.
  void find_folds(double angle_deg);

 private:
  struct Edge {
    Eigen::Vector3d a, b;
  };
  road::Mesh mesh_;
  std::unordered_map<long long, std::vector<std::size_t>> triangles_of_cell_;
  std::unordered_map<long long, std::vector<Edge>> folds_of_cell_;
};

}  // namespace support
