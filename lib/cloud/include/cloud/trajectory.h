// Poses of the sensor over time.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace cloud {

/// map = position + orientation * sensor. All vectors have the same length, times ascend.
struct Trajectory {
  std::vector<double> time_s;
  std::vector<Eigen::Vector3d> position_m;
  std::vector<Eigen::Quaterniond> orientation;
  std::vector<double>
      driven_m;  ///< distance along the path; large where a gap of more than 1 s begins a new piece
  std::vector<int> piece;  ///< counts up at each such gap

  std::size_t size() const { return time_s.size(); }
};

/// CSV time_s,x_m,y_m,z_m,qx,qy,qz,qw. `extrinsic`: pose of the sensor in the frame that the poses
/// are of, applied on the right. Throws Error: fewer than two poses, times that do not
/// ascend, a quaternion that is not of length 1 within 1 %, values that are not finite, steps of
/// more than 1 km within a second (with the row); more than 2,000 km in all.
Trajectory read_trajectory(const std::string& path,
                           const Eigen::Isometry3d& extrinsic = Eigen::Isometry3d::Identity());

/// Writes the same columns, whole or not at all.
void write_trajectory(const Trajectory& trajectory, const std::string& path);

/// Fills driven_m and piece from the rest.
void measure(Trajectory& trajectory);

/// A pose between two of the trajectory.
struct PosedInstant {
  Eigen::Vector3d position_m;
  Eigen::Quaterniond orientation;
  double driven_m = 0.0;
};

/// Linear in position, normalised linear in rotation. `hint`: index near the answer, moved; the
/// answer does not depend on it. False before the first pose, behind the last, or inside a gap.
bool pose_at(const Trajectory& trajectory, double time_s, std::size_t& hint, PosedInstant& pose);

}  // namespace cloud
