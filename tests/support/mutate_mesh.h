// What happens to meshes between simulators: small damages and changes of frame, one function each.
// Every one is seeded or exact, so that a test can say what it did and where.
//
// A test that wants a damaged circuit chains them:
//   Mesh mesh = make_circuit_mesh(circuit);
//   mesh = jitter(std::move(mesh), 0.001, 7);
//   mesh = punch_hole(std::move(mesh), {120, -3}, 0.025);
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "mesh/mesh.h"

namespace support {

/// Moves every vertex by up to `amplitude_m` along each axis. Vertices at the same place stay
/// together (a shared edge stays shut) unless `tear` is set.
road::Mesh jitter(road::Mesh mesh, double amplitude_m, std::uint64_t seed, bool tear = false);

/// Removes, or adds a second copy of, each triangle with probability `share`.
road::Mesh delete_triangles(road::Mesh mesh, double share, std::uint64_t seed);
road::Mesh duplicate_triangles(road::Mesh mesh, double share, std::uint64_t seed);

/// Turns the winding of each triangle with probability `share`.
road::Mesh flip_triangles(road::Mesh mesh, double share, std::uint64_t seed);

/// One nameless object, as from .stl.
road::Mesh strip_names(road::Mesh mesh);

/// Rotates about z by `yaw_rad`, then moves; the move goes into origin_m, so UTM coordinates keep
/// the precision of the vertices.
road::Mesh move_rigidly(road::Mesh mesh, double yaw_rad, const Eigen::Vector3d& translation_m);

/// Multiplies every coordinate: 1000 makes millimetres of metres that nobody declares.
road::Mesh scale(road::Mesh mesh, double factor);

/// Lifts all vertices with low.x <= x < high.x and low.y <= y < high.y by `step_m`: a tile surveyed
/// at another height. Map coordinates; the facets across its border become the step.
road::Mesh lift_tile(road::Mesh mesh, const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m,
                     double step_m);

/// Takes away what lies within `radius_m` of the point in plan view: triangles are split until the
/// border of the hole is within 0.2 radius of a circle. Everything at any height when z_m is NaN,
/// else within 1 m of it.
road::Mesh punch_hole(road::Mesh mesh, const Eigen::Vector2d& centre_m, double radius_m,
                      double z_m);

/// Moves the triangles whose centre lies beyond the line x = x_m by `gap_m` along +x, together: a
/// crack of that width along the edges that ran along the line, jagged where none did.
road::Mesh crack(road::Mesh mesh, double x_m, double gap_m);

}  // namespace support
