#include "support/kerbed_road.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/random.h"

namespace support {
namespace {

constexpr double kRowStep_m = 0.25, kRange_m = 45.0, kWallHeight_m = 1.0, kStepEvery_m = 2.0;

double lift_m(double x_m) { return 0.05 * std::sin(0.11 * x_m); }

/// Without lift. `lower_m`, `step_m`: of the left kerb's outer edge, of both kerbs' edges.
double profile_m(double v_m, double fall, double lower_m, double step_m) {
  const double out_m = std::abs(v_m), crown_m = -fall * std::min(out_m, KerbedRoad::kRoad_m);
  if (out_m <= KerbedRoad::kRoad_m) return crown_m;
  const double top_m = KerbedRoad::kKerb_m + step_m - (v_m > 0.0 ? lower_m : 0.0);
  if (out_m <= KerbedRoad::kKerbEnd_m) return crown_m + (out_m - KerbedRoad::kRoad_m) * top_m;
  return crown_m + std::max(KerbedRoad::kVerge_m, top_m - (out_m - KerbedRoad::kKerbEnd_m) * 0.5);
}

using Ground = std::function<double(const RoadSpot& at)>;

/// Where the middle of the road lies that turns left with this radius; 0: it is straight.
Eigen::Vector3d middle_m(double radius_m, double u_m) {
  if (radius_m == 0.0) return {u_m, 0.0, 0.0};
  return {radius_m * std::sin(u_m / radius_m), radius_m * (1.0 - std::cos(u_m / radius_m)), 0.0};
}

double heading_rad(double radius_m, double u_m) { return radius_m == 0.0 ? 0.0 : u_m / radius_m; }

Eigen::Vector3d place_m(double radius_m, const RoadSpot& spot) {
  const double heading = heading_rad(radius_m, spot.u_m);
  return middle_m(radius_m, spot.u_m) +
         spot.v_m * Eigen::Vector3d(-std::sin(heading), std::cos(heading), 0.0);
}

RoadSpot spot_of(double radius_m, const Eigen::Vector3d& p) {
  if (radius_m == 0.0) return {p.x(), p.y()};
  const double ahead_m = p.x(), in_m = radius_m - p.y();
  return {radius_m * std::atan2(ahead_m, in_m), radius_m - std::hypot(ahead_m, in_m)};
}

/// A beam from the sensor.
struct Beam {
  Eigen::Vector3d from, along;
  double radius_m = 0.0;  ///< of the road

  Eigen::Vector3d at(double range) const { return from + range * along; }
  RoadSpot spot(double range) const { return spot_of(radius_m, at(range)); }
};

/// Range of the first crossing with the ground.
double range_m(const Ground& ground_m, const Beam& beam) {
  const auto above = [&](double range) { return beam.at(range).z() - ground_m(beam.spot(range)); };
  double low = 0.0, high = 0.0;
  while (above(high) > 0.0) {
    low = high, high += std::max(0.02, 0.8 * above(high) / (0.07 - beam.along.z()));
    if (high > kRange_m) return high;
  }
  for (int k = 0; k < 30; ++k) (above(0.5 * (low + high)) > 0.0 ? low : high) = 0.5 * (low + high);
  return high;
}

/// Range of a wall along the road; infinite: the beam passes it by.
double wall_range_m(const Beam& beam, double wall_v_m) {
  const double never = std::numeric_limits<double>::infinity();
  if (beam.radius_m == 0.0) {
    const double range = (wall_v_m - beam.from.y()) / beam.along.y();
    return range > 0.0 ? range : never;
  }
  const Eigen::Vector2d from = beam.from.head<2>() - Eigen::Vector2d(0.0, beam.radius_m),
                        along = beam.along.head<2>();
  const double round_m = beam.radius_m - wall_v_m, a = along.squaredNorm(), b = from.dot(along),
               root2 = b * b - a * (from.squaredNorm() - round_m * round_m);
  if (!(root2 > 0.0)) return never;
  const double near = (-b - std::sqrt(root2)) / a, far = (-b + std::sqrt(root2)) / a;
  return near > 0.0 ? near : far > 0.0 ? far : never;
}

/// Range of a car as long, wide and high as most, as a box along the road at `middle`.
double car_range_m(const Beam& beam, const RoadSpot& middle) {
  const double heading = heading_rad(beam.radius_m, middle.u_m), never = kRange_m + 1.0;
  const Eigen::Vector3d ahead(std::cos(heading), std::sin(heading), 0.0),
      left(-ahead.y(), ahead.x(), 0.0),
      from = beam.from - place_m(beam.radius_m, middle) -
             Eigen::Vector3d(0.0, 0.0, lift_m(middle.u_m));
  double near = 0.0, far = never;
  const auto between = [&](double at, double speed, double low, double high) {
    const double s = std::abs(speed) < 1e-9 ? 1e-9 : speed;
    near = std::max(near, std::min((low - at) / s, (high - at) / s));
    far = std::min(far, std::max((low - at) / s, (high - at) / s));
  };
  between(from.dot(ahead), beam.along.dot(ahead), -2.25, 2.25);
  between(from.dot(left), beam.along.dot(left), -0.95, 0.95);
  between(from.z(), beam.along.z(), 0.15, 1.4);
  return near < far ? near : never;
}

/// What a beam meets before the ground at `range`, with grass, walls, cars and rain.
double met_m(const KerbedDrive& drive, const Ground& ground_m, const Beam& beam, double range,
             const std::vector<RoadSpot>& cars, base::Random& random) {
  const double v_m = beam.spot(range).v_m;
  if (drive.paint_m > 0.0 && std::abs(std::abs(v_m) - 4.7) < 0.1) range -= drive.paint_m;
  if ((drive.left_only ? v_m : std::abs(v_m)) > KerbedRoad::kKerbEnd_m && drive.grass_m > 0.0) {
    const double high_m =
        -0.5 * drive.grass_m * std::log((1.0 - random.uniform()) * (1.0 - random.uniform()));
    range -= std::min(high_m / -beam.along.z(), 1.5);
  }
  if (drive.wall_m > 0.0)
    for (const double wall_v_m : {drive.wall_m, -drive.wall_m}) {
      if (drive.left_only && wall_v_m < 0.0) continue;
      const double wall = wall_range_m(beam, wall_v_m);
      if (wall < range && beam.at(wall).z() < ground_m(beam.spot(wall)) + kWallHeight_m)
        range = wall;
    }
  for (const RoadSpot& car : cars) range = std::min(range, car_range_m(beam, car));
  if (drive.rain > 0.0 && random.uniform() < drive.rain)
    range = std::max(0.0, range - 2.0 * random.uniform() / -beam.along.z());
  return range;
}

/// Those that follow, 8 m from one to the next, and one that comes towards the sensor.
std::vector<RoadSpot> cars_at(const KerbedDrive& drive, const RoadSpot& sensor, double time_s) {
  std::vector<RoadSpot> cars = drive.parked;
  for (int k = 0; k < drive.convoy; ++k)
    cars.push_back({sensor.u_m - 8.0 * (k + 1) - 0.5 * std::sin(0.9 * time_s + k), sensor.v_m});
  if (drive.oncoming)
    cars.push_back({80.0 - std::fmod(10.0 * time_s, 80.0) + 0.4 * sensor.u_m, -2.5});
  return cars;
}

}  // namespace

double KerbedRoad::height_m(double x_m, double v_m) const {
  const double on_m = std::fmod(std::max(0.0, x_m), 2.0 * kStepEvery_m),
               share = on_m < kStepEvery_m
                           ? std::min(1.0, on_m / kRowStep_m)
                           : 1.0 - std::min(1.0, (on_m - kStepEvery_m) / kRowStep_m);
  return lift_m(x_m) + profile_m(v_m, crown, 0.0, (share - 0.5) * step_m);
}

double KerbedRoad::base_height_m(double x_m, double v_m) const {
  const double from_end = std::min(x_m, length_m - x_m) / length_m;
  const double share = std::clamp((from_end - 0.25) / 0.1, 0.0, 1.0);
  return lift_m(x_m) + profile_m(v_m, kCrown, kLowered_m, 0.0) - share * tilt * v_m;
}

crg::Crg KerbedRoad::base() const {
  crg::ReferenceLine line;
  line.u_step_m = kRowStep_m;
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  for (int j = -80; j <= 80; ++j) grid.v_m.push_back(0.125 * j);
  for (int i = 0; i <= static_cast<int>(length_m / kRowStep_m); ++i) {
    const double x_m = kRowStep_m * i;
    const Eigen::Vector3d middle = middle_m(radius_m, x_m);
    line.x_m.push_back(middle.x()), line.y_m.push_back(middle.y());
    line.heading_rad.push_back(heading_rad(radius_m, x_m));
    for (const double v_m : grid.v_m)
      grid.z_m.push_back(static_cast<float>(base_height_m(x_m, v_m)));
  }
  return crg::make_crg(line, grid);
}

KerbedScans scans_of(const KerbedRoad& road, const KerbedDrive& drive) {
  KerbedScans out;
  base::Random random(drive.seed);
  constexpr int kBeams = 32, kAzimuths = 200;
  double time_s = 0.0;
  for (int pass = 0; pass < drive.passes; ++pass, time_s += 5.0) {
    const double v_m = pass == 0 ? -1.0 : 1.2;
    const Ground ground_m = [&](const RoadSpot& at) {
      const double layer_m = drive.new_layer_m ? drive.new_layer_m(pass, at.u_m, at.v_m) : 0.0;
      return road.height_m(at.u_m, at.v_m) + layer_m;
    };
    for (double u_m = 5.0; u_m < road.length_m - 5.0; u_m += 0.1, time_s += 0.01) {
      const double phase = u_m / 23.0 + 2.0 * pass;
      const Eigen::Quaterniond heading(
          Eigen::AngleAxisd(heading_rad(road.radius_m, u_m), Eigen::Vector3d::UnitZ()));
      const Eigen::Vector3d at =
          place_m(road.radius_m, {u_m, v_m}) + Eigen::Vector3d(0.0, 0.0, lift_m(u_m) + 1.2);
      const std::vector<RoadSpot> cars = cars_at(drive, {u_m, v_m}, time_s);
      out.trajectory.time_s.push_back(time_s);
      out.trajectory.position_m.push_back(
          at +
          heading * (drive.drift * 0.02 * Eigen::Vector3d(0.0, std::cos(phase), std::sin(phase))));
      out.trajectory.orientation.push_back(
          heading * Eigen::Quaterniond(Eigen::AngleAxisd(
                        drive.drift * 0.001 * std::sin(0.7 * phase), Eigen::Vector3d::UnitX())));
      const int tick = static_cast<int>(std::lround(time_s / 0.01)) % 10;
      for (int a = tick * kAzimuths / 10; a < (tick + 1) * kAzimuths / 10; ++a)
        for (int row = 0; row < kBeams; ++row) {
          const double azimuth = (a + random.uniform()) * 2.0 * M_PI / kAzimuths,
                       down = (25.0 - 23.0 * row / (kBeams - 1)) * M_PI / 180.0;
          const Eigen::Vector3d along(std::cos(down) * std::cos(azimuth),
                                      std::cos(down) * std::sin(azimuth), -std::sin(down));
          const Beam beam{at, heading * along, road.radius_m};
          double range = range_m(ground_m, beam);
          if (range > kRange_m) continue;
          range = met_m(drive, ground_m, beam, range, cars, random) + 0.005 * random.normal();
          if (range < 2.0) continue;
          const Eigen::Vector3d p = range * along;
          out.points.x_m.push_back(p.x()), out.points.y_m.push_back(p.y()),
              out.points.z_m.push_back(p.z()), out.points.time_s.push_back(time_s);
        }
    }
  }
  measure(out.trajectory);
  return out;
}

namespace {

/// Across the nodes of a row that rest on the base, of what was added to it, beyond the steepest
/// that it lacks there: from one measured node to the other, or two nodes on where none is beyond.
double ramp_over_correction(const KerbedRoad& road, const crg::Grid& refined, const crg::Grid& base,
                            const crg::Grid& source, std::size_t row) {
  const std::size_t columns = refined.columns();
  const double u_m = kRowStep_m * static_cast<double>(row);
  const auto slope = [&](std::size_t j, const auto& height_m) {
    return std::abs(height_m(j + 1) - height_m(j)) / (refined.v_m[j + 1] - refined.v_m[j]);
  };
  const auto lacks_m = [&](std::size_t j) {
    return road.height_m(u_m, refined.v_m[j]) - road.base_height_m(u_m, refined.v_m[j]);
  };
  const auto added_m = [&](std::size_t j) {
    return static_cast<double>(refined.at(row, j) - base.at(row, j));
  };
  const auto measured = [&](std::size_t j) { return is_measured(source.at(row, j)); };
  double most = 0.0;
  for (std::size_t j = 0; j + 1 < columns; ++j) {
    if (measured(j) && measured(j + 1)) continue;
    std::size_t from = j, to = j + 1;
    while (from > 0 && !measured(from)) --from;
    while (to + 1 < columns && !measured(to)) ++to;
    if (!measured(from)) from = to - std::min<std::size_t>(to, 2);
    if (!measured(to)) to = std::min(from + 2, columns - 1);
    double steepest = 0.0;
    for (std::size_t k = from; k < to; ++k) steepest = std::max(steepest, slope(k, lacks_m));
    most = std::max(most, slope(j, added_m) - steepest);
  }
  return most;
}

}  // namespace

void Tally::add(double error_m, double stddev_m) {
  ++nodes, square_m2 += error_m * error_m, stated_m2 += stddev_m * stddev_m;
  inside += std::abs(error_m) < 1.645 * stddev_m ? 1.0 : 0.0;
}

void Tally::add(const Tally& other) {
  nodes += other.nodes, square_m2 += other.square_m2, stated_m2 += other.stated_m2;
  inside += other.inside;
}

double Tally::rmse_m() const { return nodes > 0.0 ? std::sqrt(square_m2 / nodes) : 0.0; }
double Tally::stated_m() const { return nodes > 0.0 ? std::sqrt(stated_m2 / nodes) : 0.0; }
double Tally::share() const { return nodes > 0.0 ? inside / nodes : 1.0; }

void KerbedTallies::add(const KerbedTallies& other) {
  road.add(other.road), outer.add(other.outer), kerbs.add(other.kerbs);
  verge.add(other.verge), unmeasured.add(other.unmeasured);
}

cloud::Cloud placed(const KerbedScans& scans) {
  cloud::Cloud out;
  cloud::PosedInstant pose;
  std::size_t hint = 0;
  for (std::size_t k = 0; k < scans.points.size(); ++k) {
    if (!cloud::pose_at(scans.trajectory, scans.points.time_s[k], hint, pose)) continue;
    const Eigen::Vector3d p = pose.position_m + pose.orientation * scans.points.point(k);
    out.x_m.push_back(p.x()), out.y_m.push_back(p.y()), out.z_m.push_back(p.z());
  }
  return out;
}

bool is_measured(float source) {
  return source == static_cast<float>(cloud::NodeSource::lidar) ||
         source == static_cast<float>(cloud::NodeSource::interpolated);
}

KerbedError error_of(const KerbedRoad& road, const cloud::MapResult& result) {
  KerbedError out;
  out.converged = result.report.converged;
  const crg::Grid base = road.base().grid;
  std::vector<double> kerb_m, measured_kerb_m;
  double lost = 0.0;
  Tally asphalt, kerbs, outer, unmeasured;
  for (std::size_t i = 80; i + 80 < result.grid.rows(); ++i) {
    double vv = 0.0, ve = 0.0;
    for (std::size_t j = 0; j < result.grid.columns(); ++j) {
      const double v_m = result.grid.v_m[j];
      const double e = static_cast<double>(result.grid.at(i, j)) -
                       road.height_m(kRowStep_m * static_cast<double>(i), v_m);
      const auto stddev_m = static_cast<double>(result.stddev.at(i, j));
      const bool measured = is_measured(result.source.at(i, j));
      if (!measured) unmeasured.add(e, stddev_m);
      if (std::abs(v_m) <= KerbedRoad::kRoad_m) {
        asphalt.add(e, stddev_m), lost += measured ? 0.0 : 1.0;
        out.road_max_m = std::max(out.road_max_m, std::abs(e));
        vv += v_m * v_m, ve += v_m * e;
        if (std::abs(v_m) > KerbedRoad::kRoad_m - 1.0) outer.add(e, stddev_m);
      } else if (std::abs(v_m) < KerbedRoad::kKerbEnd_m - 0.1) {
        kerb_m.push_back(std::abs(e)), kerbs.add(e, stddev_m);
        if (measured) out.tallies.kerbs.add(e, stddev_m), measured_kerb_m.push_back(std::abs(e));
      } else if (measured && std::abs(v_m) > KerbedRoad::kKerbEnd_m + 0.3) {
        out.tallies.verge.add(e, stddev_m);
      }
    }
    out.banking_rad = std::max(out.banking_rad, std::abs(ve / vv));
    out.ramp_over_correction = std::max(
        out.ramp_over_correction, ramp_over_correction(road, result.grid, base, result.source, i));
  }
  std::sort(kerb_m.begin(), kerb_m.end());
  out.kerb_p95_m = kerb_m[kerb_m.size() * 95 / 100];
  std::sort(measured_kerb_m.begin(), measured_kerb_m.end());
  if (!measured_kerb_m.empty())
    out.measured_kerb_p95_m = measured_kerb_m[measured_kerb_m.size() * 95 / 100];
  out.road_nodes = static_cast<std::size_t>(asphalt.nodes), out.kerb_nodes = kerb_m.size();
  out.unmeasured_nodes = static_cast<std::size_t>(unmeasured.nodes);
  out.road_rmse_m = asphalt.rmse_m(), out.kerb_rmse_m = kerbs.rmse_m();
  out.outer_rmse_m = outer.rmse_m(), out.unmeasured_rmse_m = unmeasured.rmse_m();
  out.outer_inside = outer.share(), out.unmeasured_inside = unmeasured.share();
  out.lost = lost / asphalt.nodes;
  out.tallies.road = asphalt, out.tallies.outer = outer, out.tallies.unmeasured = unmeasured;
  out.inside = (asphalt.inside + kerbs.inside) / (asphalt.nodes + kerbs.nodes);
  return out;
}

}  // namespace support
