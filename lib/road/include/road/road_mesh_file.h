// The cleaned road surface as a file, for stages that run one by one.
#pragma once

#include <string>

#include "road/recipe.h"

namespace road {

/// Writes .obj with objects called "<class>:<name>", or .stl or .ply, which carry neither.
void write_road_mesh(const RoadMesh& road, const std::string& path);

/// A file of write_road_mesh comes back as it is (from .stl and .ply all of it as road). Any other
/// mesh is read and cleaned as the recipe says. Throws Error.
RoadMesh read_road_mesh(const Recipe& recipe);

}  // namespace road
