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
  std::vector<double> driven_m;  ///< distance along the path; large where a new piece begins
  std::vector<int> piece;        ///< counts up at gaps of more than 1 s, and where the path leaps
  double longest_step_s = 1.0;   ///< between poses; nothing is known of what is between others

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

/// Fills driven_m, piece and longest_step_s from the rest. A leap: a step of 5 cm and more that the
/// steps before and behind, noise and what cars can do leave unexplained. Gaps in which nothing is
/// known are longer than ten steps as usual, and 0.15 s.
void measure(Trajectory& trajectory);

/// How far what pose_at() says between two poses lies from the path, in the worst twentieth of it:
/// found from one pose in two.
double unknown_between_m(const Trajectory& trajectory);

/// The first pose, or one behind a gap of more than 1 s.
bool begins_drive(const Trajectory& trajectory, std::size_t pose);

/// A pose between two of the trajectory.
struct PosedInstant {
  Eigen::Vector3d position_m;
  Eigen::Quaterniond orientation;
  double driven_m = 0.0;
  /// From the sensor's axes into the map's: `orientation * v`, which compilers leave a call.
  Eigen::Vector3d turned(const Eigen::Vector3d& v) const {
    const double w = orientation.w(), x = orientation.x(), y = orientation.y(), z = orientation.z();
    const double a = 2.0 * (y * v.z() - z * v.y()), b = 2.0 * (z * v.x() - x * v.z()),
                 c = 2.0 * (x * v.y() - y * v.x());
    return {v.x() + w * a + (y * c - z * b), v.y() + w * b + (z * a - x * c),
            v.z() + w * c + (x * b - y * a)};
  }
};

/// Linear in position, normalised linear in rotation; over more than 0.025 s cubic. `hint`: index
/// near the answer, moved; the answer does not depend on it. False before the first pose, behind
/// the last, or inside a gap.
bool pose_at(const Trajectory& trajectory, double time_s, std::size_t& hint, PosedInstant& pose);

}  // namespace cloud
