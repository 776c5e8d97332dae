// A road that leans in its turns, fitted to what a gyro turns less than the map asks.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "explain/banking_by_turning.h"
#include "turning_windows.h"

namespace explain {

/// The stated road with errors of the gyro alone.
struct WithoutLean {
  Eigen::VectorXd left_rad;  ///< of each window where the other half laps say how it is
  double gain = 0.0;         ///< of the gyro, that it asks for
  double unusual = 0.0;      ///< loss of these errors themselves: far from what is usual
};

/// How a road leans beyond its file; vectors over its places, which are equally far apart.
struct LeaningRoad {
  double place_m = 0.0, delay_s = 0.0;  ///< delay of the gyro
  Eigen::VectorXd side;                 ///< 1: leans into its turn if its left side is up; to -1
  std::vector<bool> turns;              ///< it does there
  TurnedPlaces turned;
  TurningWindows windows;
  Eigen::VectorXd added;       ///< rise to the left, m/m
  Eigen::MatrixXd moves;       ///< of `added`, one column per amount that was fitted
  Eigen::MatrixXd covariance;  ///< of these amounts
  Eigen::VectorXd pivot_v_m;   ///< about which it leans
  double gain = 0.0, bias_radps = 0.0;
  Eigen::VectorXd weight;             ///< of each window, 1/rad
  Eigen::VectorXd left_rad;           ///< of each window where the other half laps say how it is
  double unusual = 0.0;               ///< loss of the gyro's errors themselves
  WithoutLean stated, with_any_gain;  ///< with a gyro's gain as it is usual, and with any
};

/// In turns it leans by one amount each, on the way between them by another, with ramps as
/// long as the recordings say, each turn's at a place of its own, and smooth waves on top. It leans
/// about a line of its own: where banking changes, the nose of a car beside that line pitches,
/// which a leaning gyro feels as turning. None: less than 30 windows, or a road that does not turn.
std::optional<LeaningRoad> fit_leaning_road(const std::vector<Turning>& logs, double length_m,
                                            bool closed);

}  // namespace explain
