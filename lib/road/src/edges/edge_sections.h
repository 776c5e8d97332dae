// Both edges as the normals of a line meet them. Private to the edges stage.
#pragma once

#include <Eigen/Core>

#include "crg/reference_line.h"
#include "edge_curve.h"
#include "edge_rungs.h"

namespace road {

/// Both edges as met by one normal.
struct EdgeSection {
  EdgeMeeting left, right;
};

/// `guess`: where along the edges they are met, roughly.
EdgeSection cut_edges(const EdgeCurve& left, const EdgeCurve& right, const Rung& guess,
                      const Eigen::Vector2d& at, const Eigen::Vector2d& normal);

/// Throws Error where an edge was not met.
void refuse_missed(const EdgeSection& section, const EdgeCurve& left, const EdgeCurve& right,
                   double u);

/// Stations where the normals of `line` meet both edges, from the first row of LEFT on: this
/// share of the way to the middle between them.
Centreline recut(const EdgeCurve& left, const EdgeCurve& right, const crg::ReferenceLine& line,
                 Rung guess, double share);

}  // namespace road
