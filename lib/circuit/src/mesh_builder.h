// Collects the triangles of a synthetic circuit under objects named as exporters name them. Private
// to the circuit's mesh.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <tuple>
#include <utility>

#include "circuit/circuit.h"
#include "circuit/synth.h"
#include "mesh/mesh.h"

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

}  // namespace road
