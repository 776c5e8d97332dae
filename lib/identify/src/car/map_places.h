// A map of the car from the windows of a drive: what an engine's and the pads' share.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "longitudinal.h"
#include "map_fit.h"

namespace identify {

/// rows * deviations = wanted: the first unknowns are the map's places less those it is about.
struct MapEquations {
  Eigen::MatrixXd rows;
  Eigen::VectorXd wanted;
};

/// A solution with everything that its intervals hold.
struct MapSolved {
  MapFit fit;
  Eigen::MatrixXd granted;  ///< covariance by what was taken for granted
};

/// 1 and the weighted sum of the unknowns.
Found map_factor(std::string name, const Eigen::VectorXd& weights, const MapSolved& solved);

/// The places with their intervals; those that the drive was not near are hidden.
class PlaceFinder {
 public:
  /// Seconds are counted in so many `counts`, apart.
  PlaceFinder(const vehicle::Map2& stated, const MapSolved& solved, std::size_t counts,
              FoundMap& out);
  /// The drive was here for so long, at this place of the road.
  void near(double x, double y, std::size_t count, double seconds, std::size_t block);
  /// Hides places with less than a second near them, counted by how near, or a 90 % interval wider
  /// than a tenth of their value or of `least` either way.
  void hide(double least, const char* of, const char* unit);

 private:
  FoundMap& out_;
  std::vector<std::set<std::size_t>> from_;  ///< places of the road
};

}  // namespace identify
