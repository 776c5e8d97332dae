// A stage between the sampled heights and the file. A file of this folder holds one: its keys, what
// it does, what summary.json says of it. list.cpp puts them in their order. Private.
#pragma once

#include <optional>
#include <vector>

#include "make/make_road.h"
#include "mesh/ray_surface.h"
#include "road/friction.h"
#include "stage_json.h"

namespace road {

struct GridWork {
  const Recipe& recipe;  ///< in the frame of the mesh
  const std::optional<FrictionPaint>& paint;
  const RaySurface& surface;
  MadeRoad& built;  ///< the stages change its sampled heights, and add to it
};

struct GridStage {
  const char* name;  ///< of its keys, and in timing.json
  void (*add_keys)(std::vector<RecipeKey>&);
  /// Whether the recipe asks for it; null: always.
  bool (*wanted)(const Recipe&) = nullptr;
  void (*run)(const GridWork&);
  /// Adds its part to summary.json.
  void (*report)(const BuildSummary&, Json&);
};

/// All of them in the order in which they run.
const std::vector<GridStage>& grid_stages();

}  // namespace road
