#include "cloud/synth.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <numbers>

#include "base/parallel.h"
#include "base/random.h"
#include "base/write_file.h"
#include "cloud/error.h"
#include "cloud/road_frame.h"
#include "scenery.h"

namespace cloud {
namespace {

constexpr double kPoseStep_s = 0.01;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr double kCarLength_m = 4.5, kCarWidth_m = 1.9, kCarHeight_m = 1.25, kCarClearance_m = 0.15;

/// Random functions of distance: slopes averaged over `smooth_m`, scaled to the wanted change over
/// 100 m.
std::vector<double> drift(std::size_t steps, double smooth_m, double per_100m,
                          base::Random& random) {
  const auto half = static_cast<std::size_t>(std::max(1.0, smooth_m / 2.0));
  std::vector<double> noise(steps + 2 * half + 1), value(steps + 1, 0.0);
  for (double& v : noise) v = random.normal();
  const double start = per_100m * random.normal();
  for (std::size_t i = 0; i < steps; ++i) {
    double slope = 0.0;  // a raised cosine over the window: smooth, without memory beyond it
    for (std::size_t k = 0; k <= 2 * half; ++k)
      slope += noise[i + k] * (1.0 - std::cos(2.0 * std::numbers::pi * static_cast<double>(k) /
                                              static_cast<double>(2 * half)));
    value[i + 1] = value[i] + slope;
  }
  // Variance of the change over 100 m, from the kernel itself.
  double variance = 0.0;
  const int n = 100, m = static_cast<int>(2 * half);
  for (int at = -m; at < n; ++at) {
    double weight = 0.0;
    for (int k = std::max(0, -at); k <= std::min(m, n - 1 - at); ++k)
      weight += 1.0 - std::cos(2.0 * std::numbers::pi * k / m);
    variance += weight * weight;
  }
  for (double& v : value) v = start + v * per_100m / std::sqrt(variance);
  return value;
}

struct Drive {
  Trajectory truth, drifted;
  std::vector<double> row, v_m;        ///< of each pose
  std::vector<std::vector<Box>> cars;  ///< others, in front and behind
  Scenery scenery;
};

Eigen::Quaterniond attitude(const RoadFrame& frame, const GridPlace& place) {
  Eigen::Vector2d g = frame.gradient(place, 1.0);
  if (!g.allFinite()) g.setZero();
  const Eigen::Vector3d up = Eigen::Vector3d(-g.x(), -g.y(), 1.0).normalized();
  const double heading = frame.heading_rad(place.row);
  const Eigen::Vector3d ahead =
      Eigen::Vector3d(std::cos(heading), std::sin(heading),
                      g.x() * std::cos(heading) + g.y() * std::sin(heading))
          .normalized();
  Eigen::Matrix3d axes;
  axes << ahead, up.cross(ahead), up;
  return Eigen::Quaterniond(axes).normalized();
}

Drive drive(const RoadFrame& frame, const ScanSynthOptions& options) {
  Drive drive;
  const double step_rows = options.speed_mps * kPoseStep_s / frame.u_step_m();
  const double begin = (options.u_begin_m - frame.u_begin_m()) / frame.u_step_m();
  const double end = options.u_end_m > 0.0
                         ? (options.u_end_m - frame.u_begin_m()) / frame.u_step_m()
                         : static_cast<double>(frame.rows() - 1);
  if (!(begin >= 0.0 && end <= static_cast<double>(frame.rows() - 1) && end - begin > 10.0))
    throw Error(fmt::format("u from {} to {} m seen; a part of the road of {:.1f} m wanted",
                            options.u_begin_m, options.u_end_m, frame.length_m()));
  double time = 0.0;
  for (int lap = 0; lap < options.laps; ++lap) {
    const double v = options.v_m[static_cast<std::size_t>(lap) % options.v_m.size()];
    base::Random random(options.seed * 1000 + static_cast<std::uint64_t>(lap));
    const auto poses = static_cast<std::size_t>((end - begin) / step_rows) + 1;
    const double length = (end - begin) * frame.u_step_m();
    std::array<std::vector<double>, 6> drifts;
    for (std::size_t k = 0; k < 6; ++k)
      drifts[k] = drift(static_cast<std::size_t>(length) + 3, options.drift_smooth_m,
                        k < 3 ? options.drift_m_per_100m : options.drift_rad_per_100m, random);
    for (std::size_t i = 0; i < poses; ++i, time += kPoseStep_s) {
      const double row = std::min(begin + step_rows * static_cast<double>(i),
                                  static_cast<double>(frame.rows() - 1) - 1e-6);
      const GridPlace place{row, v};
      const auto k = static_cast<std::size_t>(row);
      const double f = row - static_cast<double>(k);
      const Eigen::Vector2d xy =
          (1.0 - f) * frame.node_position(k, v) + f * frame.node_position(k + 1, v);
      const double z = frame.height(place);
      if (!std::isfinite(z))
        throw Error(fmt::format("no road at u = {:.1f} m, v = {} m, where the car drives",
                                frame.u_begin_m() + row * frame.u_step_m(), v));
      const Eigen::Quaterniond q = attitude(frame, place);
      const Eigen::Vector3d p = Eigen::Vector3d(xy.x(), xy.y(), z + frame.z_origin_m()) +
                                q * Eigen::Vector3d(0, 0, options.sensor_height_m);
      const double driven = (row - begin) * frame.u_step_m();
      const auto at = [&](std::size_t n) {
        const auto m = static_cast<std::size_t>(driven);
        return drifts[n][m] + (driven - static_cast<double>(m)) * (drifts[n][m + 1] - drifts[n][m]);
      };
      drive.truth.time_s.push_back(time), drive.drifted.time_s.push_back(time);
      drive.truth.position_m.push_back(p), drive.truth.orientation.push_back(q);
      drive.drifted.position_m.push_back(p + Eigen::Vector3d(at(0), at(1), at(2)));
      const Eigen::Vector3d turn(at(3), at(4), at(5));  // roll, pitch, yaw
      drive.drifted.orientation.push_back(
          (q * Eigen::Quaterniond(Eigen::AngleAxisd(
                   turn.norm(), turn.norm() > 0 ? turn.normalized() : Eigen::Vector3d::UnitX())))
              .normalized());
      drive.row.push_back(row), drive.v_m.push_back(v);
      std::vector<Box> others;
      for (int c = 0; c < options.cars; ++c) {
        const double gap = 10.0 + 4.0 * std::sin(0.35 * time + 2.1 * c);
        const double other_row = frame.wrapped(
            row + (c % 2 == 0 ? 1.0 : -1.0) *
                      (gap + 2.0 * kCarLength_m * static_cast<double>(c / 2)) / frame.u_step_m());
        const GridPlace where{other_row, -v + 0.5 * std::sin(0.5 * time + c)};
        const auto r = static_cast<std::size_t>(
            std::clamp(other_row, 0.0, static_cast<double>(frame.rows() - 1)));
        const double ground = frame.height(where);
        if (!std::isfinite(ground)) continue;
        const Eigen::Vector2d spot = frame.node_position(r, where.v_m);
        const double heading = frame.heading_rad(other_row);
        others.push_back(
            {Eigen::Vector3d(spot.x(), spot.y(),
                             ground + frame.z_origin_m() + kCarClearance_m + 0.5 * kCarHeight_m),
             {std::cos(heading), std::sin(heading)},
             {0.5 * kCarLength_m, 0.5 * kCarWidth_m, 0.5 * kCarHeight_m}});
      }
      drive.cars.push_back(std::move(others));
    }
    time += 5.0;  // the car stops between laps; a piece of its own in the trajectory
  }
  measure(drive.truth), measure(drive.drifted);
  drive.scenery = scenery_along(frame, options.scenery_every_m, options.grass_from_m, options.seed);
  return drive;
}

/// Range of the first crossing of the ray with the road; NaN without one.
double range_to_road(const RoadFrame& frame, const Eigen::Vector3d& from,
                     const Eigen::Vector3d& along, double range_max_m, double& row_hint,
                     GridPlace& hit) {
  const auto above = [&](double range) {
    const Eigen::Vector3d p = from + range * along;
    const std::optional<GridPlace> place = frame.project(p.x(), p.y(), row_hint);
    if (!place) return kNaN;
    hit = *place;
    return p.z() - frame.z_origin_m() - frame.height(*place);
  };
  // Over a plane through the first guess; steps shrink with the height that is left.
  double range = 0.0, before = 0.0;
  double height = above(0.0);
  if (!std::isfinite(height)) return kNaN;
  const double descent = -along.z();
  for (int step = 0; step < 60; ++step) {
    before = range;
    const double last = height;
    // The road beyond may rise by 12 % (kerbs: the last step is short).
    range += std::max(0.05, last / (descent + 0.12));
    if (range > range_max_m) return kNaN;
    height = above(range);
    if (!std::isfinite(height)) return kNaN;
    if (height > 0.0) continue;
    double low = before, high = range, h_low = last, h_high = height;
    for (int k = 0; k < 4; ++k) {
      const double middle = low + (high - low) * h_low / (h_low - h_high), h = above(middle);
      if (!std::isfinite(h)) return kNaN;
      if (h > 0.0)
        low = middle, h_low = h;
      else
        high = middle, h_high = h;
      if (std::abs(h) < 2e-5) return middle;
    }
    return low + (high - low) * h_low / (h_low - h_high);
  }
  return kNaN;
}

template <typename T>
void put(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

struct Shots {
  std::string bytes;
  std::size_t points = 0, on_cars = 0, on_scenery = 0;
};

/// All shots of one pose interval.
Shots shoot(const RoadFrame& frame, const Drive& drive, std::size_t i,
            const ScanSynthOptions& options) {
  Shots shots;
  const double shots_per_s = options.turns_per_s * options.azimuths;
  const double t0 = drive.truth.time_s[i], t1 = drive.truth.time_s[i + 1];
  if (t1 - t0 > 0.5) return shots;
  base::Random random(options.seed * 0x9E3779B97F4A7C15ULL + i);
  const Scenery scenery =
      near_of(drive.scenery, drive.truth.position_m[i], options.range_max_m + 1.0);
  const auto first = static_cast<std::int64_t>(std::ceil(t0 * shots_per_s)),
             last = static_cast<std::int64_t>(std::ceil(t1 * shots_per_s));
  for (std::int64_t shot = first; shot < last; ++shot) {
    const double time = static_cast<double>(shot) / shots_per_s;
    PosedInstant pose;
    std::size_t hint = i;
    if (!pose_at(drive.truth, time, hint, pose)) continue;
    const double azimuth =
        2.0 * std::numbers::pi * static_cast<double>(shot % options.azimuths) / options.azimuths;
    for (int beam = 0; beam < options.beams; ++beam) {
      const double elevation =
          (-25.0 + 22.5 * beam / std::max(1, options.beams - 1)) * std::numbers::pi / 180.0;
      const Eigen::Vector3d in_sensor(std::cos(elevation) * std::cos(azimuth),
                                      std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const Eigen::Vector3d along = pose.orientation * in_sensor;
      if (along.z() > -0.02) continue;
      double row = drive.row[i];
      GridPlace hit;
      double range = range_to_road(frame, pose.position_m, along, options.range_max_m, row, hit);
      double car = std::numeric_limits<double>::infinity();
      for (const Box& other : drive.cars[i])
        car = std::min(car, distance_to(other, pose.position_m, along));
      const double beside = distance_to(scenery, pose.position_m, along, random);
      const double thing = std::min(car, beside);
      const bool on_thing = thing < options.range_max_m && !(thing >= range);
      const bool on_car = on_thing && car <= beside;
      if (on_thing) {
        range = thing;
      } else if (std::isfinite(range)) {
        if (options.beam_divergence_rad > 0.0) {  // mean over a footprint of five samples along it
          const double reach = range * options.beam_divergence_rad / 2.0 / -along.z();
          const Eigen::Vector3d p = pose.position_m + range * along;
          const Eigen::Vector2d flat = along.head<2>().normalized();
          double sum = 0.0;
          for (const double share : {-0.6, 0.6}) {
            const std::optional<GridPlace> place = frame.project(
                p.x() + share * reach * flat.x(), p.y() + share * reach * flat.y(), hit.row);
            const double slope = frame.gradient(hit, 0.2).dot(flat);
            const double z = place ? frame.height(*place) + frame.z_origin_m() : kNaN;
            if (std::isfinite(z) && std::isfinite(slope)) sum += z - p.z() - slope * share * reach;
          }
          range -= sum / 3.0 / -along.z();
        }
        if (options.grass_height_m > 0.0 && std::abs(hit.v_m) > options.grass_from_m)
          range -= options.grass_height_m * random.uniform() / -along.z();
      } else {
        continue;
      }
      range += options.range_noise_m * random.normal();
      const Eigen::Vector3d p = range * in_sensor;
      put(shots.bytes, static_cast<float>(p.x())), put(shots.bytes, static_cast<float>(p.y())),
          put(shots.bytes, static_cast<float>(p.z()));
      put(shots.bytes, time);
      ++shots.points;
      shots.on_cars += on_car ? 1 : 0, shots.on_scenery += on_thing && !on_car ? 1 : 0;
    }
  }
  return shots;
}

}  // namespace

ScanSynthReport synth_scans(const crg::Crg& road, const std::string& output_dir,
                            const ScanSynthOptions& options) {
  if (options.laps < 1 || options.v_m.empty() || !(options.speed_mps > 0.1) || options.beams < 1 ||
      options.azimuths < 1)
    throw Error(
        "laps, lateral places, beams and azimuths must be one or more, the speed above 0.1 m/s");
  if (options.scenery_every_m != 0.0 && !(options.scenery_every_m >= 1.0))
    throw Error(
        fmt::format("scenery every {} m seen; 1 m or more wanted, or 0 for a road without scenery",
                    options.scenery_every_m));
  const RoadFrame frame(road);
  const Drive driven = drive(frame, options);
  std::error_code problem;
  std::filesystem::create_directories(output_dir, problem);
  if (problem)
    throw Error(fmt::format("{}: cannot make this folder: {}", output_dir, problem.message()));
  const std::filesystem::path dir(output_dir);
  ScanSynthReport report;
  report.trajectory_path = (dir / "trajectory.csv").string();
  report.truth_path = (dir / "truth_trajectory.csv").string();
  write_trajectory(driven.drifted, report.trajectory_path);
  write_trajectory(driven.truth, report.truth_path);
  std::string bytes;
  std::size_t points = 0, on_cars = 0, on_scenery = 0;
  const auto flush = [&] {
    if (points == 0) return;
    const std::string path =
        (dir / fmt::format("scan_{:03}.ply", report.scan_paths.size())).string();
    base::FileWriter file(path);
    file.append(
        fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float "
                    "x\nproperty float y\nproperty float z\nproperty double time\nend_header\n",
                    points));
    file.append(bytes);
    file.commit();
    report.scan_paths.push_back(path);
    report.points += points;
    bytes.clear(), points = 0;
  };
  const std::size_t poses = driven.truth.size() - 1;
  constexpr std::size_t kBatch = 64;
  for (std::size_t begin = 0; begin < poses; begin += kBatch) {
    if (options.progress)
      options.progress("scans", static_cast<double>(begin) / static_cast<double>(poses));
    std::vector<Shots> batch(std::min(kBatch, poses - begin));
    base::parallel_for(batch.size(), 1, options.threads, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k < to; ++k) batch[k] = shoot(frame, driven, begin + k, options);
    });
    for (const Shots& shots : batch) {
      bytes += shots.bytes, points += shots.points, on_cars += shots.on_cars;
      on_scenery += shots.on_scenery;
      if (points >= options.points_per_file) flush();
    }
  }
  flush();
  if (report.points == 0)
    throw Error("no shot met the road; is the road narrower than the car's place?");
  report.share_on_cars = static_cast<double>(on_cars) / static_cast<double>(report.points);
  report.share_on_scenery = static_cast<double>(on_scenery) / static_cast<double>(report.points);
  return report;
}

}  // namespace cloud
