// Rauch-Tung-Striebel smoothing of a stretch of a log by the simulated car.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "car_motion.h"

namespace identify {

/// A channel of the log and what of the car it measures.
struct Sensor {
  std::string channel;
  bool seen = false;  ///< whether `place` is a SeenPlace, otherwise an EstimatedPlace
  std::size_t place = 0;
  std::size_t offset = kPlaces;  ///< place of its offset; kPlaces: none
  double deviation = 0.0;        ///< of its noise, in the channel's unit
  double own_deviation = 0.0;    ///< of what is noise from row to row
  std::size_t share = kPlaces;   ///< place of the share by which it shows more; kPlaces: none
};

struct Reading {
  std::size_t sensor = 0;
  double value = 0.0;
};

struct SmootherRow {
  double time_s = 0.0;
  Driven driven;  ///< until the next row
  std::vector<Reading> measured;
  PlaceVector noise;  ///< variance that came in since the row before
};

/// How a stretch begins.
struct SmootherBegin {
  CarPoint point;  ///< at the first row
  PlaceVector sd;  ///< of it; of the car's parts: about what they return to
  /// The car is lost where, over a quarter of a second, more than this share of the measurements
  /// are further than four standard deviations from what was expected. 1: never.
  double most_wild = 1.0;
  /// The steering sensor's offset is considered, not estimated: other stretches told it too.
  bool steer_offset_known = false;
};

/// What is known of a row by the whole stretch.
struct SmoothedRow {
  CarPoint point;
  Seen seen;
  std::array<double, kPlaces> point_sd{};
  std::array<double, kSeen> seen_sd{};
  /// Of both axles: sums of kSeenFx, kSeenFy, kSeenFz over its wheels.
  std::array<std::array<double, 3>, 2> axle{}, axle_sd{};
};

/// Sums for estimating noises: what they are by the smoothed stretch, and what was assumed.
struct NoiseSums {
  std::array<double, kPlaces> came_in{}, assumed{};
  std::vector<double> measured;  ///< per sensor: squares of what is left, with their variance
  std::vector<std::size_t> count;
  /// Of what stays as it is: the sum of how far beyond its begin each stretch by itself, whatever
  /// was known before, says that it is, times one over its variance; of these weights; of weight
  /// times square.
  std::array<double, kPlaces> part{}, part_weight{}, part_squares{};
  /// Of the stated numbers, in the order of kStated: what each stretch, whatever was known before,
  /// says of the share by which they are off, times one over its covariance; and of these weights.
  Eigen::Matrix<double, kStatedNumbers, 1> stated =
      Eigen::Matrix<double, kStatedNumbers, 1>::Zero();
  Eigen::Matrix<double, kStatedNumbers, kStatedNumbers> stated_weight =
      Eigen::Matrix<double, kStatedNumbers, kStatedNumbers>::Zero();
  std::size_t stretches = 0;
  std::size_t wild = 0;  ///< measurements further than four deviations: they count less
  void add(const NoiseSums& other);
};

/// Of their uncertainty, what the filter lets stated numbers have.
inline constexpr double kHeld = 0.03;

/// What stays as it is over the stretch, by its first row. Of parts without an uncertain rest see
/// add_parts. `variance`: of the row, the stated numbers being right.
void add_constants(const CarPoint& point, const PlaceVector& variance, const SmootherBegin& begin,
                   NoiseSums& sums);

/// Rests that are held, by how the parts are about them.
void add_parts(const CarPoint& point, const PlaceVector& variance, const SmootherBegin& begin,
               NoiseSums& sums);

/// What the stretch says of the stated numbers, by its first row: the filter lets them move a
/// little, and how far they went against how far they might have is what it says. `covariance`: of
/// the row, before they are held.
void add_stated(const PlaceVector& moved, const PlaceMatrix& covariance, const SmootherBegin& begin,
                NoiseSums& sums);

struct Smoothed {
  std::vector<SmoothedRow> row;  ///< empty: the car was lost, left the road or ran away
  NoiseSums sums;
};

/// The rows of one stretch without a gap; a gear changes half-way between two rows. Extended Kalman
/// filter forwards, then the modified Bryson-Fraser form of the smoother (G. J. Bierman, Fixed
/// interval smoothing with discrete measurements, 1973), which needs no inverse of a covariance.
/// Measurements further than four standard deviations from what was
/// expected count as that far away; where many are off, the deviations of all rows around grow.
Smoothed smooth(const CarMotion& motion, const std::vector<Sensor>& sensors,
                const std::vector<SmootherRow>& rows, const SmootherBegin& begin,
                vehicle::RoadCursors cursors);

}  // namespace identify
