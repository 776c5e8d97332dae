// What the inputs of a map are tried with, to find what is wrong with them.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "causes.h"

namespace cloud {

struct Sample {
  double time_s;
  Eigen::Vector3d point_m;
};

/// Points to try with, and how the clock of all of them runs.
struct Samples {
  std::vector<Sample> list;
  double begin_s = std::numeric_limits<double>::infinity(), end_s = -begin_s;
  bool by_rings = false;  ///< between falls each laser by itself: no sweeps
  std::size_t falls = 0;  ///< times that lie 20 ms and more before that of the point before
  std::size_t points = 0, stamps = 0;  ///< all, and those at another time than the one before
};

/// Every so many points that no more than 40,000 are left.
Samples samples_of(const CloudSource& scans);

inline constexpr double kSweep_s = 1.5;  ///< no scanner takes longer

/// Times that begin again in each sweep; empty: they do not.
std::string about_sweeps(const Samples& samples);
/// Times that no clock of all points has; empty: they are as wanted.
std::string about_times(const Samples& samples, const Trajectory& trajectory);
/// Poses so far apart that the car's own bumps lie between them, in words.
std::string about_distance(const Trajectory& trajectory);

/// One change of the inputs.
struct Trial {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  ///< of the sensor; or a reflection
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();   ///< of the sensor on the car
  double late_s = 0.0;                                 ///< added to the points' times
  double points_times = 1.0, poses_times = 1.0;
  Eigen::Vector3d poses_shift_m = Eigen::Vector3d::Zero();  ///< of the poses in the map
  void (*poses_otherwise)(Trajectory& poses) = nullptr;     ///< as they may have been meant
  bool with_planes = true;
};

/// A trial and what it gave: the median distance of the points from the base; infinite where too
/// few lie on it.
struct Tried {
  Trial trial;
  double distance_m = std::numeric_limits<double>::infinity();
};

/// What trials are made on.
class Bench {
 public:
  Bench(Samples samples, const RoadFrame& frame, const Trajectory& poses,
        const MapOptions& options);

  const Samples& samples() const { return samples_; }
  const Trajectory& poses() const { return poses_; }
  /// Rows of the poses on the road; below 0 where they lie beside it.
  const std::vector<double>& rows() const { return rows_; }

  std::vector<double> distances_of(const std::vector<Trial>& trials) const;
  /// The first of those that bring the points closest.
  Tried best_of(const std::vector<Trial>& trials) const;

 private:
  double distance_of(const Trial& trial) const;

  Samples samples_;
  const RoadFrame& frame_;
  const Trajectory& poses_;
  std::vector<double> rows_;
  const MapOptions& options_;
  mutable std::size_t tried_ = 0;
};

}  // namespace cloud
