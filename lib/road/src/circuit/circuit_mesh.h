// What the surface and the scenery of a synthetic circuit are built with.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "road/circuit.h"
#include "road/mesh.h"
#include "road/synth.h"

namespace road {

enum class Part : std::uint8_t {
  road,
  start_strip,
  kerb,
  runoff,
  barrier,
  terrain,
  trees,
  grandstand,
  gantry,
  bridge
};

/// Collects triangles under objects that come into being when first asked for.
class MeshBuilder {
 public:
  explicit MeshBuilder(NameStyle names) : names_(names) {}

  std::uint32_t object(Part part, Side side = Side::left, int number = 0);
  std::uint32_t vertex(const Eigen::Vector3d& position_m);
  const Eigen::Vector3d& position(std::uint32_t vertex) const { return mesh_.vertices_m[vertex]; }

  /// Corners counter-clockwise seen from where the face is seen from.
  void triangle(std::uint32_t object, std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void quad(std::uint32_t object, std::uint32_t a, std::uint32_t b, std::uint32_t c,
            std::uint32_t d);
  void quad(std::uint32_t object, const std::array<Eigen::Vector3d, 4>& corners);
  /// Corners 0-3 the bottom, counter-clockwise seen from above, 4-7 the top over them.
  void box(std::uint32_t object, const std::array<Eigen::Vector3d, 8>& corners);

  Mesh take() { return std::move(mesh_); }

 private:
  NameStyle names_;
  Mesh mesh_;
  std::map<std::tuple<Part, Side, int>, std::uint32_t> objects_;
};

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
