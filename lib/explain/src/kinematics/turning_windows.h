// Windows of recordings in which gyro and map are compared, as rows of a linear problem.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "explain/banking_by_turning.h"

namespace explain {

/// Of each window: what the gyro turned (read `delay_s` later, without a filter of `filter_s`) less
/// what map and stated road say, rad; how far the gyro turned at each place, rad (of the two it has
/// the less noise, and noise on both sides of an equation is a gain), and the car went there, m;
/// what errors of the gyro would make.
struct TurningWindows {
  Eigen::VectorXd more_rad;            ///< gyro less stated
  Eigen::MatrixXd turned_rad, went_m;  ///< windows x places
  Eigen::MatrixXd errors;              ///< windows x kErrors
  std::vector<int> fold;               ///< half laps, from 0; small ones join the one before
  int folds = 0;
};
/// Columns of errors: per unit of gain and bias; of more delay; of what a filter is beyond a delay;
/// of side slip per lateral acceleration.
enum GyroError : Eigen::Index { kGain, kBias, kDelay, kFilter, kSlip, kErrors };

TurningWindows turning_windows(const std::vector<Turning>& logs, double length_m, bool closed,
                               Eigen::Index places, double delay_s, double filter_s);

/// Of the recordings at each place: how far was turned and gone in all; mean stated bank and grade;
/// mean v. Places where nobody drove have what lies before them.
struct TurnedPlaces {
  Eigen::VectorXd turned_rad, went_m, bank, grade, v_m;
};
TurnedPlaces turned_places(const std::vector<Turning>& logs, double length_m, bool closed,
                           Eigen::Index places);

}  // namespace explain
