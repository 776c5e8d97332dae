#include "causes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "base/parallel.h"
#include "base/statistics.h"

namespace cloud {
namespace {

constexpr std::size_t kSamples = 20'000;
constexpr double kGroup_m = 10.0, kFar_m = 1.0, kReach_m = 20.0;
constexpr double kBetter =
    0.6;  // of the distance as it is; trials: 0.02 to 0.5 for the right cause
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Sample {
  double time_s;
  Eigen::Vector3d point_m;
};

/// One change of the inputs.
struct Trial {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  ///< of the sensor
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();   ///< of the sensor on the car
  double late_s = 0.0;                                 ///< added to the points' times
  double points_times = 1.0, poses_times = 1.0;
  bool with_planes = true;
};

/// Every so many points that no more than twice kSamples are left.
std::vector<Sample> samples_of(const CloudSource& scans) {
  std::vector<Sample> samples;
  std::size_t every = 1, next = 0, at = 0;
  scans([&](Cloud&& chunk) {
    for (std::size_t i = 0; i < chunk.size() && !chunk.time_s.empty(); ++i, ++at) {
      if (at != next) continue;
      next += every;
      samples.push_back({chunk.time_s[i], chunk.origin_m + chunk.point(i)});
      if (samples.size() < 2 * kSamples) continue;
      for (std::size_t k = 0; 2 * k < samples.size(); ++k) samples[k] = samples[2 * k];
      samples.resize(samples.size() / 2), every *= 2;
    }
  });
  return samples;
}

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

/// Median distance of the points from the base; infinite where too few lie on it.
double distance_m(const std::vector<Sample>& samples, const RoadFrame& frame,
                  const Trajectory& poses, const std::vector<double>& rows, const Trial& trial) {
  struct Seen {
    double a, b, height;
  };
  std::map<long, std::vector<Seen>> groups;
  std::size_t hint = 0, near = 0;
  for (const Sample& sample : samples) {
    const Eigen::Vector3d local = trial.turn * (trial.points_times * sample.point_m);
    if (local.norm() > kReach_m) continue;
    ++near;
    PosedInstant pose;
    if (!pose_at(poses, sample.time_s + trial.late_s, hint, pose) || rows[hint] < 0.0) continue;
    const Eigen::Vector3d arm = pose.orientation * (local + trial.shift_m),
                          p = pose.position_m + arm;
    const std::optional<GridPlace> place = frame.project(p.x(), p.y(), rows[hint]);
    if (!place) continue;
    const double above = p.z() - frame.z_origin_m() - frame.height(*place);
    if (!std::isfinite(above)) continue;
    groups[std::lround(pose.driven_m / kGroup_m)].push_back(
        {arm.x(), arm.y(), std::clamp(above, -kFar_m, kFar_m)});
  }
  std::vector<double> distances;
  for (auto& [index, seen] : groups) {
    Eigen::Vector3d plane = Eigen::Vector3d::Zero();
    if (seen.size() < 20) continue;
    for (int round = 0; round < 4 && trial.with_planes; ++round) {
      std::vector<double> off;
      for (const Seen& s : seen)
        off.push_back(std::abs(s.height - plane.dot(Eigen::Vector3d(1.0, s.a, s.b))));
      const double scale = round == 0 ? kInfinity : 3.0 * std::max(0.002, base::median(off));
      Eigen::Matrix3d matrix = 1e-6 * Eigen::Matrix3d::Identity();
      Eigen::Vector3d right = Eigen::Vector3d::Zero();
      for (const Seen& s : seen) {
        const Eigen::Vector3d j(1.0, s.a, s.b);
        const double r = (s.height - plane.dot(j)) / scale,
                     w = 1.0 / ((1.0 + r * r) * (1.0 + r * r));
        matrix += w * j * j.transpose(), right += w * s.height * j;
      }
      plane = matrix.ldlt().solve(right);
    }
    for (const Seen& s : seen)
      distances.push_back(std::abs(s.height - plane.dot(Eigen::Vector3d(1.0, s.a, s.b))));
  }
  if (near < 500 || 10 * distances.size() < 3 * near || 40 * near < samples.size())
    return kInfinity;
  return base::median(distances);
}

}  // namespace

std::string likely_causes(const CloudSource& scans, const RoadFrame& frame,
                          const Trajectory& trajectory, const MapOptions& options) {
  const std::vector<Sample> samples = samples_of(scans);
  if (samples.size() < 1000) return {};
  const std::vector<double> rows = rows_of(trajectory, frame);
  const auto measure_all = [&](const std::vector<Trial>& trials) {
    std::vector<double> found(trials.size());
    base::parallel_for(trials.size(), 1, options.threads, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k < to; ++k) {
        if (trials[k].poses_times == 1.0) {
          found[k] = distance_m(samples, frame, trajectory, rows, trials[k]);
          continue;
        }
        Trajectory poses = trajectory;
        for (Eigen::Vector3d& p : poses.position_m) p *= trials[k].poses_times;
        measure(poses);
        found[k] = distance_m(samples, frame, poses, rows_of(poses, frame), trials[k]);
      }
    });
    return found;
  };
  /// The best of trials, and its distance.
  const auto best_of = [&](const std::vector<Trial>& trials, double& best) {
    const std::vector<double> found = measure_all(trials);
    const auto least = std::min_element(found.begin(), found.end());
    best = *least;
    return trials[static_cast<std::size_t>(least - found.begin())];
  };
  Trial straight;
  straight.with_planes = false;
  const std::vector<double> as_is = measure_all({Trial{}, straight});
  struct Cause {
    double share, distance_m;
    bool with_planes;
    std::string text;
  };
  std::vector<Cause> causes;
  const auto consider = [&](const Trial& trial, double found, std::string text) {
    const double before = as_is[trial.with_planes ? 0 : 1];
    if (std::isfinite(found) && found < kBetter * before && found < 0.25)
      causes.push_back({std::isfinite(before) ? found / before : 0.0, found, trial.with_planes,
                        std::move(text)});
  };
  double found = 0.0;
  constexpr double kDegree = std::numbers::pi / 180.0;
  const auto turned = [&](double deg, int axis, bool with_planes) {
    Trial trial;
    trial.turn = Eigen::AngleAxisd(deg * kDegree, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
    trial.with_planes = with_planes;
    return trial;
  };
  const auto yaw_of = [&](const Trial& t) {
    return std::atan2(t.turn(1, 0), t.turn(0, 0)) / kDegree;
  };
  std::vector<Trial> trials;
  for (int deg = -165; deg <= 180; deg += 15)
    if (deg != 0) trials.push_back(turned(deg, 2, true));
  Trial best = best_of(trials, found);
  trials = {best};
  for (int deg = -8; deg <= 8; ++deg)
    if (std::abs(yaw_of(best) + deg) > 0.5) trials.push_back(turned(yaw_of(best) + deg, 2, true));
  best = best_of(trials, found);
  consider(best, found,
           fmt::format("the sensor turned by {:.0f} deg in yaw (--extrinsic)", yaw_of(best)));
  for (const auto& [axis, name] : {std::pair{0, "roll"}, {1, "pitch"}}) {
    std::vector<double> degrees;
    for (const double deg : {-90.0, -20.0, -15.0, -10.0, -5.0, 5.0, 10.0, 15.0, 20.0, 90.0, 180.0})
      degrees.push_back(deg);
    trials.clear();
    for (const double deg : degrees) trials.push_back(turned(deg, axis, false));
    const std::vector<double> all = measure_all(trials);
    const auto least =
        static_cast<std::size_t>(std::min_element(all.begin(), all.end()) - all.begin());
    consider(
        trials[least], all[least],
        fmt::format("the sensor turned by {:.0f} deg in {} (--extrinsic)", degrees[least], name));
  }
  const auto clock_around = [&](double begin_s) {
    trials.clear();
    for (int k = -100; k <= 100; ++k) {
      trials.emplace_back();
      trials.back().late_s = begin_s + 0.05 * k;
    }
    Trial clock = best_of(trials, found);
    const double middle = clock.late_s;
    trials = {clock};
    for (int k = -9; k <= 9; ++k) {
      trials.emplace_back();
      trials.back().late_s = middle + 0.005 * k;
    }
    clock = best_of(trials, found);
    consider(clock, found,
             fmt::format("{:+.3f} s on the times of the points, or {:+.3f} s on time_s of the "
                         "trajectory",
                         clock.late_s, -clock.late_s));
  };
  clock_around(0.0);
  double begin_s = kInfinity, outside = 0.0;
  for (const Sample& sample : samples) {
    begin_s = std::min(begin_s, sample.time_s);
    outside +=
        sample.time_s < trajectory.time_s.front() || sample.time_s > trajectory.time_s.back();
  }
  if (outside > 0.1 * static_cast<double>(samples.size()))
    clock_around(trajectory.time_s.front() - begin_s);
  for (const auto& [axis, name] : {std::pair{0, "ahead"}, {1, "to the left"}, {2, "up"}}) {
    trials.clear();
    for (const double m : {-1.0, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1.0}) {
      trials.emplace_back();
      trials.back().shift_m = m * Eigen::Vector3d::Unit(axis);
      trials.back().with_planes = axis < 2;
    }
    best = best_of(trials, found);
    consider(best, found,
             fmt::format("the sensor {:+.2f} m {} (--extrinsic)", best.shift_m[axis], name));
  }
  for (const auto& [factor, was, is] : {std::tuple{0.3048, "m", "ft"},
                                        {1.0 / 0.3048, "ft", "m"},
                                        {0.01, "m", "cm"},
                                        {100.0, "cm", "m"},
                                        {0.001, "m", "mm"},
                                        {1000.0, "mm", "m"},
                                        {0.9144, "m", "yard"},
                                        {1.0 / 0.9144, "yard", "m"}}) {
    Trial points, poses;
    points.points_times = poses.poses_times = factor;
    points.with_planes = poses.with_planes = false;
    const std::vector<double> both = measure_all({points, poses});
    consider(points, both[0], fmt::format("points in {} instead of {} (--cloud-unit)", is, was));
    consider(poses, both[1], fmt::format("poses in {} instead of {}", is, was));
  }
  std::stable_sort(causes.begin(), causes.end(),
                   [](const Cause& a, const Cause& b) { return a.share < b.share; });
  std::string text = fmt::format(
      "tried with {} points: the sensor turned in yaw, roll and pitch, its place by 1 m, the clock "
      "by 5 s, units",
      samples.size());
  if (causes.empty())
    return text +
           "; nothing of it fits better: look at the frame of the poses, the height datum, "
           "and whether base and scans show the same place";
  text += "; better, the best first:";
  for (std::size_t k = 0; k < std::min<std::size_t>(3, causes.size()); ++k) {
    const double before = as_is[causes[k].with_planes ? 0 : 1];
    text +=
        fmt::format("{} {} ({:.0f} mm from the base{})", k == 0 ? "" : ";", causes[k].text,
                    1e3 * causes[k].distance_m,
                    std::isfinite(before) ? fmt::format(" instead of {:.0f}", 1e3 * before) : "");
  }
  return text;
}

}  // namespace cloud
