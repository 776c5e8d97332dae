#include "cloud/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/csv.h"
#include "base/statistics.h"
#include "base/write_file.h"
#include "cloud/error.h"

namespace cloud {
namespace {

constexpr double kLongestStep_m = 1000.0;  // within a second
constexpr double kLongestDrive_m = 2e6;    // memory grows with the distance driven
constexpr double kGap_s = 1.0;             // begins a new piece
constexpr double kLeastGap_s = 0.15;       // a car that brakes is 5 mm beside a line through it
// No car changes its acceleration faster; places told in steps, and noise, are no leaps.
constexpr double kMostJerk_mps3 = 100.0, kLeastLeap_m = 0.05;
constexpr double kTimesMedian = 10.0, kTimesMost = 4.0;

double step_s(const Trajectory& trajectory, std::size_t i) {
  return trajectory.time_s[i] - trajectory.time_s[i - 1];
}

/// By how much the way from a pose to the next differs from what the ways before and behind lead to
/// expect; 0 beside gaps.
std::vector<double> unexpected_ways(const Trajectory& trajectory, double longest_step_s) {
  std::vector<double> out(trajectory.size(), 0.0);
  const auto speed = [&](std::size_t i) -> Eigen::Vector3d {
    return (trajectory.position_m[i] - trajectory.position_m[i - 1]) / step_s(trajectory, i);
  };
  for (std::size_t i = 2; i + 1 < trajectory.size(); ++i) {
    const double longest_s =
        std::max({step_s(trajectory, i - 1), step_s(trajectory, i), step_s(trajectory, i + 1)});
    if (longest_s > longest_step_s) continue;
    const Eigen::Vector3d off_mps = speed(i) - 0.5 * (speed(i - 1) + speed(i + 1));
    const double off_m = off_mps.norm() * step_s(trajectory, i);
    out[i] = std::max(0.0, off_m - 0.5 * kMostJerk_mps3 * std::pow(longest_s, 3));
  }
  return out;
}

double quantile(std::vector<double> values, double share) {
  return values.empty() ? 0.0 : base::quantile(std::move(values), share);
}

/// A step of poses that begins a piece of its own: 1 and 0.
std::vector<std::uint8_t> leaps_in(const Trajectory& trajectory) {
  const std::vector<double> off_m = unexpected_ways(trajectory, trajectory.longest_step_s);
  const double least_m = std::max(
      {kLeastLeap_m, kTimesMedian * quantile(off_m, 0.5), kTimesMost * quantile(off_m, 0.95)});
  std::vector<std::uint8_t> leaps(trajectory.size(), 0);
  // Beside a leap half of it is unexpected.
  for (std::size_t i = 2; i + 1 < trajectory.size(); ++i)
    leaps[i] = off_m[i] > least_m && off_m[i] > 0.6 * std::max(off_m[i - 1], off_m[i + 1]) ? 1 : 0;
  return leaps;
}

/// A pose without a fix, or another unit, is a drive of a million kilometres, which would be looked
/// at in steps of 5 m.
void check_distance(const Trajectory& trajectory, const std::string& path) {
  double driven_m = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    if (trajectory.piece[i] != trajectory.piece[i - 1]) continue;
    const double step_m = trajectory.driven_m[i] - trajectory.driven_m[i - 1];
    if (step_m > kLongestStep_m)
      throw Error(
          fmt::format("{}: pose {}: {:.6g} m from the one before in {:.3g} s; metres are "
                      "wanted, and rows without a fix left out",
                      path, i + 1, step_m, trajectory.time_s[i] - trajectory.time_s[i - 1]));
    driven_m += step_m;
  }
  if (driven_m > kLongestDrive_m)
    throw Error(
        fmt::format("{}: {:.6g} km driven in all; {:.0f} km at most wanted: metres are "
                    "wanted, or a part of the drive",
                    path, 1e-3 * driven_m, 1e-3 * kLongestDrive_m));
}

}  // namespace

Trajectory read_trajectory(const std::string& path, const Eigen::Isometry3d& extrinsic) {
  const base::CsvTable table =
      base::read_csv(path, {"time_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"});
  if (table.rows() < 2)
    throw Error(fmt::format("{}: {} poses seen, two or more wanted", path, table.rows()));
  Trajectory trajectory;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const auto at = [&](std::size_t column) { return table.value(i, column); };
    for (std::size_t k = 0; k < 8; ++k)
      if (!(std::abs(at(k)) < 1e12))
        throw Error(fmt::format("{}:{}: {} is {}; wanted seconds and metres; leave the row out",
                                path, table.line[i], table.names[k], at(k)));
    const Eigen::Quaterniond q(at(7), at(4), at(5), at(6));
    if (std::abs(q.norm() - 1.0) > 0.01)
      throw Error(
          fmt::format("{}:{}: quaternion of length {:.4f} seen, 1 wanted; columns are qx,qy,qz,qw",
                      path, table.line[i], q.norm()));
    if (i > 0 && !(at(0) > trajectory.time_s.back()))
      throw Error(fmt::format("{}:{}: time {:.6f} s after {:.6f} s; times must ascend", path,
                              table.line[i], at(0), trajectory.time_s.back()));
    const Eigen::Vector3d p(at(1), at(2), at(3));
    trajectory.time_s.push_back(at(0));
    trajectory.position_m.push_back(p + q.normalized() * extrinsic.translation());
    trajectory.orientation.push_back(
        (q.normalized() * Eigen::Quaterniond(extrinsic.rotation())).normalized());
  }
  measure(trajectory);
  check_distance(trajectory, path);
  return trajectory;
}

void write_trajectory(const Trajectory& trajectory, const std::string& path) {
  std::string text = "time_s,x_m,y_m,z_m,qx,qy,qz,qw\n";
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const Eigen::Vector3d& p = trajectory.position_m[i];
    const Eigen::Quaterniond& q = trajectory.orientation[i];
    text += fmt::format("{:.6f},{:.6f},{:.6f},{:.6f},{:.12f},{:.12f},{:.12f},{:.12f}\n",
                        trajectory.time_s[i], p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
  }
  base::write_file(path, text);
}

void measure(Trajectory& trajectory) {
  trajectory.driven_m.assign(trajectory.size(), 0.0);
  trajectory.piece.assign(trajectory.size(), 0);
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < trajectory.size(); ++i) steps_s.push_back(step_s(trajectory, i));
  trajectory.longest_step_s =
      std::clamp(kTimesMedian * quantile(std::move(steps_s), 0.5), kLeastGap_s, kGap_s);
  const std::vector<std::uint8_t> leaps = leaps_in(trajectory);
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const bool gap = begins_drive(trajectory, i) || leaps[i] != 0;
    trajectory.piece[i] = trajectory.piece[i - 1] + (gap ? 1 : 0);
    trajectory.driven_m[i] =
        trajectory.driven_m[i - 1] +
        (gap ? 1000.0 : (trajectory.position_m[i] - trajectory.position_m[i - 1]).norm());
  }
}

bool begins_drive(const Trajectory& trajectory, std::size_t pose) {
  return pose == 0 || step_s(trajectory, pose) > kGap_s;
}

bool pose_at(const Trajectory& trajectory, double time_s, std::size_t& hint, PosedInstant& pose) {
  const std::vector<double>& t = trajectory.time_s;
  if (!(time_s >= t.front() && time_s <= t.back())) return false;
  const auto between = [&](std::size_t k) { return t[k] <= time_s && time_s < t[k + 1]; };
  std::size_t i = std::min(hint, t.size() - 2);
  if (!between(i)) {
    if (i + 2 < t.size() && between(i + 1))
      ++i;
    else
      i = static_cast<std::size_t>(
          std::clamp<std::ptrdiff_t>(std::upper_bound(t.begin(), t.end(), time_s) - t.begin() - 1,
                                     0, static_cast<std::ptrdiff_t>(t.size()) - 2));
  }
  // The last pose before a gap belongs to what lies before it.
  const std::vector<int>& piece = trajectory.piece;
  if (time_s == t[i] && i > 0 && piece[i] != piece[i + 1]) --i;
  hint = i;
  if (piece[i] != piece[i + 1]) return false;
  if (time_s > t[i] && t[i + 1] - t[i] > trajectory.longest_step_s) return false;
  const double f = (time_s - t[i]) / (t[i + 1] - t[i]);
  pose.position_m =
      trajectory.position_m[i] + f * (trajectory.position_m[i + 1] - trajectory.position_m[i]);
  const Eigen::Vector4d a = trajectory.orientation[i].coeffs();
  Eigen::Vector4d b = trajectory.orientation[i + 1].coeffs();
  if (a.dot(b) < 0.0) b = -b;
  pose.orientation.coeffs() = (a + f * (b - a)).normalized();
  pose.driven_m =
      trajectory.driven_m[i] + f * (trajectory.driven_m[i + 1] - trajectory.driven_m[i]);
  return true;
}

}  // namespace cloud
