// Common road, each car's own share of it, and the cars' columns, as one estimate.
//
// What a car alone seems to see of the road is no noise: its stated curves get the same things
// wrong at the same places every lap. It is a profile of its own (seen by forces only), as large as
// makes the drives most likely. So one car says no more about the road than its own profile leaves,
// however many laps it drove, and each further car does.
#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <vector>

#include "fleet_car.h"

namespace explain {

/// Standard deviations of profiles, per kind. 0: none of it.
using Sizes = std::array<double, kRoadKinds>;

/// How profiles lie along the lap: alike over about 100 m.
struct RoadShape {
  std::size_t knots = 0;
  std::array<Eigen::MatrixXd, kRoadKinds> common, own;  ///< inverse covariances at size 1
};
RoadShape road_shape(std::size_t knots, double length_m, bool closed);

/// 1 / covariance of all road columns.
Eigen::MatrixXd precision_of(const RoadShape& shape, const Sizes& sizes, bool common);
/// Logarithm of its determinant.
double log_determinant(const RoadShape& shape, const Sizes& sizes, bool common);

/// What a car says about the common road when all of its own is taken out, and the logarithm of how
/// likely that is on a road without errors.
struct CarSays {
  Eigen::MatrixXd information;
  Eigen::VectorXd right;
  double evidence = 0.0;
};

/// `in`: columns of the car that count; others are taken to be zero. Throws vehicle::Error where
/// the sums are none of a fit.
CarSays says(const CarSums& car, const RoadShape& shape, const Sizes& own,
             const std::vector<std::size_t>& in);

/// Of the road, from what cars say and its prior.
struct RoadEstimate {
  Eigen::MatrixXd precision;
  Eigen::VectorXd right, amounts;
  double evidence = 0.0;  ///< logarithm; of all but the cars' own evidence
};
RoadEstimate road_estimate(const std::vector<const CarSays*>& cars, const RoadShape& shape,
                           const Sizes& sizes);

/// All of a car's unknowns that are in, with the road as the others and its prior have it.
struct CarEstimate {
  std::vector<Eigen::Index> places;  ///< in the car's sums: road, own profile, columns
  Eigen::LLT<Eigen::MatrixXd> solver;
  Eigen::VectorXd amounts;
};
CarEstimate estimate(const CarSums& car, const RoadShape& shape, const Sizes& own,
                     const std::vector<std::size_t>& in, const RoadEstimate& others);

/// What freeing each column of a car would save of the loss, beside everything that is in, and the
/// road as the other cars and its prior have it.
struct ColumnTest {
  std::size_t column = 0;
  double amount = 0.0, deviation = 0.0, gain = 0.0;
};
struct CarTests {
  std::vector<ColumnTest> test;
  Eigen::MatrixXd left;     ///< of the tested columns' products, where all else is taken out
  Eigen::VectorXd amounts;  ///< of road, own profile, columns in
  std::vector<ColumnTest> refitted;    ///< of columns in: as if freed from their priors
  std::vector<double> mean, variance;  ///< of the same, with their priors
};
/// `others`: what the road has from all but this car.
CarTests test_columns(const CarSums& car, const RoadShape& shape, const Sizes& own,
                      const std::vector<std::size_t>& in, const std::vector<std::size_t>& tested,
                      const RoadEstimate& others);

}  // namespace explain
