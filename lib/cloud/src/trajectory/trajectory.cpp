#include "cloud/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/statistics.h"
#include "base/write_file.h"
#include "cloud/error.h"
#include "pose_table.h"

namespace cloud {
namespace {

constexpr double kLongestStep_m = 1000.0;  // within a second
constexpr double kLongestDrive_m = 2e6;    // memory grows with the distance driven
constexpr double kGap_s = 1.05;            // begins a new piece; clocks of one pose a second jitter
constexpr double kLeastGap_s = 0.15;       // a car that brakes is 5 mm beside a line through it
// No car changes its acceleration faster; places told in steps, and noise, are no leaps.
constexpr double kMostJerk_mps3 = 100.0, kLeastLeap_m = 0.05;
constexpr double kLongStep_s = 0.025;  // within less a line is as good as a bend
constexpr double kTimesMedian = 10.0, kTimesMost = 4.0;

double step_s(const Trajectory& trajectory, std::size_t i) {
  return trajectory.time_s[i] - trajectory.time_s[i - 1];
}

/// A share `f` of the way from a pose to the next, by a cubic whose slopes at both come from the
/// poses beside them; straight where there are none. (Hermite's form, slopes of parabolas.)
void bend_between(const Trajectory& trajectory, std::size_t i, double f, PosedInstant& pose) {
  const std::vector<double>& t = trajectory.time_s;
  const double step_s = t[i + 1] - t[i];
  const auto is_known = [&](std::size_t a, std::size_t b) {
    return b < trajectory.size() && trajectory.piece[a] == trajectory.piece[b] &&
           t[b] - t[a] <= trajectory.longest_step_s;
  };
  const bool before = i > 0 && is_known(i - 1, i), behind = is_known(i + 1, i + 2);
  // Weights of the four poses: those of both ends, and what their slopes add.
  Eigen::Vector4d weight(0.0, 1.0 - f, f, 0.0);
  const double g = 1.0 - f;
  const auto lean = [&](double times, std::size_t from, std::size_t to, Eigen::Index column) {
    // The slope at a pose is a mean of those of the steps at its sides, the shorter the heavier.
    const double other_s = t[to] - t[from], share = step_s / (step_s + other_s);
    weight[column + 1] += times * share * step_s / other_s;
    weight[column] -= times * share * step_s / other_s;
    weight[2] -= times * share, weight[1] += times * share;
  };
  if (before) lean(f * g * g, i - 1, i, 0);
  if (behind) lean(-f * f * g, i + 1, i + 2, 2);
  // By differences, so that what does not change stays as it is to the last bit.
  pose.position_m = trajectory.position_m[i];
  const Eigen::Vector4d near = trajectory.orientation[i].coeffs();
  Eigen::Vector4d turn = near;
  for (std::size_t k = 0; k < 4; ++k) {
    const double w = weight[static_cast<Eigen::Index>(k)];
    if (w == 0.0 || k == 1) continue;
    const Eigen::Vector4d q = trajectory.orientation[i + k - 1].coeffs();
    pose.position_m += w * (trajectory.position_m[i + k - 1] - trajectory.position_m[i]);
    turn += w * ((q.dot(near) < 0.0 ? -1.0 : 1.0) * q - near);
  }
  pose.orientation.coeffs() = turn.normalized();
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

/// Since 1970 there are 1.7e9 s.
void check_first_time(double time_s, const std::string& path, std::size_t line) {
  for (const auto& [least, unit, per_second] : {std::tuple{1e17, "nanoseconds", "1e9"},
                                                {1e14, "microseconds", "1e6"},
                                                {1e11, "milliseconds", "1000"}})
    if (std::abs(time_s) > least)
      throw Error(
          fmt::format("{}:{}: time_s is {:.6g}, as if in {} since 1970; seconds wanted: divide by "
                      "{}, and best subtract the first time of all from poses and points",
                      path, line, time_s, unit, per_second));
}

}  // namespace

Trajectory read_trajectory(const std::string& path, const Eigen::Isometry3d& extrinsic) {
  const base::CsvTable table = pose_table(path);
  if (table.rows() < 2)
    throw Error(fmt::format("{}: {} poses seen, two or more wanted", path, table.rows()));
  Trajectory trajectory;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const auto at = [&](std::size_t column) { return table.value(i, column); };
    if (i == 0) check_first_time(at(0), path, table.line[i]);
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

double unknown_between_m(const Trajectory& trajectory) {
  std::vector<double> off_m;
  const std::vector<Eigen::Vector3d>& p = trajectory.position_m;
  for (std::size_t i = 3; i + 3 < trajectory.size(); ++i) {
    double least_s = std::numeric_limits<double>::infinity(), most_s = 0.0;
    for (std::size_t k = i - 2; k <= i + 3; ++k)
      least_s = std::min(least_s, step_s(trajectory, k)),
      most_s = std::max(most_s, step_s(trajectory, k));
    if (trajectory.piece[i - 3] != trajectory.piece[i + 3] || most_s > 1.5 * least_s) continue;
    // What one pose in two leaves unknown: over steps half as long a line leaves a quarter of that,
    // a cubic a sixteenth.
    const Eigen::Vector3d line = 0.5 * (p[i - 1] + p[i + 1]),
                          cubic = line + 0.0625 * (p[i - 1] + p[i + 1] - p[i - 3] - p[i + 3]);
    off_m.push_back(most_s > kLongStep_s ? (p[i] - cubic).norm() / 16.0
                                         : (p[i] - line).norm() / 4.0);
  }
  return quantile(std::move(off_m), 0.95);
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
  if (t[i + 1] - t[i] > kLongStep_s) {
    bend_between(trajectory, i, f, pose);
  } else {
    pose.position_m =
        trajectory.position_m[i] + f * (trajectory.position_m[i + 1] - trajectory.position_m[i]);
    const Eigen::Vector4d a = trajectory.orientation[i].coeffs();
    Eigen::Vector4d b = trajectory.orientation[i + 1].coeffs();
    if (a.dot(b) < 0.0) b = -b;
    pose.orientation.coeffs() = (a + f * (b - a)).normalized();
  }
  pose.driven_m =
      trajectory.driven_m[i] + f * (trajectory.driven_m[i + 1] - trajectory.driven_m[i]);
  return true;
}

}  // namespace cloud
