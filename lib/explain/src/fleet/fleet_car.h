// All drives of one car, without what is a drive's own.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "explain/summary.h"

namespace explain {

/// Unknowns in this order: the road's as all rows see it; the same as rows with forces alone see
/// it, which is what this car pretends; columns of the car.
struct CarSums {
  std::string name, sha256;
  std::vector<std::size_t> drives;
  std::size_t laps = 0;
  double driven_s = 0.0;
  std::vector<SummaryColumn> columns;  ///< of the car, all that any drive has
  Eigen::MatrixXd normal;              ///< lower half
  Eigen::VectorXd right;
};

/// What a drive says once its own unknowns are taken out with their priors.
struct Reduced {
  Eigen::MatrixXd normal;  ///< lower half
  Eigen::VectorXd right;
};

/// A drive's own unknowns, beside the car's.
struct OwnOfDrive {
  std::vector<std::size_t> column;  ///< of the summary
  Eigen::MatrixXd normal;           ///< with the priors
  Eigen::MatrixXd with;             ///< products with the car's unknowns
  Eigen::VectorXd right;
};

/// Places of the columns that the car shares; columns that are new are added to the car.
std::vector<std::size_t> join_columns(CarSums& car, const DriveSummary& drive);

/// The drive's own unknowns beside those of a car with `width` columns.
OwnOfDrive own_of(const DriveSummary& drive, const std::vector<std::size_t>& places,
                  std::size_t width);

/// Throws vehicle::Error where the sums are none of a fit.
Reduced reduce(const DriveSummary& drive, const std::vector<std::size_t>& places,
               std::size_t width);

/// Adds it; `road` columns of the road. The car may have got more columns since.
void add(CarSums& car, const Reduced& drive, std::size_t road);

}  // namespace explain
