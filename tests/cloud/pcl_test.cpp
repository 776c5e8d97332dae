#include "cloud/pcl.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "cloud/filter.h"
#include "cloud/ground.h"
#include "road/error.h"
#include "support/street_scan.h"

namespace cloud {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class Pcl : public ::testing::Test {
 protected:
  void SetUp() override {
    if (pcl_version().empty()) GTEST_SKIP() << "built without PCL";
  }
};

void add(Cloud& cloud, double x, double y, double z) {
  cloud.x_m.push_back(x), cloud.y_m.push_back(y), cloud.z_m.push_back(z);
}

/// 100 x 100 points, 0.1 m apart, flat, far from zero.
Cloud plate() {
  Cloud cloud;
  cloud.origin_m = Eigen::Vector3d(485000.0, 5429000.0, 300.0);
  for (int i = 0; i < 100; ++i)
    for (int j = 0; j < 100; ++j) add(cloud, 0.1 * i + 0.013, 0.1 * j + 0.017, 0.01);
  return cloud;
}

TEST_F(Pcl, OutliersAreTakenOut) {
  Cloud cloud = plate();
  for (int k = 0; k < 20; ++k) add(cloud, 0.5 * k, 0.4 * k, 2.0 + k % 3);
  const std::vector<std::uint8_t> kept = statistical_inliers(cloud, 10, 3.0);
  ASSERT_EQ(kept.size(), cloud.size());
  EXPECT_EQ(std::count(kept.begin() + 10000, kept.end(), 1), 0);
  EXPECT_GE(std::count(kept.begin(), kept.begin() + 10000, 1), 9990);
  Cloud few;
  add(few, 0.0, 0.0, 0.0), add(few, 5.0, 0.0, 0.0);
  EXPECT_EQ(statistical_inliers(few, 10, 1.0), std::vector<std::uint8_t>(2, 1));
  EXPECT_TRUE(statistical_inliers(Cloud{}, 10, 1.0).empty());
}

// 5 x 5 points a cube of 0.5 m. PCL alone thins nothing as soon as one point lies 100 km away.
TEST_F(Pcl, CubesLeaveTheirMeanWhereverOnePointLies) {
  for (const double far_m : {0.0, 1e5, -3e6}) {
    Cloud cloud = plate();
    if (far_m != 0.0) add(cloud, far_m, far_m, 0.0);
    const Cloud means = voxel_means(cloud, 0.5);
    ASSERT_EQ(means.size(), far_m == 0.0 ? 400u : 401u);
    std::size_t found = 0;
    for (std::size_t i = 0; i < means.size(); ++i)
      found +=
          std::abs(means.x_m[i] - 0.213) < 1e-6 && std::abs(means.y_m[i] - 0.217) < 1e-6 ? 1 : 0;
    EXPECT_EQ(found, 1u);
    const std::vector<std::uint8_t> kept = voxel_representatives(cloud, 0.5);
    EXPECT_EQ(std::count(kept.begin(), kept.end(), 1), static_cast<long>(means.size()));
    EXPECT_EQ(kept[2 * 100 + 2], 1);  // the one in the middle of the first cube
  }
}

/// 40 degrees and 3 m from the target, and a little tilt.
Eigen::Isometry3d apart() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(2.6, 1.5, 0.05);
  T.rotate(Eigen::AngleAxisd(40.0 * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ()));
  T.rotate(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX()));
  return T;
}

TEST_F(Pcl, ScansFortyDegreesAndThreeMetresApartAreRegisteredWithoutAGuess) {
  Eigen::Isometry3d first = Eigen::Isometry3d::Identity();
  first.translation() = Eigen::Vector3d(0.0, -1.5, 1.9);
  for (const std::uint32_t scene : {1u, 2u, 3u}) {
    const Cloud target = support::scan_street(first, scene, 1),
                source = support::scan_street(first * apart(), scene, 2);
    CoarseReport report;
    RegisterOptions options;
    options.start = coarse_start(target, source, {}, &report);
    EXPECT_GT(report.share, 0.5);
    EXPECT_TRUE(options.start.isApprox(coarse_start(target, source), 0.0)) << "another draw";
    for (const bool gicp : {false, true}) {
      const Eigen::Isometry3d T = gicp ? register_by_gicp(target, source, options)
                                       : register_clouds(target, source, options);
      EXPECT_LT((T.translation() - apart().translation()).norm(), gicp ? 0.05 : 0.02) << scene;
      EXPECT_LT(Eigen::AngleAxisd(T.linear().transpose() * apart().linear()).angle(),
                (gicp ? 0.5 : 0.1) * std::numbers::pi / 180.0)
          << scene;
    }
  }
}

TEST_F(Pcl, NoStartIsInventedWhereNothingStandsUp) {
  Cloud flat = plate();
  EXPECT_THAT([&] { coarse_start(flat, flat); },
              ThrowsMessage<road::Error>(HasSubstr("not flat around")));
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation().z() = 2.0;
  const Cloud street = support::scan_street(pose, 1, 1);
  Cloud heap;  // nothing but scattered points
  for (std::size_t i = 0; i < 20000; ++i)
    add(heap, 0.003 * static_cast<double>((i * 7919) % 20011),
        0.003 * static_cast<double>((i * 104729) % 20011),
        0.001 * static_cast<double>((i * 1299709) % 5003));
  EXPECT_THAT([&] { coarse_start(street, heap); },
              ThrowsMessage<road::Error>(HasSubstr("no start without a guess")));
}

TEST_F(Pcl, GroundFiltersTakeABoxOffASlope) {
  Cloud cloud;
  std::size_t box = 0;
  for (int i = 0; i < 120; ++i)
    for (int j = 0; j < 120; ++j) {
      const double x = 0.5 * i, y = 0.5 * j;
      const bool on = x > 20 && x < 28 && y > 20 && y < 28;
      box += on ? 1 : 0;
      add(cloud, x, y, 0.05 * x + (on ? 4.0 : 0.0));
    }
  PclGroundOptions options;
  for (const bool approximate : {false, true}) {
    options.approximate = approximate;
    const std::vector<std::uint8_t> ground = ground_by_pcl(cloud, options);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < ground.size(); ++i)
      wrong += (ground[i] != 0) == (cloud.z_m[i] - 0.05 * cloud.x_m[i] > 1.0) ? 1 : 0;
    EXPECT_LT(wrong, box / 10) << approximate;
  }
  add(cloud, 1e6, 1e6, 0.0);
  EXPECT_THAT([&] { ground_by_pcl(cloud, options); },
              ThrowsMessage<road::Error>(HasSubstr("points far away")));
}

TEST_F(Pcl, CubesOfOneCloudAloneAreFound) {
  const Cloud before = plate();
  Cloud after = plate();
  for (double& z : after.z_m) z += 0.02;  // not a matter of cubes of 0.5 m
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j) add(after, 3.0 + 0.02 * i, 4.0 + 0.02 * j, 1.2);
  const std::vector<OctreeChange> changes = octree_changes(before, after, 0.5, 5);
  ASSERT_FALSE(changes.empty());
  std::size_t points = 0;
  for (const OctreeChange& change : changes) {
    EXPECT_TRUE(change.appeared);
    EXPECT_NEAR(change.x_m, 485003.2, 0.25);
    EXPECT_NEAR(change.z_m, 301.2, 0.01);
    points += change.points;
  }
  EXPECT_GT(points, 390u);
  for (const OctreeChange& change : octree_changes(after, before, 0.5, 5))
    EXPECT_FALSE(change.appeared);
  EXPECT_TRUE(octree_changes(before, plate(), 0.5, 1).empty());
}

// Points that a moving sensor saw at different times from different places are no neighbours.
TEST_F(Pcl, ScansAreFilteredWhereTheyLieInTheMap) {
  Trajectory trajectory;
  for (int k = 0; k <= 10; ++k) {
    trajectory.time_s.push_back(0.1 * k);
    trajectory.position_m.emplace_back(10.0 * k, 0.0, 2.0);
    trajectory.orientation.push_back(Eigen::Quaterniond::Identity());
  }
  measure(trajectory);
  Cloud
      scan;  // 1000 points, each below the sensor: 0.1 m apart in the map, one place to the sensor
  for (int k = 0; k < 1000; ++k) {
    add(scan, 0.0, 0.0, k == 500 ? -1.0 : -2.0);
    scan.time_s.push_back(0.001 * k + 0.0005);
  }
  FilterOptions options;
  options.outlier_neighbours = 8, options.outlier_sigma = 12.0, options.voxel_m = 0.5;
  FilterReport report;
  const CloudSource source =
      filtered([&](const ChunkSink& sink) { sink(Cloud(scan)), sink(Cloud(scan)); }, &trajectory,
               options, &report);
  for (int reading = 0; reading < 2; ++reading) {
    std::size_t points = 0, chunks = 0;
    source([&](Cloud&& chunk) {
      points += chunk.size(), ++chunks;
      for (std::size_t i = 0; i < chunk.size(); ++i) EXPECT_EQ(chunk.z_m[i], -2.0);
      EXPECT_EQ(chunk.time_s.size(), chunk.size());
    });
    EXPECT_EQ(chunks, 2u);
    EXPECT_NEAR(static_cast<double>(points), 400.0, 6.0);
  }
  EXPECT_EQ(report.points, 2000u);
  EXPECT_EQ(report.outliers, 2u);
}

}  // namespace
}  // namespace cloud
