#include "support/kerbed_road.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/random.h"

namespace support {
namespace {

constexpr double kRowStep_m = 0.25, kRange_m = 45.0, kWallHeight_m = 1.0;

double lift_m(double x_m) { return 0.05 * std::sin(0.11 * x_m); }

/// Without lift. `lower_m`: of the left kerb's outer edge.
double profile_m(double v_m, double lower_m) {
  const double out_m = std::abs(v_m), crown_m = -0.01 * std::min(out_m, KerbedRoad::kRoad_m);
  if (out_m <= KerbedRoad::kRoad_m) return crown_m;
  const double top_m = KerbedRoad::kKerb_m - (v_m > 0.0 ? lower_m : 0.0);
  if (out_m <= KerbedRoad::kKerbEnd_m) return crown_m + (out_m - KerbedRoad::kRoad_m) * top_m;
  return crown_m + std::max(KerbedRoad::kVerge_m, top_m - (out_m - KerbedRoad::kKerbEnd_m) * 0.5);
}

using Ground = std::function<double(double x_m, double v_m)>;

/// Range of the first crossing with the ground.
double range_m(const Ground& ground_m, const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
  const auto above = [&](double range) {
    const Eigen::Vector3d p = from + range * along;
    return p.z() - ground_m(p.x(), p.y());
  };
  double low = 0.0, high = 0.0;
  while (above(high) > 0.0) {
    low = high, high += std::max(0.02, 0.8 * above(high) / (0.07 - along.z()));
    if (high > kRange_m) return high;
  }
  for (int k = 0; k < 30; ++k) (above(0.5 * (low + high)) > 0.0 ? low : high) = 0.5 * (low + high);
  return high;
}

/// What a beam meets before the ground at `range`, with grass, walls and rain.
double met_m(const KerbedDrive& drive, const Ground& ground_m, const Eigen::Vector3d& from,
             const Eigen::Vector3d& along, double range, base::Random& random) {
  if (std::abs(from.y() + range * along.y()) > KerbedRoad::kKerbEnd_m && drive.grass_m > 0.0) {
    const double high_m =
        -0.5 * drive.grass_m * std::log((1.0 - random.uniform()) * (1.0 - random.uniform()));
    range -= std::min(high_m / -along.z(), 1.5);
  }
  if (drive.wall_m > 0.0 && along.y() != 0.0) {
    const double wall = (std::copysign(drive.wall_m, along.y()) - from.y()) / along.y();
    const Eigen::Vector3d p = from + wall * along;
    if (wall < range && p.z() < ground_m(p.x(), p.y()) + kWallHeight_m) range = wall;
  }
  if (drive.rain > 0.0 && random.uniform() < drive.rain)
    range = std::max(0.0, range - 2.0 * random.uniform() / -along.z());
  return range;
}

}  // namespace

double KerbedRoad::height_m(double x_m, double v_m) const {
  return lift_m(x_m) + profile_m(v_m, 0.0);
}

double KerbedRoad::base_height_m(double x_m, double v_m) const {
  const double from_end = std::min(x_m, length_m - x_m) / length_m;
  const double share = std::clamp((from_end - 0.25) / 0.1, 0.0, 1.0);
  return lift_m(x_m) + profile_m(v_m, kLowered_m) - share * tilt * v_m;
}

crg::Crg KerbedRoad::base() const {
  crg::ReferenceLine line;
  line.u_step_m = kRowStep_m;
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  for (int j = -80; j <= 80; ++j) grid.v_m.push_back(0.125 * j);
  for (int i = 0; i <= static_cast<int>(length_m / kRowStep_m); ++i) {
    const double x_m = kRowStep_m * i;
    line.x_m.push_back(x_m), line.y_m.push_back(0.0), line.heading_rad.push_back(0.0);
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
    const Ground ground_m = [&](double x_m, double at_v_m) {
      const double layer_m = drive.new_layer_m ? drive.new_layer_m(pass, x_m, at_v_m) : 0.0;
      return road.height_m(x_m, at_v_m) + layer_m;
    };
    for (double x_m = 5.0; x_m < road.length_m - 5.0; x_m += 0.1, time_s += 0.01) {
      const Eigen::Vector3d at(x_m, v_m, lift_m(x_m) + 1.2);
      const double phase = x_m / 23.0 + 2.0 * pass;
      out.trajectory.time_s.push_back(time_s);
      out.trajectory.position_m.push_back(
          at + 0.02 * Eigen::Vector3d(0.0, std::cos(phase), std::sin(phase)));
      out.trajectory.orientation.push_back(Eigen::Quaterniond(
          Eigen::AngleAxisd(0.001 * std::sin(0.7 * phase), Eigen::Vector3d::UnitX())));
      const int tick = static_cast<int>(std::lround(time_s / 0.01)) % 10;
      for (int a = tick * kAzimuths / 10; a < (tick + 1) * kAzimuths / 10; ++a)
        for (int beam = 0; beam < kBeams; ++beam) {
          const double azimuth = (a + random.uniform()) * 2.0 * M_PI / kAzimuths,
                       down = (25.0 - 23.0 * beam / (kBeams - 1)) * M_PI / 180.0;
          const Eigen::Vector3d along(std::cos(down) * std::cos(azimuth),
                                      std::cos(down) * std::sin(azimuth), -std::sin(down));
          double range = range_m(ground_m, at, along);
          if (range > kRange_m) continue;
          range = met_m(drive, ground_m, at, along, range, random) + 0.005 * random.normal();
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

KerbedError error_of(const KerbedRoad& road, const cloud::MapResult& result) {
  KerbedError out;
  out.converged = result.report.converged;
  std::vector<double> kerb_m;
  double square = 0.0, lost = 0.0, outer = 0.0, outer_nodes = 0.0, inside = 0.0;
  for (std::size_t i = 80; i + 80 < result.grid.rows(); ++i) {
    double vv = 0.0, ve = 0.0;
    for (std::size_t j = 0; j < result.grid.columns(); ++j) {
      const double v_m = result.grid.v_m[j];
      const double e = static_cast<double>(result.grid.at(i, j)) -
                       road.height_m(kRowStep_m * static_cast<double>(i), v_m);
      const float source = result.source.at(i, j);
      const bool measured = source == static_cast<float>(cloud::NodeSource::lidar) ||
                            source == static_cast<float>(cloud::NodeSource::interpolated);
      if (std::abs(v_m) < KerbedRoad::kKerbEnd_m - 0.1)
        inside += std::abs(e) < 1.645 * static_cast<double>(result.stddev.at(i, j)) ? 1.0 : 0.0;
      if (std::abs(v_m) <= KerbedRoad::kRoad_m) {
        square += e * e, ++out.road_nodes, lost += measured ? 0.0 : 1.0;
        out.road_max_m = std::max(out.road_max_m, std::abs(e));
        vv += v_m * v_m, ve += v_m * e;
        if (std::abs(v_m) > KerbedRoad::kRoad_m - 1.0) outer += e * e, outer_nodes += 1.0;
      } else if (std::abs(v_m) < KerbedRoad::kKerbEnd_m - 0.1) {
        kerb_m.push_back(std::abs(e));
      }
    }
    out.banking_rad = std::max(out.banking_rad, std::abs(ve / vv));
  }
  out.kerb_nodes = kerb_m.size();
  std::sort(kerb_m.begin(), kerb_m.end());
  out.kerb_p95_m = kerb_m[kerb_m.size() * 95 / 100];
  out.road_rmse_m = std::sqrt(square / static_cast<double>(out.road_nodes));
  out.outer_rmse_m = std::sqrt(outer / outer_nodes);
  out.lost = lost / static_cast<double>(out.road_nodes);
  out.inside = inside / static_cast<double>(out.road_nodes + out.kerb_nodes);
  return out;
}

}  // namespace support
