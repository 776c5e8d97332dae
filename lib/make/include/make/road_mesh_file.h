// The cleaned road surface as a file, for stages that run one by one.
#pragma once

#include <string>

#include "make/recipe.h"

namespace road {

/// Writes .obj with objects called "<class>:<name>", or .stl whose triangles carry the class as
/// their attribute, or .ply, which carries neither.
void write_road_mesh(const RoadMesh& road, const std::string& path);

/// An .obj or .stl of write_road_mesh comes back as it is. Any other mesh is read and cleaned as
/// the recipe says. Throws Error.
RoadMesh read_road_mesh(const Recipe& recipe);

}  // namespace road
