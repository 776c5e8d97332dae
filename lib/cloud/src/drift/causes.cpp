#include "causes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "cause_bench.h"

namespace cloud {
namespace {

constexpr double kBetter =
    0.6;  // of the distance as it is; trials: 0.02 to 0.5 for the right cause
// Where nothing can be compared; the right cause: 2 and 58 mm in trials.
constexpr double kCloseWithPlanes_m = 0.012, kClose_m = 0.15;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
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
  trials.reserve(degrees.size());
  for (const double deg : degrees) trials.push_back(turned(deg, axis, false));
  const std::vector<double> all = bench.distances_of(trials);
  const auto least =
      static_cast<std::size_t>(std::min_element(all.begin(), all.end()) - all.begin());
  return {{trials[least], all[least]},
          fmt::format("the sensor turned by {:.0f} deg in {} (--extrinsic)", degrees[least], name)};
}

/// So many times 50 ms to both sides of `middle_s`, then by 5 ms about the best.
Cause try_clock(const Bench& bench, double middle_s, int reach = 100) {
  const auto later = [](double seconds) {
    Trial trial;
    trial.late_s = seconds;
    return trial;
  };
  std::vector<Trial> trials;
  for (int k = -reach; k <= reach; ++k) trials.push_back(later(middle_s + 0.05 * k));
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
  const std::vector<Sample>& samples = bench.samples().list;
  double outside = 0.0;
  for (const Sample& sample : samples)
    outside += sample.time_s < times.front() || sample.time_s > times.back();
  if (!(outside > 0.1 * static_cast<double>(samples.size()))) return std::nullopt;
  return times.front() - bench.samples().begin_s;
}

/// From a place on the road to the same in other laps.
std::vector<double> laps_s(const Bench& bench) {
  constexpr double kLeastLap_s = 6.0;  // what is nearer is tried as a clock
  constexpr std::size_t kMostLaps = 4;
  const std::vector<double>& rows = bench.rows();
  const Trajectory& poses = bench.poses();
  const auto first = std::find_if(rows.begin(), rows.end(), [](double row) { return row >= 0.0; });
  std::vector<double> out;
  if (first == rows.end()) return out;
  const auto begin = static_cast<std::size_t>(first - rows.begin());
  double last_s = poses.time_s[begin];
  for (std::size_t i = begin + 1; i < rows.size() && out.size() < kMostLaps; ++i) {
    if (rows[i] < 0.0 || poses.time_s[i] - last_s < kLeastLap_s) continue;
    const bool passes =
        (rows[i - 1] <= *first) != (rows[i] <= *first) && std::abs(rows[i] - rows[i - 1]) < 100.0;
    const bool begins = poses.piece[i] != poses.piece[i - 1] && std::abs(rows[i] - *first) < 100.0;
    if (!passes && !begins) continue;
    last_s = poses.time_s[i];
    out.push_back(last_s - poses.time_s[begin]);
  }
  return out;
}

/// Poses that lie with the points of another lap.
std::vector<Cause> try_laps(const Bench& bench) {
  std::vector<Cause> causes;
  for (const double lap_s : laps_s(bench))
    for (const double late_s : {lap_s, -lap_s}) {
      Cause cause = try_clock(bench, late_s, 20);
      cause.text = fmt::format("points and poses are of different laps: {}", cause.text);
      causes.push_back(std::move(cause));
    }
  return causes;
}

/// Points on the other side of the sensor, as in a frame of the other hand.
std::vector<Cause> try_mirrors(const Bench& bench) {
  std::vector<Cause> causes;
  for (const auto& [axis, name] : {std::pair{0, 'x'}, {1, 'y'}, {2, 'z'}}) {
    Trial trial;
    trial.turn(axis, axis) = -1.0, trial.with_planes = axis < 2;
    causes.push_back({bench.best_of({trial}),
                      fmt::format("the points with {} the other way (the sensor's frame has x "
                                  "ahead, y to the left, z up)",
                                  name)});
  }
  Trial exchanged;
  exchanged.turn << 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  causes.push_back({bench.best_of({exchanged}), "the points with x and y exchanged"});
  return causes;
}

void invert(Trajectory& poses) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses.orientation[i] = poses.orientation[i].conjugate();
    poses.position_m[i] = -(poses.orientation[i] * poses.position_m[i]);
  }
}

void turn_back(Trajectory& poses) {
  for (Eigen::Quaterniond& q : poses.orientation) q = q.conjugate();
}

void begin_with_w(Trajectory& poses) {
  for (Eigen::Quaterniond& q : poses.orientation)
    q = Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w());
}

void exchange_places(Trajectory& poses) {
  for (Eigen::Vector3d& p : poses.position_m) std::swap(p.x(), p.y());
}

/// Yaw to the left of east, pitch, roll from what was written for them.
template <typename Of>
void from_angles(Trajectory& poses, const Of& of) {
  for (Eigen::Quaterniond& q : poses.orientation) {
    const Eigen::Matrix3d R = q.toRotationMatrix();
    const Eigen::Vector3d angles =
        of(Eigen::Vector3d(std::atan2(R(1, 0), R(0, 0)), std::asin(std::clamp(-R(2, 0), -1.0, 1.0)),
                           std::atan2(R(2, 1), R(2, 2))));
    q = Eigen::AngleAxisd(angles[0], Eigen::Vector3d::UnitZ()) *
        Eigen::AngleAxisd(angles[1], Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(angles[2], Eigen::Vector3d::UnitX());
  }
}

void from_clockwise(Trajectory& poses) {
  from_angles(poses, [](const Eigen::Vector3d& a) { return Eigen::Vector3d(-a[0], a[1], a[2]); });
}

void from_north(Trajectory& poses) {
  from_angles(poses, [](const Eigen::Vector3d& a) {
    return Eigen::Vector3d(0.5 * std::numbers::pi - a[0], a[1], a[2]);
  });
}

void exchange_tilts(Trajectory& poses) {
  from_angles(poses, [](const Eigen::Vector3d& a) { return Eigen::Vector3d(a[0], a[2], a[1]); });
}

/// Into another frame of the map. A mirrored one has sensors that look the same way as before.
template <int kX, int kY, int kZ>
void from_axes(Trajectory& poses) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
  int row = 0;
  for (const int axis : {kX, kY, kZ}) turn(row++, std::abs(axis) - 1) = axis > 0 ? 1.0 : -1.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses.position_m[i] = turn * poses.position_m[i];
    Eigen::Matrix3d axes = turn * poses.orientation[i].toRotationMatrix();
    if (axes.determinant() < 0.0) axes.col(1) *= -1.0;
    poses.orientation[i] = Eigen::Quaterniond(axes);
  }
}

/// Of the car: ahead, right, down.
void from_north_east_down(Trajectory& poses) {
  from_axes<2, 1, -3>(poses);
  for (Eigen::Quaterniond& q : poses.orientation) q = q * Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0);
}

/// Poses that were written in another way.
std::vector<Cause> try_poses(const Bench& bench) {
  const char* const down = "the poses are north, east, down: east, north, up are wanted";
  const std::pair<void (*)(Trajectory&), const char*> ways[] = {
      {invert, "the poses are the map in the sensor's frame: their inverses are wanted"},
      {turn_back, "the orientations are the map's in the sensor's frame: inverses are wanted"},
      {begin_with_w, "the quaternions begin with w: name their columns qw,qx,qy,qz"},
      {from_clockwise, "the headings count to the right: to the left is wanted"},
      {from_north, "the headings count from north to the right: from east to the left is wanted"},
      {exchange_tilts, "roll and pitch of the poses are exchanged"},
      {exchange_places, "x and y of the positions are exchanged, and not those of the attitudes"},
      {from_axes<2, 1, -3>, down},
      {from_north_east_down, down},
      {from_axes<2, -1, 3>, "the frame of the poses is turned by 90 deg"},
      {from_axes<-2, 1, 3>, "the frame of the poses is turned by -90 deg"},
      {from_axes<-1, -2, 3>, "the frame of the poses is turned by 180 deg"},
      {from_axes<-1, 2, 3>, "the frame of the poses has x the other way"},
      {from_axes<1, -2, 3>, "the frame of the poses has y the other way"},
      {from_axes<2, 1, 3>, "the frame of the poses has x and y exchanged"}};
  std::vector<Cause> causes;
  for (const auto& [otherwise, text] : ways) {
    Trial trial;
    trial.poses_otherwise = otherwise, trial.with_planes = false;
    causes.push_back({bench.best_of({trial}), text});
  }
  return causes;
}

/// A frame of the poses that lies beside the base's, in steps of 0.5 m.
Cause try_frame(const Bench& bench) {
  std::vector<Trial> trials;
  for (int x = -4; x <= 4; ++x)
    for (int y = -4; y <= 4; ++y) {
      if (x == 0 && y == 0) continue;
      trials.emplace_back();
      trials.back().poses_shift_m = 0.5 * Eigen::Vector3d(x, y, 0.0);
    }
  const Tried best = bench.best_of(trials);
  return {best, fmt::format("the frame of the poses moved by {:+.1f} {:+.1f} m in x y",
                            best.trial.poses_shift_m.x(), best.trial.poses_shift_m.y())};
}

Cause try_place(const Bench& bench, int axis, const char* name) {
  std::vector<Trial> trials;
  for (const double m : {-1.0, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1.0}) {
    trials.emplace_back();
    trials.back().shift_m = m * Eigen::Vector3d::Unit(axis);
    trials.back().with_planes = axis < 2;
  }
  const Tried best = bench.best_of(trials);
  return {best, fmt::format("the sensor {:+.2f} m {} (--extrinsic{})", best.trial.shift_m[axis],
                            name, axis == 2 ? ", or the height datum" : "")};
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
                            try_clock(bench, 0.0), try_frame(bench)};
  if (const std::optional<double> late_s = equal_beginnings_s(bench))
    causes.push_back(try_clock(bench, *late_s));
  for (std::vector<Cause>& found :
       std::array{try_laps(bench), try_mirrors(bench), try_poses(bench)})
    for (Cause& cause : found) causes.push_back(std::move(cause));
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
    const double before = as_is.of(cause.tried.trial);
    const double most = std::isfinite(before)           ? std::min(0.25, kBetter * before)
                        : cause.tried.trial.with_planes ? kCloseWithPlanes_m
                                                        : kClose_m;
    return !(found < most);
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

void want_one_clock(const CloudSource& scans, const Sections& sections,
                    const Trajectory& trajectory) {
  if (sections.time_end_s - sections.time_begin_s > kSweep_s ||
      trajectory.time_s.back() - trajectory.time_s.front() < 3.0 * kSweep_s)
    return;
  if (const std::string text = about_sweeps(samples_of(scans)); !text.empty()) throw Error(text);
}

std::string likely_causes(const CloudSource& scans, const RoadFrame& frame,
                          const Trajectory& trajectory, const MapOptions& options,
                          const Trajectory* found) {
  Samples samples = samples_of(scans);
  if (samples.list.size() < 1000) return {};
  if (std::string text = about_times(samples, trajectory); !text.empty()) return text;
  const AsIs as_is =
      as_it_is(Bench(samples, frame, found != nullptr ? *found : trajectory, options));
  const Bench bench(std::move(samples), frame, trajectory, options);
  const std::vector<Cause> causes = much_better(try_all(bench), as_is);
  if (causes.empty() && found != nullptr) return {};
  std::string text = fmt::format(
      "tried with {} points: the sensor turned in yaw, roll and pitch or mirrored, its place by "
      "1 m, the frame by 2 m, the clock by 5 s, other laps, units, other ways to write poses",
      bench.samples().list.size());
  if (causes.empty()) {
    const std::string few = about_distance(trajectory);
    return text + few + (few.empty() ? "; nothing of it fits better:" : "; if that is not all,") +
           " look at the frame of the poses, the height datum, and whether base and scans show the "
           "same place";
  }
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
