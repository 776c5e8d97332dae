// Linked with pcl_absent.cpp: what a program says that was built without PCL.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cloud/error.h"
#include "cloud/pcl.h"

namespace cloud {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

TEST(WithoutPcl, SaysInOneLineWhatToInstall) {
  EXPECT_EQ(pcl_version(), "");
  const auto refused = [](const std::string& option) {
    return ThrowsMessage<cloud::Error>(
        AllOf(HasSubstr(option), HasSubstr("install libpcl-dev"), Not(HasSubstr("\n"))));
  };
  EXPECT_THAT([] { require_pcl("--coarse"); }, refused("--coarse needs the Point Cloud Library"));
  const Cloud cloud;
  EXPECT_THAT([&] { coarse_start(cloud, cloud); }, refused(""));
  EXPECT_THAT([&] { register_by_gicp(cloud, cloud, {}); }, refused(""));
  EXPECT_THAT([&] { ground_by_pcl(cloud); }, refused(""));
  EXPECT_THAT([&] { statistical_inliers(cloud, 20, 2.0); }, refused(""));
  EXPECT_THAT([&] { voxel_means(cloud, 0.1); }, refused(""));
  EXPECT_THAT([&] { voxel_representatives(cloud, 0.1); }, refused(""));
  EXPECT_THAT([&] { octree_changes(cloud, cloud, 0.5, 3); }, refused(""));
}

}  // namespace
}  // namespace cloud
