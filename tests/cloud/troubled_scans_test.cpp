// Trajectories that leap or lack poses, and rain: the road comes out right, and what was seen is
// said.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "cloud/error.h"
#include "support/kerbed_road.h"

namespace cloud {
namespace troubled_scans_test {

/// A cross slope of 1 degree is missing in the base: 83 mm at the edge of the road.
support::KerbedRoad tilted_road() {
  support::KerbedRoad road;
  road.tilt = 0.017;
  return road;
}

MapResult refine(const support::KerbedRoad& road, const support::KerbedScans& made) {
  return map_clouds([&](const ChunkSink& sink) { sink(Cloud(made.points)); }, road.base(),
                    &made.trajectory);
}

bool says(const MapReport& report, const std::string& words) {
  return std::any_of(report.remarks.begin(), report.remarks.end(), [&](const std::string& remark) {
    return remark.find(words) != std::string::npos;
  });
}

void expect_right(const support::KerbedRoad& road, const MapResult& result) {
  const support::KerbedError error = error_of(road, result);
  EXPECT_TRUE(error.converged);
  EXPECT_TRUE(result.report.faults.empty());
  EXPECT_LT(error.road_rmse_m, 0.0015);
  EXPECT_LT(error.banking_rad, 0.02 * M_PI / 180.0);
  EXPECT_LT(error.kerb_p95_m, 0.005);
  EXPECT_LT(error.lost, 0.005);
}

// A new fix of the satellites for 4 s. Before, the drift had to bend over it: 40 mm and exit 3.
TEST(TroubledScans, ATrajectoryThatLeapsHasADriftOfItsOwnBehindTheLeap) {
  const support::KerbedRoad road = tilted_road();
  support::KerbedScans made = scans_of(road, {});
  Trajectory& poses = made.trajectory;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (poses.time_s[i] > 3.0 && poses.time_s[i] < 7.0)
      poses.position_m[i] += Eigen::Vector3d(0.1, 0.4, 0.1);
  measure(poses);
  const MapResult result = refine(road, made);
  expect_right(road, result);
  EXPECT_TRUE(says(result.report, "the trajectory leaps by")) << result.report.remarks.size();
  EXPECT_TRUE(says(result.report, "and 1 more time"));
}

// Each drop had made 2.5 m x 2.5 m an obstacle: the outer metre kept the base, 13 mm off.
TEST(SlowTroubledScans, DropsOfRainAreNoObstacles) {
  const support::KerbedRoad road = tilted_road();
  support::KerbedDrive drive;
  drive.rain = 0.03, drive.grass_m = 0.024;
  const MapResult result = refine(road, scans_of(road, drive));
  expect_right(road, result);
  EXPECT_LT(static_cast<double>(result.report.on_obstacles),
            0.01 * static_cast<double>(result.report.looked_at));
  EXPECT_GT(result.report.on_grass, 0u);
}

// Two points a cell in a stripe of 30 m, one in all others: the base came back with exit 0.
TEST(TroubledScans, AHeightModelIsNoScan) {
  const support::KerbedRoad road;
  Cloud model;
  for (double x_m = 0.25; x_m < road.length_m; x_m += 0.5)
    for (double v_m = -9.75; v_m < 9.9; v_m += v_m == 0.25 && x_m < 30.0 ? 0.05 : 0.5) {
      model.x_m.push_back(x_m), model.y_m.push_back(v_m);
      model.z_m.push_back(road.height_m(x_m, v_m));
    }
  for (const bool correct_drift : {true, false}) {
    MapOptions options;
    options.correct_drift = correct_drift, options.estimate_every = 1;
    try {
      map_clouds([&](const ChunkSink& sink) { sink(Cloud(model)); }, road.base(), nullptr, options);
      ADD_FAILURE() << "not refused";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("they are too far apart"), std::string::npos)
          << error.what();
    }
  }
}

/// Round a bend of 50 m at 15 m/s; `noise_m`: every second place is that much higher.
Trajectory bend(double step_s, double noise_m) {
  Trajectory poses;
  for (int i = 0; i < 400; ++i) {
    const double time_s = i * step_s, angle = 15.0 * time_s / 50.0;
    poses.time_s.push_back(time_s);
    poses.position_m.emplace_back(50.0 * std::cos(angle), 50.0 * std::sin(angle),
                                  i % 2 == 0 ? noise_m : 0.0);
    poses.orientation.push_back(Eigen::Quaterniond::Identity());
  }
  return poses;
}

TEST(Trajectories, HaveNoPosesInGapsThatAreLongForTheirRate) {
  for (const double step_s : {0.01, 0.1}) {
    Trajectory poses = bend(step_s, 0.0);
    const auto from = static_cast<std::ptrdiff_t>(2.0 / step_s),
               to = from + static_cast<std::ptrdiff_t>(0.8 / step_s);
    poses.time_s.erase(poses.time_s.begin() + from, poses.time_s.begin() + to);
    poses.position_m.erase(poses.position_m.begin() + from, poses.position_m.begin() + to);
    poses.orientation.erase(poses.orientation.begin() + from, poses.orientation.begin() + to);
    measure(poses);
    PosedInstant pose;
    std::size_t hint = 0;
    // 0.8 s are eight steps at 10 Hz, which a slow receiver may leave out.
    EXPECT_EQ(pose_at(poses, 2.3, hint, pose), step_s > 0.05);
    EXPECT_TRUE(pose_at(poses, poses.time_s[static_cast<std::size_t>(from) - 1], hint, pose));
    EXPECT_TRUE(pose_at(poses, poses.time_s[static_cast<std::size_t>(from)], hint, pose));
    EXPECT_EQ(poses.piece.back(), 0);
  }
}

// Ten poses a second round a bend of 50 m were taken for a wrong clock: lines from one to the next
// lie 6 mm inside.
TEST(Trajectories, BendBetweenPosesAndSayHowWell) {
  for (const auto& [step_s, within_m] : {std::pair{0.1, 3e-5}, {0.5, 0.004}, {1.01, 0.04}}) {
    Trajectory poses = bend(step_s, 0.0);
    for (std::size_t i = 0; i < poses.size(); ++i)
      poses.orientation[i] =
          Eigen::AngleAxisd(15.0 * poses.time_s[i] / 50.0, Eigen::Vector3d::UnitZ());
    measure(poses);
    PosedInstant pose;
    std::size_t hint = 0;
    double worst_m = 0.0, worst_rad = 0.0, middle_m = 0.0;
    for (int k = 40; k < 200; ++k) {
      const double time_s = 0.25 * k * step_s, angle = 15.0 * time_s / 50.0;
      ASSERT_TRUE(pose_at(poses, time_s, hint, pose)) << step_s;
      const double off_m =
          (pose.position_m - Eigen::Vector3d(50.0 * std::cos(angle), 50.0 * std::sin(angle), 0.0))
              .norm();
      worst_m = std::max(worst_m, off_m);
      if (k % 4 == 2) middle_m = std::max(middle_m, off_m);
      worst_rad = std::max(worst_rad, pose.orientation.angularDistance(Eigen::Quaterniond(
                                          Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()))));
    }
    EXPECT_LT(worst_m, within_m) << step_s;
    EXPECT_LT(worst_rad, 0.1 * within_m) << step_s;
    EXPECT_LT(unknown_between_m(poses), 2.0 * middle_m);
    EXPECT_GT(unknown_between_m(poses), 0.5 * middle_m);
  }
}

TEST(Trajectories, BeginAPieceWhereTheyLeapAndNowhereElse) {
  for (const double step_s : {0.005, 0.01, 0.1, 1.0})
    for (const double noise_m : {0.0, 0.005, 0.02}) {
      Trajectory poses = bend(step_s, noise_m);
      measure(poses);
      EXPECT_EQ(poses.piece.back(), 0) << step_s << " s, " << noise_m << " m";
      if (step_s > 0.05) continue;
      for (std::size_t i = 200; i < poses.size(); ++i)
        poses.position_m[i] += Eigen::Vector3d(0.3, 0.3, 0.0);
      measure(poses);
      EXPECT_EQ(poses.piece.back(), 1) << step_s << " s, " << noise_m << " m";
      EXPECT_EQ(poses.piece[199], 0);
    }
}

}  // namespace troubled_scans_test
}  // namespace cloud
