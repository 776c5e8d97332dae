// A map of the car over two axes, and a few numbers beside it, from rows that each feel many of its
// places: an engine's from the windows of a drive, or the pads'.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "longitudinal.h"

namespace identify {

/// A fit's memory grows with the square of them, its time with the cube.
inline constexpr std::size_t kMostMapPlaces = 1000;

/// Weights of a map's places at (x, y), by the straight lines of vehicle::evaluate: up to four.
/// Places are counted as in vehicle::Map2. Axes of at least two places.
std::vector<std::pair<std::size_t, double>> map_weights(const std::vector<double>& x_axis,
                                                        const std::vector<double>& y_axis, double x,
                                                        double y);

/// Covariance of the places' deviations from the stated map; `size[place]` is the unit of each. All
/// of them together may be 0.3 off, each 0.1 beside that, neighbours alike: squared exponential in
/// both axes (C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, 2006).
Eigen::MatrixXd map_covariance(const std::vector<double>& x_axis, const std::vector<double>& y_axis,
                               const Eigen::VectorXd& size);

struct MapFit {
  Eigen::VectorXd value;              ///< deviations from what was stated
  Eigen::MatrixXd noise, prior_left;  ///< covariances: by the rows; by what they leave open
  Eigen::VectorXd weight;             ///< of each row, 0 to 1: far ones hardly count
  double sd = 0.0;                    ///< of a row that counts fully
  std::size_t blocks = 0;
};

/// rows * value = wanted by least squares beside a prior of covariance `prior` about 0. Rows of one
/// `block` may share their errors: `noise` is the jackknife's that leaves out one block at a time,
/// and rows count less by as much as their errors go together. Cauchy's loss. At least two blocks.
MapFit map_fit(const Eigen::MatrixXd& rows, const Eigen::VectorXd& wanted,
               const std::vector<std::size_t>& block, const Eigen::MatrixXd& prior);

/// The same with the weights and the noise of `like`: what other rows would have given.
Eigen::VectorXd map_fit_again(const Eigen::MatrixXd& rows, const Eigen::VectorXd& wanted,
                              const Eigen::MatrixXd& prior, const MapFit& like);

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
