// Coordinates that float32 holds to no better than a millimetre: whoever reads them says so.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cloud/map_scans.h"
#include "cloud/read_cloud.h"
#include "support/cloud_files.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace float32_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kWayOut =
    " (float32 coordinates far from zero); export the cloud in double or with a local origin";

CloudReadReport read(const std::string& bytes, const std::string& name,
                     const CloudReadOptions& options = {}) {
  const support::TemporaryFolder folder;
  CloudReadReport report;
  read_cloud(folder.file(name, bytes), options, &report);
  return report;
}

TEST(Float32, StepsOfMoreThanAMillimetreAreSaid) {
  const support::CloudSeed utm;  // x 500,000 m, y 5,400,000 m, z 100 m
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"a.ply", support::as_cloud_ply(utm, "binary_little_endian", false)},
           {"b.ply", support::as_cloud_ply(utm, "binary_big_endian", false)},
           {"a.pcd", support::as_pcd(utm, "binary", false)},
           {"b.pcd", support::as_pcd(utm, "binary_compressed", false)},
           {"a.bin", support::as_kitti(utm)}}) {
    SCOPED_TRACE(name);
    const CloudReadReport report = read(bytes, name);
    EXPECT_EQ(report.float32_step_m[1], 0.5);
    EXPECT_THAT(report.remarks, ElementsAre(std::string("x is quantised to 0.03125 m") + kWayOut,
                                            std::string("y is quantised to 0.5 m") + kWayOut));
    CloudReadOptions feet;
    feet.metres_per_unit = 0.3048;
    EXPECT_DOUBLE_EQ(read(bytes, name, feet).float32_step_m[1], 0.1524);
  }
  // From 2^14 m on the steps are 1.95 mm.
  for (const auto& [x0, remarks] : {std::pair{16'300.0, 0u}, {16'400.0, 1u}, {-16'500.0, 1u}})
    EXPECT_EQ(read(support::as_kitti({.x0 = x0, .y0 = 0.0}), "a.bin").remarks.size(), remarks)
        << x0;
}

TEST(Float32, WhatIsFineEnoughIsNotSaid) {
  const support::CloudSeed utm;
  for (const char* format : {"ascii", "binary_little_endian"})
    EXPECT_THAT(read(support::as_cloud_ply(utm, format, true), "a.ply").remarks, IsEmpty());
  EXPECT_THAT(read(support::as_cloud_ply(utm, "ascii", false), "a.ply").remarks, IsEmpty());
  EXPECT_THAT(read(support::as_las(utm, 4, 6), "a.las").remarks, IsEmpty());
  const support::TemporaryFolder folder;
  const Cloud cloud = read_cloud(folder.file("a.las", support::as_las(utm, 4, 6)));
  for (const char* name : {"b.ply", "b.pcd"}) {
    write_cloud(cloud, folder.path(name));  // float32 relative to an origin
    CloudReadReport report;
    read_cloud(folder.path(name), {}, &report);
    EXPECT_THAT(report.remarks, IsEmpty());
  }
}

TEST(Float32, ScansOfAMapSayItOnceForAllFiles) {
  const support::TemporaryFolder folder;
  RefineRequest request;
  for (const char* name : {"a.bin", "b.bin", "c.bin"})
    request.scans.push_back(folder.file(name, support::as_kitti({.x0 = 20'000.0, .y0 = 0.0})));
  request.scans.push_back(folder.file("d.bin", support::as_kitti({.x0 = 0.0, .y0 = 40'000.0})));
  MapScans scans(request, request.scans, [](const std::string&, double) {});
  for (int reading = 0; reading < 2; ++reading) {
    scans.source()([](Cloud&&) {});
    EXPECT_THAT(
        scans.remarks(),
        ElementsAre(folder.path("a.bin") + " and 2 more: x is quantised to 0.00195312 m" + kWayOut,
                    folder.path("d.bin") + ": y is quantised to 0.00390625 m" + kWayOut));
  }
}

TEST(Float32, EveryCommandThatReadsCloudsSaysIt) {
  const support::TemporaryFolder folder;
  std::string values;
  for (int i = 0; i < 10'000; ++i) {
    const int row = i / 100;
    const double x = 0.1 * (i % 100), y = 0.1 * row;
    for (const double v : {500'000.0 + x, y, 0.2 * std::sin(x) + 0.1 * std::cos(2.0 * y), 0.0}) {
      const auto single = static_cast<float>(v);
      values.append(reinterpret_cast<const char*>(&single), sizeof single);
    }
  }
  const std::string cloud = folder.file("a.bin", values);
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"info", cloud},
        {"ground", cloud, "-o", folder.path("ground.ply")},
        {"tiles", cloud, "-o", folder.path("tiles")},
        {"changes", cloud, cloud, "-o", folder.path("changes")},
        {"register", cloud, cloud}}) {
    const support::ToolRun ran = support::run_tool(places::lidar2mesh(), command);
    EXPECT_EQ(ran.code, 0) << ran.err;
    EXPECT_THAT(ran.out + ran.err, HasSubstr("x is quantised to 0.03125 m")) << command[0];
  }
}

}  // namespace float32_test
}  // namespace cloud
