// Where a road turns, and to which side it leans there if roads lean into their turns.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace explain {

/// Rise to the left of each place if it leans by one. Between turns that differ, from the one to
/// the other; all 0 if the road does not turn. `turns`: where it does.
Eigen::VectorXd side_of(const Eigen::VectorXd& turned_rad, double place_m, bool closed,
                        std::vector<bool>& turns);

/// Mean of the `reach` places before and behind, with weights of a bell of `bell_m`.
Eigen::VectorXd smooth(const Eigen::VectorXd& x, double place_m, bool closed, Eigen::Index reach,
                       double bell_m);

struct Turn {
  double begin_m = 0.0, end_m = 0.0;  ///< the end of one that goes on over the line is beyond it
  double side = 0.0;                  ///< rise to the left if it leans into itself by one
};
/// Stretches of 25 m or more that turn by more than half of the most nearby; those less than 60 m
/// apart are one. None of a circle.
std::vector<Turn> turns_of(const Eigen::VectorXd& curvature_1pm, double place_m, bool closed);

/// Where the lean of each turn begins and ends: how long its ramps are, and how far outside the
/// turn their middles lie.
struct Ramps {
  double length_m = 0.0;
  const Eigen::VectorXd &begin_m, &end_m;
};
/// Of each turn (columns), the rise to the left at each place where it leans by one.
Eigen::MatrixXd ramps_of(const std::vector<Turn>& turns, Eigen::Index places, double place_m,
                         bool closed, const Ramps& ramps);

}  // namespace explain
