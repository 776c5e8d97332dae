// What is road, told by the colours of objects where names are silent. Private to cleaning.
#pragma once

#include <optional>
#include <vector>

#include "cleaning.h"

namespace road {

/// Road is what is grey among ground that is coloured; what a name tells otherwise stays that.
/// Nothing where the options let no names count, where a name tells the road, and where colours
/// tell nothing: no grey ground or hardly any other, or much between them.
std::optional<std::vector<SurfaceClass>> classes_by_colour(const Mesh& mesh,
                                                           const Triangles& triangles,
                                                           const CleanOptions& options);

/// A road that its colour shows plainly, or nothing: one way that takes up nearly all of the grey
/// surface that hangs together, long and slim, with coloured ground along both of its sides, none
/// of which is a road of its own beside it.
struct ColouredRoad {
  Cleaning cleaning;
  RoadShown shown;
};
std::optional<ColouredRoad> road_by_colour(const Mesh& mesh, const Triangles& triangles,
                                           const CleanOptions& options, const CleanReport& facts);

/// The road by its shape, or the one by its colour where it is the same road told more exactly, or
/// where shape shows none that compares; says which. A refusal where both show different roads.
base::Answer<Cleaning> clean_by_colour_or_shape(const Mesh& mesh, const Triangles& triangles,
                                                ColouredRoad coloured, ClassesByShape by_shape,
                                                const CleanOptions& options,
                                                const CleanReport& facts);

}  // namespace road
