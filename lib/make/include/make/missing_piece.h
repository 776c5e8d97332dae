// An open line whose ends face each other: a piece of a closed road may be missing.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "road/centreline.h"
#include "road/clean.h"

namespace road {

struct MissingPiece {
  double length_m = 0.0;  ///< between the ends, straight
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
};

/// Of an open line that ends in front of its own beginning, in its direction within 45 degrees, at
/// most a tenth of its length away and about as high; empty for any other.
std::optional<MissingPiece> missing_piece(const Centreline& line);

/// The road with its gaps bridged, tried.
struct LongerRoad {
  double bridge_m = 0.0, length_m = 0.0;
  bool closed = false;
};

/// Where an open line is longer with gaps bridged: the closed road where a piece is missing, else
/// with the shortest of some bridges up to 40 m that makes it longer by 3 % or closed. `options`
/// are those that the line was found with. Empty where it is not, and where somebody said which
/// road is meant (a guide, a route).
std::optional<LongerRoad> longer_road(const Centreline& line, const Mesh& mesh,
                                      const CleanOptions& options);

/// A doubt about a line with a missing piece, or with a longer road, with the way out that was
/// tried. Empty where there is neither.
std::optional<std::string> doubt_about_ends(const Centreline& line, const Mesh& mesh,
                                            const CleanOptions& options);

}  // namespace road
