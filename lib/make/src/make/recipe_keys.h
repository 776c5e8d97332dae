// The keys of a recipe, stage by stage. Private to the recipe.
#pragma once

#include <vector>

#include "make/recipe.h"

namespace road {

/// From the mesh to its road surface and the line on it.
void add_surface_keys(std::vector<RecipeKey>& keys);

/// The grid: steps, kerbs, smoothing, friction.
void add_grid_keys(std::vector<RecipeKey>& keys);

/// Where it lies on the Earth, what is written, and when it is good enough.
void add_output_keys(std::vector<RecipeKey>& keys);

}  // namespace road
