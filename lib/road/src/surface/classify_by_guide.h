// What is road, told by a rough line along it. Private to clean.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/answer.h"
#include "road/clean.h"
#include "road/guide.h"

namespace road {

/// Whether materials and pictures tell anything apart.
bool has_several_looks(const Mesh& mesh);

struct GuidedClasses {
  std::vector<SurfaceClass> class_of_triangle;
  std::vector<std::string> remarks;
  std::vector<std::string> doubts;  ///< why this may not be the road that is meant
};

/// Road is what lies along the guide between the places where the look (material and picture, else
/// the object), the slope or the surface ends; kerbs are what is named so beside it, everything
/// else that is flat and within reach is run-off. Names of roads count where they call nearly all
/// of the guide road. Doubts: no road under more than 5 % of the guide, more than 30 % of it over
/// surface that does not tell where the road ends, or a road much wider than usual along more than
/// 1 % of it. A refusal where no surface lies under the guide, and where most of it does not tell
/// and `width_m` is not given; one for NotUsable where more than 30 % of the guide have no road
/// under it.
base::Answer<GuidedClasses> classes_along(const Mesh& mesh, const Guide& guide,
                                          std::optional<double> width_m,
                                          const std::vector<bool>& flat,
                                          const std::vector<SurfaceClass>& by_names);

}  // namespace road
