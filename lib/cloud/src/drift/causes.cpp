#include "causes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "base/parallel.h"
#include "base/statistics.h"

namespace cloud {
namespace {

constexpr std::size_t kSamples = 20'000;
constexpr double kGroup_m = 10.0, kFar_m = 1.0, kFromSensor_m = 20.0;
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

/// A point over the base, as seen from the sensor.
struct Seen {
  double a, b, height;
};

/// Of the heights that were driven together, by a plane that what stands out does not pull.
Eigen::Vector3d plane_through(const std::vector<Seen>& seen) {
  Eigen::Vector3d plane = Eigen::Vector3d::Zero();
  for (int round = 0; round < 4; ++round) {
    std::vector<double> off;
    for (const Seen& s : seen)
      off.push_back(std::abs(s.height - plane.dot(Eigen::Vector3d(1.0, s.a, s.b))));
    const double scale = round == 0 ? kInfinity : 3.0 * std::max(0.002, base::median(off));
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
    if (seen.size() < 20) continue;
    const Eigen::Vector3d plane =
        trial.with_planes ? plane_through(seen) : Eigen::Vector3d::Zero().eval();
    for (const Seen& s : seen)
      distances.push_back(std::abs(s.height - plane.dot(Eigen::Vector3d(1.0, s.a, s.b))));
  }
  if (near < 500 || 10 * distances.size() < 3 * near || 40 * near < samples.size())
    return kInfinity;
  return base::median(distances);
}

/// A trial and what it gave.
struct Tried {
  Trial trial;
  double distance_m = kInfinity;
};

/// What trials are made on.
class Bench {
 public:
  Bench(std::vector<Sample> samples, const RoadFrame& frame, const Trajectory& poses,
        unsigned threads)
      : samples_(std::move(samples)),
        frame_(frame),
        poses_(poses),
        rows_(rows_of(poses, frame)),
        threads_(threads) {}

  const std::vector<Sample>& samples() const { return samples_; }
  const Trajectory& poses() const { return poses_; }

  std::vector<double> distances_of(const std::vector<Trial>& trials) const {
    std::vector<double> found(trials.size());
    base::parallel_for(trials.size(), 1, threads_, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k < to; ++k) found[k] = distance_of(trials[k]);
    });
    return found;
  }

  /// The first of those that bring the points closest.
  Tried best_of(const std::vector<Trial>& trials) const {
    const std::vector<double> found = distances_of(trials);
    const auto least = std::min_element(found.begin(), found.end());
    return {trials[static_cast<std::size_t>(least - found.begin())], *least};
  }

 private:
  double distance_of(const Trial& trial) const {
    if (trial.poses_times == 1.0) return distance_m(samples_, frame_, poses_, rows_, trial);
    Trajectory poses = poses_;
    for (Eigen::Vector3d& p : poses.position_m) p *= trial.poses_times;
    measure(poses);
    return distance_m(samples_, frame_, poses, rows_of(poses, frame_), trial);
  }

  std::vector<Sample> samples_;
  const RoadFrame& frame_;
  const Trajectory& poses_;
  std::vector<double> rows_;
  unsigned threads_;
};

constexpr double kDegree = std::numbers::pi / 180.0;

Trial turned(double deg, int axis, bool with_planes) {
  Trial trial;
  trial.turn = Eigen::AngleAxisd(deg * kDegree, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
  trial.with_planes = with_planes;
  return trial;
}

double yaw_deg(const Trial& trial) {
  return std::atan2(trial.turn(1, 0), trial.turn(0, 0)) / kDegree;
}

/// What may be wrong, in words, and the trial that mends it.
struct Cause {
  Tried tried;
  std::string text;
};

/// All round by 15 degrees, then by one about the best.
Cause try_yaw(const Bench& bench) {
  std::vector<Trial> trials;
  for (int deg = -165; deg <= 180; deg += 15)
    if (deg != 0) trials.push_back(turned(deg, 2, true));
  const Trial coarse = bench.best_of(trials).trial;
  trials = {coarse};
  for (int deg = -8; deg <= 8; ++deg)
    if (std::abs(yaw_deg(coarse) + deg) > 0.5)
      trials.push_back(turned(yaw_deg(coarse) + deg, 2, true));
  const Tried best = bench.best_of(trials);
  return {best,
          fmt::format("the sensor turned by {:.0f} deg in yaw (--extrinsic)", yaw_deg(best.trial))};
}

/// By 5 degrees and by quarter turns. A plane would take the turn for a slope.
Cause try_tilt(const Bench& bench, int axis, const char* name) {
  const std::vector<double> degrees{-90.0, -20.0, -15.0, -10.0, -5.0, 5.0,
                                    10.0,  15.0,  20.0,  90.0,  180.0};
  std::vector<Trial> trials;
  for (const double deg : degrees) trials.push_back(turned(deg, axis, false));
  const std::vector<double> all = bench.distances_of(trials);
  const auto least =
      static_cast<std::size_t>(std::min_element(all.begin(), all.end()) - all.begin());
  return {{trials[least], all[least]},
          fmt::format("the sensor turned by {:.0f} deg in {} (--extrinsic)", degrees[least], name)};
}

/// 5 s to both sides of `middle_s`, then by 5 ms about the best.
Cause try_clock(const Bench& bench, double middle_s) {
  const auto later = [](double seconds) {
    Trial trial;
    trial.late_s = seconds;
    return trial;
  };
  std::vector<Trial> trials;
  for (int k = -100; k <= 100; ++k) trials.push_back(later(middle_s + 0.05 * k));
  const Trial coarse = bench.best_of(trials).trial;
  trials = {coarse};
  for (int k = -9; k <= 9; ++k) trials.push_back(later(coarse.late_s + 0.005 * k));
  const Tried best = bench.best_of(trials);
  return {best, fmt::format("{:+.3f} s on the times of the points, or {:+.3f} s on time_s of the "
                            "trajectory",
                            best.trial.late_s, -best.trial.late_s)};
}

/// What makes points and trajectory begin together, where a tenth of the points lies outside its
/// time.
std::optional<double> equal_beginnings_s(const Bench& bench) {
  const std::vector<double>& times = bench.poses().time_s;
  double begin_s = kInfinity, outside = 0.0;
  for (const Sample& sample : bench.samples()) {
    begin_s = std::min(begin_s, sample.time_s);
    outside += sample.time_s < times.front() || sample.time_s > times.back();
  }
  if (!(outside > 0.1 * static_cast<double>(bench.samples().size()))) return std::nullopt;
  return times.front() - begin_s;
}

Cause try_place(const Bench& bench, int axis, const char* name) {
  std::vector<Trial> trials;
  for (const double m : {-1.0, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1.0}) {
    trials.emplace_back();
    trials.back().shift_m = m * Eigen::Vector3d::Unit(axis);
    trials.back().with_planes = axis < 2;
  }
  const Tried best = bench.best_of(trials);
  return {best,
          fmt::format("the sensor {:+.2f} m {} (--extrinsic)", best.trial.shift_m[axis], name)};
}

/// Points, and poses, in another unit than is said.
std::vector<Cause> try_units(const Bench& bench) {
  std::vector<Cause> causes;
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
    const std::vector<double> both = bench.distances_of({points, poses});
    causes.push_back(
        {{points, both[0]}, fmt::format("points in {} instead of {} (--cloud-unit)", is, was)});
    causes.push_back({{poses, both[1]}, fmt::format("poses in {} instead of {}", is, was)});
  }
  return causes;
}

std::vector<Cause> try_all(const Bench& bench) {
  std::vector<Cause> causes{try_yaw(bench), try_tilt(bench, 0, "roll"), try_tilt(bench, 1, "pitch"),
                            try_clock(bench, 0.0)};
  if (const std::optional<double> late_s = equal_beginnings_s(bench))
    causes.push_back(try_clock(bench, *late_s));
  for (const auto& [axis, name] : {std::pair{0, "ahead"}, {1, "to the left"}, {2, "up"}})
    causes.push_back(try_place(bench, axis, name));
  for (Cause& cause : try_units(bench)) causes.push_back(std::move(cause));
  return causes;
}

/// Distances without any change, with planes and without: what trials are compared with.
struct AsIs {
  double with_planes = kInfinity, straight = kInfinity;
  double of(const Trial& trial) const { return trial.with_planes ? with_planes : straight; }
};

AsIs as_it_is(const Bench& bench) {
  Trial straight;
  straight.with_planes = false;
  const std::vector<double> found = bench.distances_of({Trial{}, straight});
  return {found[0], found[1]};
}

/// Those that bring the points much closer, the best first.
std::vector<Cause> much_better(std::vector<Cause> causes, const AsIs& as_is) {
  std::erase_if(causes, [&](const Cause& cause) {
    const double found = cause.tried.distance_m;
    return !(std::isfinite(found) && found < kBetter * as_is.of(cause.tried.trial) && found < 0.25);
  });
  const auto share = [&](const Cause& cause) {
    const double before = as_is.of(cause.tried.trial);
    return std::isfinite(before) ? cause.tried.distance_m / before : 0.0;
  };
  std::stable_sort(causes.begin(), causes.end(),
                   [&](const Cause& a, const Cause& b) { return share(a) < share(b); });
  return causes;
}

}  // namespace

std::string likely_causes(const CloudSource& scans, const RoadFrame& frame,
                          const Trajectory& trajectory, const MapOptions& options) {
  std::vector<Sample> samples = samples_of(scans);
  if (samples.size() < 1000) return {};
  const Bench bench(std::move(samples), frame, trajectory, options.threads);
  const AsIs as_is = as_it_is(bench);
  const std::vector<Cause> causes = much_better(try_all(bench), as_is);
  std::string text = fmt::format(
      "tried with {} points: the sensor turned in yaw, roll and pitch, its place by 1 m, the clock "
      "by 5 s, units",
      bench.samples().size());
  if (causes.empty())
    return text +
           "; nothing of it fits better: look at the frame of the poses, the height datum, "
           "and whether base and scans show the same place";
  text += "; better, the best first:";
  for (std::size_t k = 0; k < std::min<std::size_t>(3, causes.size()); ++k) {
    const double before = as_is.of(causes[k].tried.trial);
    text +=
        fmt::format("{} {} ({:.0f} mm from the base{})", k == 0 ? "" : ";", causes[k].text,
                    1e3 * causes[k].tried.distance_m,
                    std::isfinite(before) ? fmt::format(" instead of {:.0f}", 1e3 * before) : "");
  }
  return text;
}

}  // namespace cloud
