#include "cloud/base_road.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cloud/error.h"
#include "cloud/synth.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace base_road_test {

double true_height(double x, double y) {
  return 0.3 * std::sin(0.05 * x) + 0.02 * y + 0.01 * std::sin(0.9 * x) * std::cos(0.7 * y);
}

crg::Crg wavy_road() {
  crg::ReferenceLine line;
  line.u_step_m = 0.25;
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  for (int j = -32; j <= 32; ++j) grid.v_m.push_back(0.25 * j);
  for (int i = 0; i <= 1000; ++i) {
    line.x_m.push_back(0.25 * i), line.y_m.push_back(0.0), line.heading_rad.push_back(0.0);
    for (const double v : grid.v_m)
      grid.z_m.push_back(static_cast<float>(true_height(0.25 * i, v)));
  }
  return crg::make_crg(line, grid);
}

TEST(BaseRoad, PointsAndATrajectoryMakeARoad) {
  const support::TemporaryFolder folder;
  ScanSynthOptions options;
  options.azimuths = 256, options.beams = 48, options.cars = 2, options.v_m = {-1.0, 1.0};
  options.u_begin_m = 20.0, options.u_end_m = 130.0;
  options.drift_m_per_100m = 0.0, options.drift_rad_per_100m = 0.0;
  const ScanSynthReport made = synth_scans(wavy_road(), folder.path("scans"), options);
  const Trajectory trajectory = read_trajectory(made.trajectory_path);
  const CloudSource source = [&](const ChunkSink& sink) {
    for (const std::string& path : made.scan_paths) read_chunks(path, {}, sink);
  };
  const road::Centreline line = driven_line(trajectory);
  EXPECT_FALSE(line.closed);
  BaseRoadOptions road_options;
  road_options.v_max_m = 6.0;
  const crg::Crg first = base_from_points(source, line, &trajectory, road_options);
  const MapResult result = map_without_base(source, first, &trajectory, {});
  crg::Crg made_road = first;
  made_road.grid = result.grid;
  const RoadFrame frame(made_road);
  double sum2 = 0.0, first2 = 0.0, count = 0.0;
  std::size_t road = 0, holes = 0;
  const RoadFrame before(first);
  for (std::size_t i = 0; i < frame.rows(); ++i)
    for (std::size_t j = 0; j < frame.columns(); ++j) {
      const Eigen::Vector2d p = frame.node_position(i, frame.v_m()[j]);
      if (p.x() < 30.0 || p.x() > 120.0 || std::abs(p.y()) > 5.0) continue;
      ++road;
      if (!std::isfinite(frame.node(i, j))) {
        ++holes;
        continue;
      }
      const double truth = true_height(p.x(), p.y());
      sum2 += std::pow(static_cast<double>(frame.node(i, j)) + frame.z_origin_m() - truth, 2);
      first2 += std::pow(static_cast<double>(before.node(i, j)) + before.z_origin_m() - truth, 2);
      count += 1.0;
    }
  const double rms = std::sqrt(sum2 / count), first_rms = std::sqrt(first2 / count);
  std::printf("first road rms %.1f mm, refined %.2f mm, holes %.1f %%\n", 1e3 * first_rms,
              1e3 * rms, 100.0 * static_cast<double>(holes) / static_cast<double>(road));
  EXPECT_GT(road, 80000u);
  EXPECT_LT(rms, 0.002);  // measured 0.00108
  EXPECT_LT(rms, first_rms);
  EXPECT_LT(holes, road / 100);
  EXPECT_EQ(result.report.nodes_base, 0u);
  // The trajectory's own word, 5 cm per 100 m; 429 mm were stated once.
  EXPECT_LT(result.report.typical_stddev[2], 0.06);
  EXPECT_THAT(result.report.unfixed, ::testing::Not(::testing::Contains("z")));
}

// Said once: "NOT converged", and that places differ evenly, of drives that had no other fault than
// the drift that was stated.
TEST(SlowBaseRoad, ADriftThatIsAsStatedRaisesNoAlarm) {
  const support::TemporaryFolder folder;
  for (const std::uint64_t seed : {2, 3}) {
    ScanSynthOptions options;
    options.azimuths = 128, options.u_begin_m = 20.0, options.u_end_m = 120.0;
    options.seed = seed;
    const ScanSynthReport made = synth_scans(wavy_road(), folder.path("scans"), options);
    const auto map_with = [&](const Trajectory& trajectory) {
      const CloudSource source = [&](const ChunkSink& sink) {
        for (const std::string& path : made.scan_paths) read_chunks(path, {}, sink);
      };
      BaseRoadOptions road_options;
      road_options.v_max_m = 6.0;
      const crg::Crg first =
          base_from_points(source, driven_line(trajectory), &trajectory, road_options);
      return map_without_base(source, first, &trajectory, {}).report;
    };
    Trajectory trajectory = read_trajectory(made.trajectory_path);
    const MapReport report = map_with(trajectory);
    EXPECT_TRUE(report.converged) << report.iterations << " rounds, " << report.last_move_m;
    EXPECT_THAT(
        report.remarks,
        ::testing::Not(::testing::Contains(::testing::HasSubstr("seen from different places"))))
        << report.view_together;
    EXPECT_LT(report.pass_rms_after_m, 0.002);
    // Two drives, each 5 cm off where it begins and 5 cm more over 100 m, errors of their own: that
    // is what is known about heights, however well the drives fit each other.
    for (const DriftStation& station : report.drift) {
      const double driven = station.u_m - report.drift.front().u_m,
                   known = 0.05 * std::sqrt((1.0 + driven / 100.0) / 2.0);
      EXPECT_GT(station.stddev[2], 0.97 * known) << station.u_m;
      EXPECT_LT(station.stddev[2], std::max(1.03 * known, 0.052)) << station.u_m;
    }
    for (double& time : trajectory.time_s) time += 0.05;
    EXPECT_THAT(map_with(trajectory).remarks,
                ::testing::Contains(::testing::HasSubstr("seen from different places")));
  }
}

TEST(BaseRoad, KnowsALapFromAnOpenRoad) {
  Trajectory round;
  for (int i = 0; i <= 1100; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / 1000.0;
    round.time_s.push_back(0.05 * i);
    round.position_m.emplace_back(60.0 * std::sin(turn), 60.0 * (1.0 - std::cos(turn)), 1.8);
    round.orientation.emplace_back(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  }
  measure(round);
  const road::Centreline lap = driven_line(round);
  EXPECT_TRUE(lap.closed);
  EXPECT_NEAR(lap.length_m, 2.0 * std::numbers::pi * 60.0, 10.0);
  Trajectory half;
  for (std::size_t i = 0; i < 500; ++i)
    half.time_s.push_back(round.time_s[i]), half.position_m.push_back(round.position_m[i]),
        half.orientation.push_back(round.orientation[i]);
  measure(half);
  EXPECT_FALSE(driven_line(half).closed);
  Trajectory short_one;
  for (std::size_t i = 0; i < 10; ++i)
    short_one.time_s.push_back(round.time_s[i]),
        short_one.position_m.push_back(round.position_m[i]),
        short_one.orientation.push_back(round.orientation[i]);
  measure(short_one);
  EXPECT_THROW(driven_line(short_one), cloud::Error);
}

TEST(BaseRoad, SaysThatThePointsAreElsewhere) {
  road::Centreline line;
  for (int i = 0; i < 100; ++i)
    line.points_m.emplace_back(2.0 * i, 0.0, 0.0), line.half_width_m.push_back(5.0);
  line.length_m = 198.0;
  const CloudSource far_away = [](const ChunkSink& sink) {
    Cloud cloud;
    for (int i = 0; i < 1000; ++i)
      cloud.x_m.push_back(i), cloud.y_m.push_back(900.0), cloud.z_m.push_back(0.0);
    sink(std::move(cloud));
  };
  try {
    base_from_points(far_away, line, nullptr);
    FAIL() << "accepted";
  } catch (const cloud::Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("0 of 1000 points lie within 10 m"));
  }
}

}  // namespace base_road_test
}  // namespace cloud
