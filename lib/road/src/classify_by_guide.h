// What is road, told by a rough line along it. Private to clean.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "road/clean.h"
#include "road/guide.h"

namespace road {

/// Whether materials and pictures tell anything apart.
bool has_several_looks(const Mesh& mesh);

struct GuidedClasses {
  std::vector<SurfaceClass> class_of_triangle;
  std::vector<std::string> remarks;
};

/// Road is what lies along the guide between the places where the look (material and picture, else the
/// object), the slope or the surface ends; kerbs are what is named so beside it, everything else that is
/// flat and within reach is run-off. Names of roads do not count. Throws Error where no surface lies
/// under the guide, and where the surface goes on on both sides and `width_m` is not given.
GuidedClasses classes_along(const Mesh& mesh, const Guide& guide, std::optional<double> width_m, const std::vector<bool>& flat,
                            const std::vector<SurfaceClass>& by_names);

}  // namespace road
