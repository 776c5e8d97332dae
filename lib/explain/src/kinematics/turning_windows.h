// Windows of recordings in which gyro and map are compared, as rows of a linear problem.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "explain/banking_by_turning.h"
#include "off_the_line.h"

namespace explain {

/// The two places beside u, and the share of the second. Not finite u: the first place.
struct Beside {
  Eigen::Index first = 0, second = 0;
  double share = 0.0;
};
Beside beside(double u_m, double length_m, bool closed, Eigen::Index places);

/// From step i to the next along the road, over the line of a closed one too, m.
double went(const Turning& log, std::size_t i, double length_m, bool closed);

/// Of each window: what the gyro turned (read `delay_s` later, without a filter of `filter_s`) less
/// what map and stated road say, rad; how far the gyro turned at each place, rad (of the two it has
/// the less noise, and noise on both sides of an equation is a gain), and the car went there, m;
/// what errors of the gyro would make.
struct TurningWindows {
  Eigen::VectorXd more_rad;            ///< gyro less stated
  Eigen::MatrixXd turned_rad, went_m;  ///< windows x places
  /// The metres gone there times how the car was off the usual line: m, its slope, its bend.
  Eigen::MatrixXd beside_m2, slope_m, bend;
  Eigen::MatrixXd errors;  ///< windows x kErrors
  std::vector<int> fold;   ///< half laps, from 0; small ones join the one before
  int folds = 0;
};
/// Columns of errors: per unit of gain and bias; of more delay; of what a filter is beyond a delay;
/// of side slip per lateral acceleration.
enum GyroError : Eigen::Index { kGain, kBias, kDelay, kFilter, kSlip, kErrors };

/// `off`: of each recording.
TurningWindows turning_windows(const std::vector<Turning>& logs, const std::vector<OffTheLine>& off,
                               double length_m, bool closed, Eigen::Index places, double delay_s,
                               double filter_s);

/// Of the recordings at each place: how far was turned and gone in all; mean stated bank and grade;
/// mean v. Places where nobody drove have what lies before them.
struct TurnedPlaces {
  Eigen::VectorXd turned_rad, went_m, bank, grade, v_m;
};
TurnedPlaces turned_places(const std::vector<Turning>& logs, double length_m, bool closed,
                           Eigen::Index places);

}  // namespace explain
