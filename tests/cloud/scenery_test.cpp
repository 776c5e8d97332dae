// Trees, poles and walls beside a road in made-up scans: they are there, and the road beside them
// comes out as without them.
#include "scenery.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "cloud/error.h"
#include "cloud/map.h"
#include "cloud/synth.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace scenery_test {

/// 200 m, 24 m wide, with waves of 20 mm; its heights in the middle of x are known.
crg::Crg wide_road() {
  crg::ReferenceLine line;
  line.u_step_m = 0.25;
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  for (int j = -48; j <= 48; ++j) grid.v_m.push_back(0.25 * j);
  for (int i = 0; i <= 800; ++i) {
    line.x_m.push_back(0.25 * i), line.y_m.push_back(0.0), line.heading_rad.push_back(0.0);
    for (int j = -48; j <= 48; ++j)
      grid.z_m.push_back(static_cast<float>(0.3 * std::sin(0.06 * i) +
                                            0.02 * std::sin(0.5 * i) * std::cos(0.4 * j)));
  }
  return crg::make_crg(line, grid);
}

ScanSynthOptions short_drive() {
  ScanSynthOptions options;
  options.beams = 32, options.azimuths = 192, options.u_begin_m = 20.0, options.u_end_m = 180.0;
  options.cars = 0, options.scenery_every_m = 8.0, options.grass_height_m = 0.03;
  return options;
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Scenery, RaysMeetWhatStandsInTheirWay) {
  base::Random random(1);
  Scenery scenery;
  scenery.rounds.push_back({{10.0, 0.0, 0.0}, 0.5, 2.0, false});
  const Eigen::Vector3d eye(0.0, 0.0, 1.0), ahead = Eigen::Vector3d::UnitX();
  EXPECT_NEAR(distance_to(scenery, eye, ahead, random), 9.5, 1e-12);
  EXPECT_FALSE(std::isfinite(distance_to(scenery, eye, -ahead, random)));
  EXPECT_FALSE(std::isfinite(distance_to(scenery, {0.0, 0.6, 1.0}, ahead, random)));
  EXPECT_FALSE(std::isfinite(distance_to(scenery, {0.0, 0.0, 2.1}, ahead, random)));
  // From above through the lid: 1 m down at 45 degrees.
  EXPECT_NEAR(distance_to(scenery, {9.0, 0.0, 3.0}, Eigen::Vector3d(1, 0, -1).normalized(), random),
              std::sqrt(2.0), 1e-12);
  scenery.walls.push_back({{5.0, 0.0, 0.5}, {0.0, 1.0}, {2.0, 0.25, 0.6}});
  EXPECT_NEAR(distance_to(scenery, eye, ahead, random), 4.75, 1e-12);
  EXPECT_NEAR(distance_to(scenery, {0.0, 0.0, 1.2}, ahead, random), 9.5, 1e-12);  // over the wall
  Scenery tree;
  tree.rounds.push_back({{10.0, 0.0, 0.0}, 0.5, 2.0, true});
  int through = 0;
  for (int k = 0; k < 1000; ++k) {
    const double range = distance_to(tree, eye, ahead, random);
    if (!std::isfinite(range)) {
      ++through;
      continue;
    }
    EXPECT_GE(range, 9.5);
    EXPECT_LE(range, 10.5);
  }
  EXPECT_NEAR(through, 1000.0 * std::exp(-1.0 / 0.3), 30.0);  // 1 m of leaves
}

struct Errors {
  double road_nodes = 0.0, road_rms_m = 0.0, high_nodes = 0.0, largest_m = 0.0;
};

Errors mapped(const crg::Crg& road, const ScanSynthReport& made) {
  const Trajectory trajectory = read_trajectory(made.trajectory_path);
  const MapResult result = map_clouds(
      [&](const ChunkSink& sink) {
        for (const std::string& path : made.scan_paths) read_chunks(path, {}, sink);
      },
      road, &trajectory);
  EXPECT_TRUE(result.report.converged);
  EXPECT_GT(result.report.on_obstacles, 100u);
  Errors out;
  double sum2 = 0.0;
  for (std::size_t i = 160; i < 640; ++i)
    for (std::size_t j = 0; j < road.grid.columns(); ++j) {
      const double e = static_cast<double>(result.grid.at(i, j) - road.grid.at(i, j));
      out.high_nodes += std::abs(e) > 0.05 ? 1.0 : 0.0;
      out.largest_m = std::max(out.largest_m, std::abs(e));
      if (std::abs(road.grid.v_m[j]) < 8.0 &&
          result.source.at(i, j) >= static_cast<float>(NodeSource::lidar))
        out.road_nodes += 1.0, sum2 += e * e;
    }
  out.road_rms_m = std::sqrt(sum2 / out.road_nodes);
  std::printf("%.0f nodes of road, rms %.2f mm; %.0f nodes off by more than 50 mm, at most %.0f\n",
              out.road_nodes, 1e3 * out.road_rms_m, out.high_nodes, 1e3 * out.largest_m);
  return out;
}

TEST(Scenery, StandsBesideTheRoadAndLeavesItAlone) {
  const support::TemporaryFolder folder;
  const crg::Crg road = wide_road();
  ScanSynthOptions options = short_drive();
  options.threads = 1;
  const ScanSynthReport made = synth_scans(road, folder.path("one"), options);
  options.threads = 3;
  const ScanSynthReport again = synth_scans(road, folder.path("three"), options);
  ASSERT_EQ(made.scan_paths.size(), again.scan_paths.size());
  for (std::size_t k = 0; k < made.scan_paths.size(); ++k)
    EXPECT_TRUE(bytes_of(made.scan_paths[k]) == bytes_of(again.scan_paths[k])) << k;
  EXPECT_GT(made.share_on_scenery, 0.02);
  EXPECT_LT(made.share_on_scenery, 0.5);
  EXPECT_EQ(made.share_on_cars, 0.0);

  const Errors errors = mapped(road, made);
  EXPECT_GT(errors.road_nodes, 10000.0);
  EXPECT_LT(errors.road_rms_m, 0.003);
  EXPECT_EQ(errors.high_nodes, 0.0);  // what stands on grass is no ground
}

// On a verge without grass their feet, which beams from far away meet alone, were ground.
TEST(Scenery, FeetOnABareVergeAreNoGround) {
  const support::TemporaryFolder folder;
  const crg::Crg road = wide_road();
  ScanSynthOptions options = short_drive();
  options.grass_height_m = 0.0;
  const Errors errors = mapped(road, synth_scans(road, folder.path("scans"), options));
  EXPECT_GT(errors.road_nodes, 10000.0);
  EXPECT_LT(errors.road_rms_m, 0.003);
  EXPECT_LT(errors.high_nodes, 10.0);
}

TEST(Scenery, RefusesWhatNoRoadHas) {
  const support::TemporaryFolder folder;
  ScanSynthOptions options = short_drive();
  for (const double every_m : {-5.0, 0.5, std::nan("")}) {
    options.scenery_every_m = every_m;
    EXPECT_THROW(synth_scans(wide_road(), folder.path("scans"), options), Error) << every_m;
  }
}

}  // namespace scenery_test
}  // namespace cloud
