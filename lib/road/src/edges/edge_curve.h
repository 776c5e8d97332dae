// A surveyed edge as a dense curve. Private to the edges stage.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "road/edges.h"

namespace road {

/// Points about 0.1 m apart along the edge, with the length s up to each. A closed curve does not
/// repeat its first point; an open one goes straight on beyond both ends, from s < 0 to s >
/// length_m.
struct EdgeCurve {
  std::string path;
  std::vector<Eigen::Vector3d> points_m;
  std::vector<double> s_m;
  std::vector<double> s_of_given_m;  ///< of the points of the file that were kept
  std::vector<Eigen::Vector3d> given_m;
  double length_m = 0.0;
  bool closed = false;
  std::size_t dropped = 0;
  std::vector<std::string> remarks;

  /// Position at s; wrapped when closed.
  Eigen::Vector3d at(double s_m) const;
};

/// Drops repeated points, up to five in a row that stick out, and what follows after the edge has
/// come round to its start, decides open or closed, checks the order of points. Throws Error with
/// file:line.
EdgeCurve edge_curve(const Edge& edge, bool reversed = false);

/// Where a curve is met from a place beside it: `v_m` along the normal there.
struct EdgeMeeting {
  bool found = false;
  double v_m = 0.0, s_m = 0.0, z_m = 0.0;
};
/// Where the straight line through `from` along `normal` meets the curve, looking along the curve
/// outwards from `s_guess_m` up to `reach_m`; false when it does not.
EdgeMeeting meet_edge(const EdgeCurve& curve, double s_guess_m, double reach_m,
                      const Eigen::Vector2d& from, const Eigen::Vector2d& normal);

/// The same where the curve comes nearest to `from`; `v_m` is that distance.
EdgeMeeting nearest_on_edge(const EdgeCurve& curve, double s_guess_m, double reach_m,
                            const Eigen::Vector2d& from);

}  // namespace road
