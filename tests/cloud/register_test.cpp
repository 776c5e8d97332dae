#include "cloud/register.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "cloud/error.h"
#include "cloud/read_cloud.h"
#include "support/places.h"
#include "support/street_scan.h"

namespace cloud {
namespace register_test {

/// A street: ground and two walls along x; with `posts` also walls across it.
Cloud street(bool posts, unsigned seed) {
  Cloud cloud;
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> along(-20.0, 20.0), across(-5.0, 5.0), up(0.0, 4.0),
      noise(-0.01, 0.01);
  const auto add = [&](double x, double y, double z) {
    cloud.x_m.push_back(x), cloud.y_m.push_back(y), cloud.z_m.push_back(z);
  };
  for (int i = 0; i < 30000; ++i) add(along(generator), across(generator), noise(generator));
  for (int i = 0; i < 20000; ++i)
    add(along(generator), (i % 2 == 0 ? -5.0 : 5.0) + noise(generator), up(generator));
  if (posts)
    for (int i = 0; i < 8000; ++i)
      add((i % 2 == 0 ? -12.0 : 9.0) + noise(generator), across(generator), up(generator));
  return cloud;
}

Cloud moved(Cloud cloud, const Eigen::Isometry3d& T) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = T * cloud.point(i);
    cloud.x_m[i] = p.x(), cloud.y_m[i] = p.y(), cloud.z_m[i] = p.z();
  }
  return cloud;
}

TEST(Register, FindsAKnownMotion) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() =
      Eigen::AngleAxisd(0.02, Eigen::Vector3d(0.2, 0.1, 1.0).normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(0.4, -0.3, 0.1);
  RegisterReport report;
  const Eigen::Isometry3d found =
      register_clouds(moved(street(true, 1), T), street(true, 2), {}, &report);
  EXPECT_TRUE(report.converged);
  EXPECT_TRUE(report.unfixed.empty());
  EXPECT_LT((found.translation() - T.translation()).norm(), 0.01);
  EXPECT_LT(Eigen::AngleAxisd(found.linear().transpose() * T.linear()).angle(), 0.001);
  EXPECT_LT(report.rms_after_m, report.rms_before_m);
}

TEST(Register, LeavesTheDirectionOfATunnelAlone) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(0.0, 0.2, 0.1);
  RegisterReport report;
  const Eigen::Isometry3d found =
      register_clouds(moved(street(false, 1), T), street(false, 2), {}, &report);
  ASSERT_EQ(report.unfixed.size(), 1u);
  EXPECT_THAT(report.unfixed[0], ::testing::HasSubstr("mostly x"));
  EXPECT_LT(std::abs(found.translation().x()), 0.01);
  EXPECT_NEAR(found.translation().y(), 0.2, 0.01);
}

TEST(Register, FarPointsDoNotHideATurn) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() =
      Eigen::AngleAxisd(0.02, Eigen::Vector3d(0.2, 0.1, 1.0).normalized()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(0.4, -0.3, 0.1);
  for (const double far_m : {8e3, 524288.0, 1e6}) {  // the second: a power of two in voxels
    Cloud target = moved(street(true, 1), T), source = street(true, 2);
    const auto add = [](Cloud& cloud, double x, double y) {
      cloud.x_m.push_back(x), cloud.y_m.push_back(y), cloud.z_m.push_back(0.0);
    };
    for (const double share : {1.0, 0.5, -0.7}) {
      add(source, share * far_m, far_m);
      add(target, share * far_m, far_m);
    }
    add(source, far_m, 0.0);
    RegisterReport report;
    const Eigen::Isometry3d found = register_clouds(target, source, {}, &report);
    EXPECT_TRUE(report.converged) << far_m;
    EXPECT_TRUE(report.unfixed.empty()) << far_m;
    EXPECT_LT((found.translation() - T.translation()).norm(), 0.01) << far_m;
    EXPECT_LT(Eigen::AngleAxisd(found.linear().transpose() * T.linear()).angle(), 0.001) << far_m;
  }
}

TEST(Register, RefusesCloudsThatDoNotMeet) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation().x() = 500.0;
  EXPECT_THROW(register_clouds(moved(street(true, 1), T), street(true, 2)), cloud::Error);
}

TEST(Register, RobustIsFinerWhereThingsMoved) {
  Eigen::Isometry3d from = Eigen::Isometry3d::Identity(), to = from;
  from.translation() = Eigen::Vector3d(0.0, -1.5, 1.9),
  to.translation() = Eigen::Vector3d(0.6, -1.2, 2.0);
  to.rotate(Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitZ()));
  const Cloud target = support::scan_street(from, 3, 1), source = support::scan_street(to, 3, 2);
  RegisterOptions options;
  options.voxel_m = 0.1;
  const auto off_m = [&] {
    return (register_clouds(target, source, options).translation() -
            (from.inverse() * to).translation())
        .norm();
  };
  EXPECT_LT(off_m(), 0.01);
  options.robust = true;
  EXPECT_LT(off_m(), 0.001);
}

TEST(RealClouds, StreetPair) {
  const std::string folder = places::data() + "/lidar/";
  std::ifstream truth(folder + "street_T_target_source.txt");
  if (!truth) GTEST_SKIP() << "no ../shared/data";
  Eigen::Matrix4d T;
  for (int i = 0; i < 16; ++i) truth >> T(i / 4, i % 4);
  RegisterOptions options;
  options.voxel_m = 0.1;  // the stated transform is small_gicp's own at that
  const Eigen::Isometry3d found = register_clouds(
      read_cloud(folder + "street_target.ply"), read_cloud(folder + "street_source.ply"), options);
  EXPECT_LT((found.translation() - T.topRightCorner<3, 1>()).norm(), 0.02);  // measured 0.0002
  EXPECT_LT(
      Eigen::AngleAxisd(found.linear().transpose() * T.topLeftCorner<3, 3>()).angle() * 57.29578,
      0.1);  // measured 0.004
}

}  // namespace register_test
}  // namespace cloud
