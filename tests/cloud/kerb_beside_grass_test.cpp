// Kerbs with grass from where they end: scans of a road made here, by nothing of the library's.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/random.h"
#include "cloud/map.h"

namespace cloud {
namespace kerb_beside_grass_test {

// Across a straight road: asphalt, 1 m of kerb, and a verge on which grass stands.
constexpr double kRoad_m = 5.0, kKerbEnd_m = 6.0, kKerb_m = 0.055, kVerge_m = 0.03;
constexpr double kLength_m = 110.0, kLowered_m = 0.025;

double lift_m(double x_m) { return 0.05 * std::sin(0.11 * x_m); }

/// Without lift. `lower_m`: of the left kerb's outer edge.
double profile_m(double v_m, double lower_m) {
  const double out_m = std::abs(v_m), crown_m = -0.01 * std::min(out_m, kRoad_m);
  if (out_m <= kRoad_m) return crown_m;
  const double top_m = kKerb_m - (v_m > 0.0 ? lower_m : 0.0);
  if (out_m <= kKerbEnd_m) return crown_m + (out_m - kRoad_m) * top_m;
  return crown_m + std::max(kVerge_m, top_m - (out_m - kKerbEnd_m) * 0.5);
}

crg::Crg base_road() {
  crg::ReferenceLine line;
  line.u_step_m = 0.25;
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  for (int j = -80; j <= 80; ++j) grid.v_m.push_back(0.125 * j);
  for (int i = 0; i <= static_cast<int>(kLength_m / 0.25); ++i) {
    line.x_m.push_back(0.25 * i), line.y_m.push_back(0.0), line.heading_rad.push_back(0.0);
    for (const double v_m : grid.v_m)
      grid.z_m.push_back(static_cast<float>(lift_m(0.25 * i) + profile_m(v_m, kLowered_m)));
  }
  return crg::make_crg(line, grid);
}

struct Drive {
  Trajectory trajectory;  ///< that drifts
  Cloud points;           ///< in the sensor's frame
};

/// Range of the first crossing with the ground.
double range_m(const Eigen::Vector3d& from, const Eigen::Vector3d& along) {
  const auto above = [&](double range) {
    const Eigen::Vector3d p = from + range * along;
    return p.z() - lift_m(p.x()) - profile_m(p.y(), 0.0);
  };
  double low = 0.0, high = 0.0;
  while (above(high) > 0.0) {
    low = high, high += std::max(0.02, 0.8 * above(high) / (0.07 - along.z()));
    if (high > 45.0) return high;
  }
  for (int k = 0; k < 30; ++k) (above(0.5 * (low + high)) > 0.0 ? low : high) = 0.5 * (low + high);
  return high;
}

/// Blades stand `grass_m` high on average (gamma distribution of shape 2) and are met before the
/// ground, up to 1.5 m along the ray.
Drive drive(int passes, double grass_m, std::uint64_t seed) {
  Drive out;
  base::Random random(seed);
  constexpr int kBeams = 32, kAzimuths = 200;
  double time_s = 0.0;
  for (int pass = 0; pass < passes; ++pass, time_s += 5.0) {
    const double v_m = pass == 0 ? -1.0 : 1.2;
    for (double x_m = 5.0; x_m < kLength_m - 5.0; x_m += 0.1, time_s += 0.01) {
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
          double range = range_m(at, along);
          if (range > 45.0) continue;
          if (std::abs(at.y() + range * along.y()) > kKerbEnd_m && grass_m > 0.0) {
            const double high_m =
                -0.5 * grass_m * std::log((1.0 - random.uniform()) * (1.0 - random.uniform()));
            range -= std::min(high_m / -along.z(), 1.5);
          }
          range += 0.005 * random.normal();
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

struct Judged {
  bool converged = false;
  double road_rmse_m = 0.0, banking_rad = 0.0, kerb_p95_m = 0.0, lost = 0.0;
  std::size_t road_nodes = 0, kerb_nodes = 0;
};

/// Of the middle of the road; `lost`: share of its nodes that rest on the base.
Judged judge(const crg::Crg& base, const MapResult& result) {
  Judged out;
  out.converged = result.report.converged;
  std::vector<double> kerb_m;
  double square = 0.0, lost = 0.0;
  for (std::size_t i = 80; i + 80 < base.grid.rows(); ++i) {
    double vv = 0.0, ve = 0.0;
    for (std::size_t j = 0; j < base.grid.columns(); ++j) {
      const double v_m = base.grid.v_m[j];
      const double e = static_cast<double>(result.grid.at(i, j)) -
                       lift_m(0.25 * static_cast<double>(i)) - profile_m(v_m, 0.0);
      const float source = result.source.at(i, j);
      const bool measured = source == static_cast<float>(NodeSource::lidar) ||
                            source == static_cast<float>(NodeSource::interpolated);
      if (std::abs(v_m) <= kRoad_m) {
        square += e * e, ++out.road_nodes, lost += measured ? 0.0 : 1.0;
        vv += v_m * v_m, ve += v_m * e;
      } else if (std::abs(v_m) < kKerbEnd_m - 0.1) {
        kerb_m.push_back(std::abs(e));
      }
    }
    out.banking_rad = std::max(out.banking_rad, std::abs(ve / vv));
  }
  out.kerb_nodes = kerb_m.size();
  std::sort(kerb_m.begin(), kerb_m.end());
  out.kerb_p95_m = kerb_m[kerb_m.size() * 95 / 100];
  out.road_rmse_m = std::sqrt(square / static_cast<double>(out.road_nodes));
  out.lost = lost / static_cast<double>(out.road_nodes);
  return out;
}

Judged refine(int passes, double grass_m, std::uint64_t seed) {
  const crg::Crg base = base_road();
  const Drive made = drive(passes, grass_m, seed);
  const MapResult result =
      map_clouds([&](const ChunkSink& sink) { sink(Cloud(made.points)); }, base, &made.trajectory);
  const Judged out = judge(base, result);
  std::printf(
      "%d passes, grass of %.0f mm: road %.2f mm, banking %.4f deg, kerbs %.2f mm, %.2f %% lost\n",
      passes, 1e3 * grass_m, 1e3 * out.road_rmse_m, out.banking_rad * 180.0 / M_PI,
      1e3 * out.kerb_p95_m, 100.0 * out.lost);
  return out;
}

// The left kerb is 25 mm higher than the base has it: where it is taken for grass, it stays so.
void expect_road_and_kerbs(const Judged& seen, double most_road_m) {
  EXPECT_TRUE(seen.converged);
  EXPECT_GT(seen.road_nodes, 20000u);
  EXPECT_GT(seen.kerb_nodes, 3000u);
  EXPECT_LT(seen.road_rmse_m, most_road_m);
  EXPECT_LT(seen.banking_rad, 0.02 * M_PI / 180.0);
  EXPECT_LT(seen.kerb_p95_m, 0.005);
  EXPECT_LT(seen.lost, 0.005);
}

TEST(KerbBesideGrass, IsMeasuredAndNoGrass) { expect_road_and_kerbs(refine(2, 0.06, 1), 0.003); }

TEST(SlowKerbBesideGrass, IsMeasuredWhateverTheGrassStandsHigh) {
  for (const double grass_m : {0.0, 0.015, 0.03, 0.06, 0.12})
    for (const int passes : {2, 1}) {
      SCOPED_TRACE(fmt::format("{} passes, grass of {} m", passes, grass_m));
      expect_road_and_kerbs(refine(passes, grass_m, 2),
                            passes == 1 || grass_m >= 0.06 ? 0.003 : 0.0015);
    }
}

}  // namespace kerb_beside_grass_test
}  // namespace cloud
