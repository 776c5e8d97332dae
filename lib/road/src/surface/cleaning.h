// The steps of cleaning that its ways of telling road from scenery share. Private to cleaning.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/answer.h"
#include "clean_classes.h"
#include "clean_soup.h"
#include "road/clean.h"

namespace road {

/// The longest piece of missing road that a look at the whole takes for a gap.
constexpr double kRoadGap_m = 12.0;

/// What is left of several roads.
enum class Keep : std::uint8_t { one, touching_road, all };

/// A cleaned surface, and the classes that it came from.
struct Cleaning {
  Soup soup;
  CleanReport facts;
  std::vector<SurfaceClass> class_of_triangle;
  bool is_sure = false;  ///< names alone show a closed road, and nothing else: look no further
};

/// Everything from classes to a welded surface. With `doubtful` classes (nobody confirms them) also
/// gaps that are longer than a crack are looked at. A refusal where nothing is left, and where it
/// would have to choose between circuits.
base::Answer<Cleaning> clean_classes(const Mesh& mesh, const Triangles& triangles,
                                     std::vector<SurfaceClass> class_of_triangle,
                                     const CleanOptions& options, CleanReport facts, bool doubtful,
                                     Keep keep = Keep::one);

/// A road that is narrower than this share of another one round the same way is a part of it.
constexpr double kLaneShare = 0.6;

/// How much road a surface shows: the longest way through it, less what is not closed, and less
/// what lies beside it.
struct RoadShown {
  double length_m = 0.0, share = 0.0, width_m = 0.0;
  bool closed = false;
  std::optional<std::string> alike = {};  ///< two closed roads, and nothing tells which
  double worth() const;
};
RoadShown road_shown(const Soup& soup);

/// "a closed road of about 1200 m (95 % of what looks like road)".
std::string text_of(const RoadShown& shown);

/// The road by its shape. Where the flat ground as a whole is a closed road, shape must not find
/// only a part of it: the whole is taken in place of an open strip, and a closed lane that is much
/// narrower is doubted.
base::Answer<Cleaning> clean_by_shape(const Mesh& mesh, const Triangles& triangles,
                                      std::vector<SurfaceClass> by_shape,
                                      const CleanOptions& options, const CleanReport& facts);

/// Both ways of telling road from scenery, and of these the one that shows more of a road; says
/// which and why. A refusal is that of the names' way, with what shape finds as a way out.
base::Answer<Cleaning> more_plausible(const Mesh& mesh, const Triangles& triangles,
                                      std::vector<SurfaceClass> by_shape,
                                      const CleanOptions& options, const CleanReport& facts);

}  // namespace road
