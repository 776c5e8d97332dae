// The design of a TORCS track, read from the XML beside its mesh: what a road made of the mesh is
// judged by.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mesh/mesh.h"

namespace support {

struct TorcsTrack {
  std::vector<Eigen::Vector2d>
      centre_m;  ///< about 1 m apart, starting at (0, 0) towards +x; the mesh is shifted
  double length_m = 0.0;
  double width_m = 0.0;
  double closing_gap_m = 0.0;  ///< end to start: designs close to centimetres or metres
};

/// Straights, arcs and spirals of "Main Track / Track Segments", as the simulator puts them
/// together (spirals in steps whose radius changes linearly). Throws std::runtime_error.
TorcsTrack read_torcs_track(const std::string& xml_path);

/// What the exporter named as something to drive on, and a start strip of corkscrew that is part of
/// the road.
road::Mesh drivable_by_name(const road::Mesh& mesh);

}  // namespace support
