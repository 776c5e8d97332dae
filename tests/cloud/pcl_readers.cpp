// What is written here, as PCL's own readers see it (those of pcl_viewer and of every PCL program).
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <cstring>

#include "cloud/pcl.h"
#include "cloud/read_cloud.h"
#include "cloud/write_surface.h"
#include "support/street_scan.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace {

/// A scan in UTM-like coordinates, with intensity and classes.
Cloud surveyed() {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation().z() = 2.0;
  Cloud cloud = support::scan_street(pose, 1, 1);
  cloud.origin_m = Eigen::Vector3d(485000.0, 5429000.0, 100.0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.intensity.push_back(static_cast<float>(i % 256));
    cloud.classification.push_back(i % 3 == 0 ? 2 : 1);
    cloud.time_s.push_back(1e5 + 1e-5 * static_cast<double>(i));
  }
  return cloud;
}

void expect_the_same(const pcl::PointCloud<pcl::PointXYZI>& seen, const Cloud& wanted) {
  ASSERT_EQ(seen.size(), wanted.size());
  std::size_t differ = 0;
  for (std::size_t i = 0; i < seen.size(); ++i)
    differ += seen[i].x == static_cast<float>(wanted.x_m[i]) &&
                      seen[i].y == static_cast<float>(wanted.y_m[i]) &&
                      seen[i].z == static_cast<float>(wanted.z_m[i]) &&
                      seen[i].intensity == wanted.intensity[i]
                  ? 0
                  : 1;
  EXPECT_EQ(differ, 0u);
}

TEST(PclReaders, SeePcdAndPlyAsTheyWereWritten) {
  const support::TemporaryFolder folder;
  const Cloud cloud = surveyed();
  write_cloud(cloud, folder.path("a.pcd"));
  write_cloud(cloud, folder.path("a.ply"));
  pcl::PointCloud<pcl::PointXYZI> seen;
  ASSERT_EQ(pcl::io::loadPCDFile(folder.path("a.pcd"), seen), 0);
  expect_the_same(seen, cloud);
  ASSERT_EQ(pcl::io::loadPLYFile(folder.path("a.ply"), seen), 0);
  expect_the_same(seen, cloud);
  pcl::PCLPointCloud2 raw;
  ASSERT_EQ(pcl::io::loadPCDFile(folder.path("a.pcd"), raw), 0);
  std::vector<std::string> fields;
  for (const pcl::PCLPointField& field : raw.fields) fields.push_back(field.name);
  EXPECT_THAT(fields, ::testing::ElementsAre("x", "y", "z", "time", "intensity", "classification"));
}

TEST(PclReaders, SeeNormalsAndSigmaOfARoad) {
  const support::TemporaryFolder folder;
  NodeSurface surface;
  surface.origin_m = {485000.0, 5429000.0, 112.0};
  for (int i = 0; i < 500; ++i) {
    surface.place_m.emplace_back(0.1 * i, 3.0, 0.01 * i);
    surface.normal.push_back(Eigen::Vector3f(-0.1f, 0.002f * static_cast<float>(i), 1.0f));
    surface.normal.back().normalize();
    surface.stddev_m.push_back(1e-5f * static_cast<float>(i));
  }
  surface.triangles.push_back({0, 1, 2});
  for (const char* name : {"road.pcd", "road.ply"}) {
    SCOPED_TRACE(name);
    write_surface(surface, folder.path(name));
    pcl::PCLPointCloud2 raw;
    if (folder.path(name).ends_with(".pcd")) {
      ASSERT_EQ(pcl::io::loadPCDFile(folder.path(name), raw), 0);
    } else {
      ASSERT_EQ(pcl::io::loadPLYFile(folder.path(name), raw), 0);
    }
    pcl::PointCloud<pcl::PointNormal> seen;
    pcl::fromPCLPointCloud2(raw, seen);
    ASSERT_EQ(seen.size(), surface.place_m.size());
    const auto sigma = std::find_if(raw.fields.begin(), raw.fields.end(),
                                    [](const auto& field) { return field.name == "sigma"; });
    ASSERT_NE(sigma, raw.fields.end());
    std::size_t differ = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      float stddev = -1.0f;
      std::memcpy(&stddev, raw.data.data() + i * raw.point_step + sigma->offset, sizeof stddev);
      differ += seen[i].getVector3fMap() == surface.place_m[i].cast<float>() &&
                        seen[i].getNormalVector3fMap() == surface.normal[i] &&
                        stddev == surface.stddev_m[i]
                    ? 0
                    : 1;
    }
    EXPECT_EQ(differ, 0u);
  }
}

TEST(PclReaders, WriteWhatIsReadHere) {
  const support::TemporaryFolder folder;
  Cloud cloud = surveyed();
  cloud.origin_m.setZero();
  pcl::PointCloud<pcl::PointXYZI> points;
  to_pcl(cloud, cloud.origin_m, points);
  ASSERT_EQ(pcl::io::savePCDFileBinary(folder.path("binary.pcd"), points), 0);
  ASSERT_EQ(pcl::io::savePCDFileBinaryCompressed(folder.path("packed.pcd"), points), 0);
  ASSERT_EQ(pcl::io::savePCDFileASCII(folder.path("text.pcd"), points), 0);
  for (const char* name : {"binary.pcd", "packed.pcd", "text.pcd"}) {
    SCOPED_TRACE(name);
    const Cloud read = read_cloud(folder.path(name));
    ASSERT_EQ(read.size(), cloud.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < read.size(); ++i)
      worst = std::max(worst, (read.origin_m + read.point(i) - cloud.point(i)).norm());
    EXPECT_LT(worst, 1e-5);
  }
}

TEST(PclReaders, CloudsGoInAndOut) {
  const Cloud cloud = surveyed();
  pcl::PointCloud<pcl::PointXYZI> points;
  to_pcl(cloud, cloud.origin_m, points);
  expect_the_same(points, cloud);
  points[0].x = std::numeric_limits<float>::quiet_NaN();
  const Cloud back = from_pcl(points, cloud.origin_m);
  ASSERT_EQ(back.size() + 1, cloud.size());
  EXPECT_EQ(back.origin_m, cloud.origin_m);
  EXPECT_EQ(back.x_m[0], static_cast<double>(static_cast<float>(cloud.x_m[1])));
}

}  // namespace
}  // namespace cloud
