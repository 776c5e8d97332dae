// What the surface and the scenery of a synthetic circuit are built with.
#pragma once

#include <cstdint>
#include <vector>

#include "circuit/circuit.h"
#include "mesh_builder.h"

namespace road {

/// One cross section of the surface: vertices from right to left, and where its parts begin.
struct Ring {
  double u_m = 0.0;
  CrossSection cross{};
  std::vector<double> v_m;
  std::vector<std::uint32_t> vertex;
  std::size_t kerb_right = 0, road_right = 0, road_left = 0,
              kerb_left = 0;  ///< index of the vertex at each border
};

/// Heights of the land around: at least 0.8 m below every surface within reach, rising away from
/// it.
class Terrain {
 public:
  explicit Terrain(const Circuit& circuit);
  double height_m(double x_m, double y_m) const;

 private:
  struct Sample {
    double x_m, y_m, z_m;
  };
  std::vector<Sample> samples_;
  double reach_m_ = 0.0;
  double hill_m_ = 0.0;
};

/// Barriers, skirts, terrain, bridges, trees, stands, gantries around a finished surface. Objects
/// along the track are cut every `chunk_m`.
void add_scenery(const Circuit& circuit, const std::vector<Ring>& rings, double chunk_m,
                 MeshBuilder& builder);

}  // namespace road
