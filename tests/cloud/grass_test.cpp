// Verge grass beside a drifting trajectory and a wrong base: the road must come out right.
// KERBSTONE_HEAVY=1: all that docs/evidence.md sums up (heights, seeds, with and without cars).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "cloud/synth.h"
#include "support/figure.h"
#include "support/lidar_trial.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace grass_test {

struct Case {
  double grass_mean_m = 0.0;  ///< blades from nothing to twice this
  std::uint64_t seed = 1;
  int cars = 2;
  double drift_share = 1.0;  ///< of 5 cm and 2 mrad per 100 m
};

support::TrialError refine(const support::TrialRoads& roads, const Case& c, MapReport& report) {
  const support::TemporaryFolder folder;
  ScanSynthOptions options;
  options.u_begin_m = 500.0, options.u_end_m = 780.0, options.azimuths = 160;
  options.grass_height_m = 2.0 * c.grass_mean_m;
  options.drift_m_per_100m *= c.drift_share, options.drift_rad_per_100m *= c.drift_share;
  options.cars = c.cars, options.seed = c.seed;
  const ScanSynthReport made = synth_scans(roads.truth, folder.path("scans"), options);
  const Trajectory trajectory = read_trajectory(made.trajectory_path),
                   truth = read_trajectory(made.truth_path);
  MapOptions every_point;  // few points: all of them are looked at
  every_point.estimate_every = 1;
  const CloudSource source = [&](const ChunkSink& sink) {
    for (const std::string& path : made.scan_paths) read_chunks(path, {}, sink);
  };
  const MapResult result = map_clouds(source, roads.base, &trajectory, every_point);
  report = result.report;
  return support::measure_trial(roads, result, truth, 520.0, 760.0);
}

TEST(SlowGrass, BesideTheRoadLeavesTheRoadAlone) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  const support::TrialRoads roads = support::trial_roads();
  // The first one: grass too low to be told column by column; 81.6 % held while it pulled the poses
  // and was said to stand less high than it does. The last one: a trajectory that drifts much at
  // its beginning; 80.5 % held before cells were gathered again where the second look turned poses.
  std::vector<Case> cases = {{0.0025, 17, 0, 1.0},
                             {0.005, 1, 0, 1.0},
                             {0.024, 4, 0, 1.0},
                             {0.060, 5, 2, 1.0},
                             {0.005, 8, 2, 1.0}};
  if (heavy) {
    cases.clear();
    for (const double mean_m : {0.0, 0.0025, 0.005, 0.01, 0.015, 0.024, 0.04, 0.06, 0.12})
      for (std::uint64_t seed = 1; seed <= 8; ++seed)
        cases.push_back({mean_m, seed, seed % 2 == 0 ? 2 : 0, seed > 2 ? 1.0 : 0.3});
  }
  for (const Case& c : cases) {
    MapReport report;
    const support::TrialError error = refine(roads, c, report);
    const std::string row = fmt::format(
        "| {:.1f} mm | {} | {} | {:.1f} | {} | {:.2f} | {:.2f} | {:.4f} | {:.2f} | {:.1f} | {} |",
        1e3 * c.grass_mean_m, c.seed, c.cars, c.drift_share, report.converged, 1e3 * error.z_rmse_m,
        1e3 * error.z_p99_m, error.banking_error_rad / 0.017453293, 1e3 * error.kerb_p95_m,
        100.0 * error.within_90, error.road_nodes);
    support::figure_of_case("z_mm", 1e3 * error.z_rmse_m);
    support::figure_of_case("z_p99_mm", 1e3 * error.z_p99_m);
    support::figure_of_case("banking_deg", error.banking_error_rad / 0.017453293);
    support::figure_of_case("kerb_p95_mm", 1e3 * error.kerb_p95_m);
    support::figure_of_case("inside_percent", 100.0 * error.within_90);
    SCOPED_TRACE(row + "\n" + support::describe(error));
    EXPECT_TRUE(report.converged);
    EXPECT_GT(error.road_nodes, 100000u);
    EXPECT_LT(error.z_rmse_m, 0.003);
    EXPECT_LT(error.z_p99_m, 0.010);
    EXPECT_LT(error.banking_error_rad, 0.05 * 0.017453293);
    EXPECT_LT(error.kerb_p95_m, 0.005);
    EXPECT_GT(error.within_90, 0.85);
    EXPECT_LT(error.within_90, 0.95);
  }
}

/// 12 m of surface, of which 8 m are road: the verge is 2 m wide, and the base ends in it. Steps of
/// 0.25 m.
crg::Crg narrow_road(double curvature_1pm = 0.0) {
  crg::ReferenceLine line;
  line.u_step_m = 0.25;
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  for (int j = -24; j <= 24; ++j) grid.v_m.push_back(0.25 * j);
  double x_m = 0.0, y_m = 0.0;
  for (int i = 0; i <= 1200; ++i) {
    const double middle_rad = curvature_1pm * 0.25 * (i + 0.5);
    line.x_m.push_back(x_m), line.y_m.push_back(y_m);
    line.heading_rad.push_back(curvature_1pm * 0.25 * i);
    x_m += 0.25 * std::cos(middle_rad), y_m += 0.25 * std::sin(middle_rad);
    for (int j = -24; j <= 24; ++j)
      grid.z_m.push_back(static_cast<float>(0.3 * std::sin(0.06 * i) +
                                            0.02 * std::sin(0.5 * i) * std::cos(0.4 * j)));
  }
  return crg::make_crg(line, grid);
}

struct Verge {
  bool converged = false;
  double nodes = 0.0, rmse_m = 0.0, within_90 = 0.0, on_grass = 0.0;
};

Verge refine_narrow(const crg::Crg& road, double grass_mean_m) {
  const support::TemporaryFolder folder;
  ScanSynthOptions options;
  options.laps = 1, options.beams = 32, options.azimuths = 384, options.u_begin_m = 20.0,
  options.u_end_m = 280.0, options.cars = 0;
  options.grass_height_m = 2.0 * grass_mean_m, options.grass_from_m = 4.0;
  const ScanSynthReport made = synth_scans(road, folder.path("scans"), options);
  const Trajectory trajectory = read_trajectory(made.trajectory_path);
  const MapResult result = map_clouds(
      [&](const ChunkSink& sink) {
        for (const std::string& path : made.scan_paths) read_chunks(path, {}, sink);
      },
      road, &trajectory);
  Verge out;
  out.converged = result.report.converged;
  double sum2 = 0.0;
  for (std::size_t i = 200; i < 1000; ++i)
    for (std::size_t j = 0; j < road.grid.columns(); ++j) {
      if (!(result.source.at(i, j) >= static_cast<float>(NodeSource::lidar))) continue;
      const double e = static_cast<double>(result.grid.at(i, j) - road.grid.at(i, j));
      if (std::abs(road.grid.v_m[j]) > 4.1) {
        out.on_grass += 1.0;
        continue;
      }
      if (std::abs(road.grid.v_m[j]) > 3.9) continue;
      sum2 += e * e, out.nodes += 1.0;
      out.within_90 +=
          std::abs(e) <= 1.645 * static_cast<double>(result.stddev.at(i, j)) ? 1.0 : 0.0;
    }
  out.rmse_m = std::sqrt(sum2 / out.nodes), out.within_90 /= out.nodes;
  return out;
}

TEST(Grass, OnANarrowVergeLeavesTheRoadAlone) {
  const bool heavy = std::getenv("KERBSTONE_HEAVY") != nullptr;
  for (const double curvature_1pm : {0.0, 0.006, -0.003}) {
    const crg::Crg road = narrow_road(curvature_1pm);
    for (const double mean_m :
         heavy ? std::vector<double>{0.0, 0.005, 0.01, 0.015, 0.025, 0.04, 0.06, 0.12}
               : std::vector<double>{curvature_1pm > 0.0 ? 0.015 : 0.06}) {
      const Verge out = refine_narrow(road, mean_m);
      const std::string row = fmt::format("| {} 1/m | {:.0f} mm | {} | {:.2f} | {:.1f} | {:.0f} |",
                                          curvature_1pm, 1e3 * mean_m, out.converged,
                                          1e3 * out.rmse_m, 100.0 * out.within_90, out.on_grass);
      if (heavy) std::printf("%s\n", row.c_str()), std::fflush(stdout);
      SCOPED_TRACE(row);
      EXPECT_TRUE(out.converged);
      EXPECT_GT(out.nodes, 15000.0);
      EXPECT_LT(out.rmse_m, 0.003);
      EXPECT_GT(out.within_90, 0.85);
      // On a straight nothing tells whether the base is tilted: this one is not, but the next may
      // be (SlowTiltedBase.OnAStraightIntervalsHoldOverBasesAsGoodAsStated).
      if (curvature_1pm != 0.0) {
        EXPECT_LT(out.within_90, 0.95);
      }
    }
  }
}

// Cells of two or three points were never looked at: single blades became nodes 0.1 m too high that
// were stated to be good to millimetres.
TEST(Grass, InThinScansIsLeftOutAsWell) {
  const crg::Crg road = narrow_road();
  const support::TemporaryFolder folder;
  ScanSynthOptions options;
  options.beams = 16, options.azimuths = 64, options.u_begin_m = 20.0, options.u_end_m = 280.0;
  options.v_m = {-1.0, 1.0}, options.cars = 0, options.grass_height_m = 0.12,
  options.grass_from_m = 4.0;
  const ScanSynthReport made = synth_scans(road, folder.path("scans"), options);
  const Trajectory trajectory = read_trajectory(made.trajectory_path);
  const MapResult result = map_clouds(
      [&](const ChunkSink& sink) {
        for (const std::string& path : made.scan_paths) read_chunks(path, {}, sink);
      },
      road, &trajectory);
  double covered = 0.0, off = 0.0, on_grass = 0.0;
  for (std::size_t i = 200; i < 1000; ++i)
    for (std::size_t j = 0; j < road.grid.columns(); ++j) {
      if (!(result.source.at(i, j) == static_cast<float>(NodeSource::lidar))) continue;
      const double e = static_cast<double>(result.grid.at(i, j) - road.grid.at(i, j));
      covered += 1.0, on_grass += std::abs(road.grid.v_m[j]) > 4.1 ? 1.0 : 0.0;
      off += std::abs(e) > 3.0 * static_cast<double>(result.stddev.at(i, j)) ? 1.0 : 0.0;
    }
  std::printf("%.0f nodes with points, %.0f of them on grass, %.3f %% off by three deviations\n",
              covered, on_grass, 100.0 * off / covered);
  EXPECT_TRUE(result.report.converged);
  EXPECT_GT(covered, 10000.0);
  EXPECT_LT(off / covered, 0.005);
}

}  // namespace grass_test
}  // namespace cloud
