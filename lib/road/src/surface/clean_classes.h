// What names and geometry say of every triangle before anything is kept. Private to cleaning.
#pragma once

#include <string>
#include <vector>

#include "road/clean.h"

namespace road {

/// What is known of every triangle before anything is kept.
struct Triangles {
  std::vector<bool> empty;  ///< without area, or hidden: never looked at
  std::vector<bool> flat;
  std::vector<SurfaceClass> by_names;
  std::vector<bool> is_named;  ///< of each object: a name rule tells its class
  bool has_named_road = false;
  std::vector<std::uint32_t> left_out;  ///< from the start: hidden_triangles()
  std::vector<std::string> remarks;     ///< of them
};

Triangles look_at(const Mesh& mesh, const CleanOptions& options);

/// Whether nothing that is flat is called anything else than road: then names cannot mislead.
bool is_all_road(const Mesh& mesh, const Triangles& triangles);

/// Class of each triangle of the mesh from its geometry alone: road, runoff or scenery (all steep
/// ones); and what speaks against that, where something does.
struct ClassesByShape {
  std::vector<SurfaceClass> of_triangle;
  std::string doubt;
  bool is_told = false;  ///< near_m of the options told which of the strips
};
ClassesByShape classes_by_shape(const Mesh& mesh, const std::vector<bool>& empty,
                                const std::vector<bool>& flat, const CleanOptions& options);

/// Area that both call road over the area that either does; flat triangles only.
double agreement(const Mesh& mesh, const std::vector<SurfaceClass>& a,
                 const std::vector<SurfaceClass>& b, const std::vector<bool>& flat);

}  // namespace road
