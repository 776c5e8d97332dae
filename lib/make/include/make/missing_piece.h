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

/// A doubt about a line with a missing piece, with the way out that was tried: the bridge that
/// closes the road, else a guide. `options` are those that the line was found with. Empty where the
/// line is closed, its ends do not face each other, or somebody said which road is meant (a guide,
/// a route).
std::optional<std::string> doubt_about_ends(const Centreline& line, const Mesh& mesh,
                                            const CleanOptions& options);

}  // namespace road
