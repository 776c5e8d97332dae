// The middle of the road between its two borders. Private to trace_centreline.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "border_curve.h"
#include "mesh/ray_surface.h"
#include "stations.h"

namespace road {

/// The middle of a cross-section, at its place along the walk.
struct Middle {
  double s_m;
  Eigen::Vector3d point;
  double half_width_m;
};

/// One middle for every point of both borders that has a point opposite to it, in the order of the
/// walk; those that stand for the same cross-section are one.
std::vector<Middle> middles_between(const RaySurface& surface, const Walk& walk,
                                    const BorderCurve& left, const BorderCurve& right,
                                    const std::vector<double>& station_s_m);

/// Whether a cross-section is like the walk's there; at junctions a border may be that of another
/// road.
bool agrees(const Middle& middle, const Walk& walk, const std::vector<double>& station_s_m,
            double unlike);

}  // namespace road
