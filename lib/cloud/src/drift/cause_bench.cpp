#include "cause_bench.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/parallel.h"
#include "base/statistics.h"

namespace cloud {
namespace {

constexpr std::size_t kSamples = 20'000;
constexpr double kGroup_m = 10.0, kFar_m = 1.0, kFromSensor_m = 20.0;
constexpr double kFall_s = 0.02;
constexpr double kFarthest = std::numeric_limits<double>::infinity();

/// Rows of the poses on the road; below 0 where they lie beside it.
std::vector<double> rows_of(const Trajectory& poses, const RoadFrame& frame) {
  std::vector<double> rows(poses.size(), -1.0);
  double row = -1.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d& p = poses.position_m[i];
    std::optional<GridPlace> place;
    const auto beside = [&] {
      return !place || place->v_m < frame.v_m().front() - 3.0 ||
             place->v_m > frame.v_m().back() + 3.0;
    };
    if (row >= 0.0) place = frame.project(p.x(), p.y(), row);
    // The slow search not for every pose that lies elsewhere.
    if (beside() && i % 50 == 0)
      place = frame.project(p.x(), p.y(), frame.nearest_row(p.x(), p.y()));
    row = beside() ? -1.0 : place->row;
    rows[i] = row;
  }
  return rows;
}

/// A point over the base, as seen from the sensor.
struct Seen {
  double a, b, height;
};

/// Of the heights that were driven together, by a plane that what stands out does not pull.
Eigen::Vector3d plane_through(const std::vector<Seen>& seen) {
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  for (int round = 0; round < 4; ++round) {
    std::vector<double> off;
    off.reserve(seen.size());
    for (const Seen& s : seen)
      off.push_back(std::abs(s.height - plane.dot(Eigen::Vector3d(1.0, s.a, s.b))));
    const double scale = round == 0 ? kFarthest : 3.0 * std::max(0.002, base::median(off));
    Eigen::Matrix3d matrix = 1e-6 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Seen& s : seen) {
      const Eigen::Vector3d j(1.0, s.a, s.b);
      const double r = (s.height - plane.dot(j)) / scale, w = 1.0 / ((1.0 + r * r) * (1.0 + r * r));
      matrix += w * j * j.transpose(), right += w * s.height * j;
    }
    plane = matrix.ldlt().solve(right);
  }
  return plane;
}

/// Median distance of the points from the base; infinite where too few lie on it.
double distance_m(const std::vector<Sample>& samples, const RoadFrame& frame,
                  const Trajectory& poses, const std::vector<double>& rows, const Trial& trial) {
  std::map<long, std::vector<Seen>> groups;
  std::size_t hint = 0, near = 0;
  for (const Sample& sample : samples) {
    const Eigen::Vector3d local = trial.turn * (trial.points_times * sample.point_m);
    if (local.norm() > kFromSensor_m) continue;
    ++near;
    PosedInstant pose;
    if (!pose_at(poses, sample.time_s + trial.late_s, hint, pose) || rows[hint] < 0.0) continue;
    const Eigen::Vector3d arm = pose.orientation * (local + trial.shift_m),
                          p = pose.position_m + trial.poses_shift_m + arm;
    const std::optional<GridPlace> place = frame.project(p.x(), p.y(), rows[hint]);
    if (!place) continue;
    const double above = p.z() - frame.z_origin_m() - frame.height(*place);
    if (!std::isfinite(above)) continue;
    groups[std::lround(pose.driven_m / kGroup_m)].push_back(
        {arm.x(), arm.y(), std::clamp(above, -kFar_m, kFar_m)});
  }
  std::vector<double> distances;
  for (auto& [index, seen] : groups) {
    if (seen.size() < 20) continue;
    const Eigen::Vector3d plane =
        trial.with_planes ? plane_through(seen) : Eigen::Vector3d::Zero().eval();
    for (const Seen& s : seen)
      distances.push_back(std::abs(s.height - plane.dot(Eigen::Vector3d(1.0, s.a, s.b))));
  }
  if (near < 500 || 10 * distances.size() < 3 * near || 40 * near < samples.size())
    return kFarthest;
  return base::median(distances);
}

}  // namespace

namespace {

/// Of the points between two falls of the time: how steeply they were looked at.
struct Runs {
  double count = 0.0, sum = 0.0, square = 0.0;                 // of the run
  double runs = 0.0, within = 0.0, means = 0.0, means2 = 0.0;  // of those before it

  void add(double sine) { count += 1.0, sum += sine, square += sine * sine; }
  void end() {
    const double mean = sum / count;
    runs += 1.0, within += square / count - mean * mean, means += mean, means2 += mean * mean;
    count = sum = square = 0.0;
  }
  bool differ_more_than_inside() const { return means2 - means * means / runs > within; }
};

}  // namespace

Samples samples_of(const CloudSource& scans) {
  Samples out;
  std::vector<Sample>& samples = out.list;
  std::size_t every = 1, next = 0;
  double before_s = kFarthest;
  Runs runs;
  scans([&](Cloud&& chunk) {
    for (std::size_t i = 0; i < chunk.size() && !chunk.time_s.empty(); ++i) {
      const double time_s = chunk.time_s[i];
      const std::size_t at = out.points++;
      out.begin_s = std::min(out.begin_s, time_s), out.end_s = std::max(out.end_s, time_s);
      if (at > 0 && time_s < before_s - kFall_s) ++out.falls, runs.end();
      const Eigen::Vector3d ray_m = chunk.origin_m + chunk.point(i);
      runs.add(ray_m.z() / std::max(1e-6, ray_m.norm()));
      if (time_s != before_s) ++out.stamps;
      before_s = time_s;
      if (at != next) continue;
      next += every;
      samples.push_back({time_s, ray_m});
      if (samples.size() < 2 * kSamples) continue;
      for (std::size_t k = 0; 2 * k < samples.size(); ++k) samples[k] = samples[2 * k];
      samples.resize(samples.size() / 2), every *= 2;
    }
  });
  if (runs.count > 0.0) runs.end();
  out.by_rings = out.falls > 0 && runs.differ_more_than_inside();
  return out;
}

Bench::Bench(Samples samples, const RoadFrame& frame, const Trajectory& poses,
             const MapOptions& options)
    : samples_(std::move(samples)),
      frame_(frame),
      poses_(poses),
      rows_(rows_of(poses, frame)),
      options_(options) {}

std::vector<double> Bench::distances_of(const std::vector<Trial>& trials) const {
  std::vector<double> found(trials.size());
  constexpr std::size_t kAtOnce = 16, kLikely = 800;
  for (std::size_t begin = 0; begin < trials.size(); begin += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, trials.size() - begin);
    base::parallel_for(count, 1, options_.threads, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = begin + from; k < begin + to; ++k) found[k] = distance_of(trials[k]);
    });
    tried_ += count;
    if (options_.progress)
      options_.progress("look for what does not fit",
                        0.95 + 0.05 * std::min(1.0, static_cast<double>(tried_) / kLikely));
  }
  return found;
}

Tried Bench::best_of(const std::vector<Trial>& trials) const {
  const std::vector<double> found = distances_of(trials);
  const auto least = std::min_element(found.begin(), found.end());
  return {trials[static_cast<std::size_t>(least - found.begin())], *least};
}

double Bench::distance_of(const Trial& trial) const {
  if (trial.poses_times == 1.0 && trial.poses_otherwise == nullptr)
    return distance_m(samples_.list, frame_, poses_, rows_, trial);
  Trajectory poses = poses_;
  for (Eigen::Vector3d& p : poses.position_m) p *= trial.poses_times;
  if (trial.poses_otherwise != nullptr) trial.poses_otherwise(poses);
  measure(poses);
  return distance_m(samples_.list, frame_, poses, rows_of(poses, frame_), trial);
}

}  // namespace cloud
