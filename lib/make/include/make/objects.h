// What a mesh consists of, what cleaning takes each object for, and why.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "make/recipe.h"

namespace road {

/// One object with one material.
struct ObjectRow {
  std::string object, material;  ///< as the file names them
  std::string surface_class;  ///< "road", "kerb", ... of most of its area; where cleaning refused
                              ///< the mesh what its names say, or "unknown"
  std::string why;            ///< the name rule, or "shape", "colour", "the guide"
  std::size_t triangles = 0;
  double area_m2 = 0.0;
  /// Median over its triangles of their height above the road that lies above or below them within
  /// 50 m; empty where there is none.
  std::optional<double> above_road_m;
};

struct ObjectTable {
  std::vector<ObjectRow> rows;  ///< by class (road first), then from large to small
  std::string up, unit;
  std::string refusal;               ///< why cleaning refused the mesh; empty where it did not
  std::vector<std::string> remarks;  ///< of reading and cleaning
};

/// Reads and cleans the recipe's mesh. Throws Error when it cannot be read; a mesh that cleaning
/// refuses is listed all the same.
ObjectTable objects_of(const Recipe& recipe);

}  // namespace road
