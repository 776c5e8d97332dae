// In which unit a mesh would be a road, where it is none in the one it was read in. Private.
#pragma once

#include <string>

#include "road/clean.h"
#include "road/mesh.h"

namespace road {

/// A clause for a refusal ("; in inch (--unit inch) ..."), or nothing. Every unit is tried: the
/// mesh is cleaned and the road traced as a build would. Where none has a road, but the mesh as it
/// is has one wider than any, that is said. Nothing is said where the mesh, as it is, has a road
/// after all (then the refusal has another reason), or where it is so large that trying takes long.
std::string unit_with_a_road(const Mesh& mesh, double metres_per_unit, const CleanOptions& options);

}  // namespace road
