// Windows of recordings in which gyro and map are compared, as rows of a linear problem.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "explain/banking_by_turning.h"

namespace explain {

/// Of each window: what the gyro turned (read `delay_s` later) less what map and stated road say,
/// rad; how far the car turned at each place on the map, rad; what errors of the gyro would make.
struct TurningWindows {
  Eigen::VectorXd more_rad;    ///< gyro less stated
  Eigen::MatrixXd turned_rad;  ///< windows x places
  Eigen::MatrixXd errors;      ///< windows x kErrors
  std::vector<int> fold;       ///< half laps, from 0; small ones join the one before
  int folds = 0;
};
/// Columns of errors: per unit of gain and bias; of more delay; of what a filter is beyond a delay.
enum GyroError : Eigen::Index { kGain, kBias, kDelay, kFilter, kErrors };

TurningWindows turning_windows(const std::vector<Turning>& logs, double length_m, bool closed,
                               Eigen::Index places, double delay_s);

/// Of the recordings at each place: how far was turned in all, rad; mean stated bank and its
/// deficit of the cosine; mean v. Places where nobody drove have what lies before them.
struct TurnedPlaces {
  Eigen::VectorXd turned_rad, bank, deficit, v_m;
};
TurnedPlaces turned_places(const std::vector<Turning>& logs, double length_m, bool closed,
                           Eigen::Index places);

}  // namespace explain
