// In place of pcl.cpp where there is no PCL: everything but pcl_version() says what to install.
#include <fmt/format.h>

#include <cstdlib>

#include "cloud/error.h"
#include "cloud/pcl.h"

namespace cloud {

std::string pcl_version() { return ""; }

void require_pcl(const std::string& option) {
  throw Error(fmt::format(
      "{} needs the Point Cloud Library, which this program was built without; install libpcl-dev, "
      "run cmake again and build",
      option));
}

namespace {

/// For functions that are called without require_pcl() before.
[[noreturn]] void refuse() {
  require_pcl("this");
  std::abort();
}

}  // namespace

void to_pcl(const Cloud&, const Eigen::Vector3d&, pcl::PointCloud<pcl::PointXYZI>&) { refuse(); }
Cloud from_pcl(const pcl::PointCloud<pcl::PointXYZI>&, const Eigen::Vector3d&) { refuse(); }
std::vector<std::uint8_t> statistical_inliers(const Cloud&, int, double) { refuse(); }
Cloud voxel_means(const Cloud&, double) { refuse(); }
std::vector<std::uint8_t> voxel_representatives(const Cloud&, double) { refuse(); }
Eigen::Isometry3d coarse_start(const Cloud&, const Cloud&, const CoarseOptions&, CoarseReport*) {
  refuse();
}
Eigen::Isometry3d register_by_gicp(const Cloud&, const Cloud&, const RegisterOptions&,
                                   RegisterReport*) {
  refuse();
}
std::vector<std::uint8_t> ground_by_pcl(const Cloud&, const PclGroundOptions&) { refuse(); }
std::vector<OctreeChange> octree_changes(const Cloud&, const Cloud&, double, std::size_t) {
  refuse();
}

}  // namespace cloud
