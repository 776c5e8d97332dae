// What lidar2mesh has the Point Cloud Library do, where it was built with it (KERBSTONE_PCL). PCL's
// headers are included by one source file; without PCL every function here but pcl_version() throws
// Error that says what to install.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "cloud/cloud.h"
#include "cloud/register.h"

namespace pcl {
template <typename PointT>
class PointCloud;
struct PointXYZI;
}  // namespace pcl

namespace cloud {

/// "1.13.0"; empty where this was built without PCL.
std::string pcl_version();

/// Throws Error naming `option` where this was built without PCL.
void require_pcl(const std::string& option);

/// Coordinates relative to `origin_m` as float32 (0.5 mm at 4 km), intensity 0 where there is none.
void to_pcl(const Cloud& cloud, const Eigen::Vector3d& origin_m,
            pcl::PointCloud<pcl::PointXYZI>& out);

/// The way back. Points that are not finite are left out.
Cloud from_pcl(const pcl::PointCloud<pcl::PointXYZI>& cloud, const Eigen::Vector3d& origin_m);

/// 1 for points to keep, one per point: pcl::StatisticalOutlierRemoval. Away go points whose mean
/// distance to their `neighbours` nearest is more than `sigma` deviations above the mean of all.
/// All are kept where there are no more points than neighbours.
std::vector<std::uint8_t> statistical_inliers(const Cloud& cloud, int neighbours, double sigma);

/// Means per cube of voxel_m (pcl::VoxelGrid), coordinates only, in the cloud's own origin. Worked
/// on in blocks of 1000 cubes: PCL numbers the cubes in 32 bits and thins nothing where these do
/// not do, as with one point far away.
Cloud voxel_means(const Cloud& cloud, double voxel_m);

/// 1 for the point of each cube that is nearest to the cube's mean (pcl::VoxelGrid), one per point.
std::vector<std::uint8_t> voxel_representatives(const Cloud& cloud, double voxel_m);

struct CoarseOptions {
  double voxel_m = 0.5;    ///< of the points that features are computed for; doubled until 20,000
                           ///< points or fewer are left
  std::uint32_t seed = 1;  ///< of the draws: the same seed gives the same transform
  int tries = 3;
  int draws = 5000;  ///< of three pairs of points, per try
};

struct CoarseReport {
  double voxel_m = 0.0;    ///< that was used
  std::size_t points = 0;  ///< of the source that is not flat around
  double share = 0.0;      ///< of these, with one of the target's within 1.5 voxels
};

/// T_target_source without a guess, to about half a voxel and 2 degrees: fast point feature
/// histograms (Rusu, Blodow, Beetz 2009) of what is not flat, paired by drawing threes
/// (pcl::SampleConsensusPrerejective, Buch et al. 2013); of the tries the one that brings most
/// points together wins. For clouds with shapes that stand up: flat ground says nothing. Throws
/// Error where fewer than 100 points are not flat, or none of the tries brings 30 % of these
/// together.
Eigen::Isometry3d coarse_start(const Cloud& target, const Cloud& source,
                               const CoarseOptions& options = {}, CoarseReport* report = nullptr);

/// pcl::GeneralizedIterativeClosestPoint from options.start, both clouds thinned by pcl::VoxelGrid.
/// Directions that the data does not fix are not left alone. Of the report: converged, iterations,
/// points.
Eigen::Isometry3d register_by_gicp(const Cloud& target, const Cloud& source,
                                   const RegisterOptions& options,
                                   RegisterReport* report = nullptr);

struct PclGroundOptions {
  double cell_m = 1.0;
  double max_window_m = 10.0;  ///< radius of the largest object
  double slope = 1.0;          ///< m/m
  double height_m = 0.5;       ///< of points above the opened surface, first threshold ...
  double max_height_m = 3.0;   ///< ... and the last
  bool approximate = false;    ///< on a grid of cells, much faster
};

/// 1 for ground, one per point: PCL's progressive morphological filter (Zhang et al. 2003), with
/// the options of PCL's own example. Throws Error where the grid of the approximate one,
/// which grows with the box around the points, would keep it busy for minutes (points far away).
std::vector<std::uint8_t> ground_by_pcl(const Cloud& cloud, const PclGroundOptions& options = {});

/// Cubes of an octree that hold points of one cloud alone
/// (pcl::octree::OctreePointCloudChangeDetector).
struct OctreeChange {
  double x_m = 0.0, y_m = 0.0, z_m = 0.0;  ///< map frame, mean of the points
  std::size_t points = 0;
  bool appeared = true;  ///< false: of the old cloud alone
};

/// Cubes of side cube_m with at least min_points points of one cloud and none of the other, which
/// are half a cube or more from every point of the other; what appeared first, by x, y, z.
std::vector<OctreeChange> octree_changes(const Cloud& before, const Cloud& after, double cube_m,
                                         std::size_t min_points);

}  // namespace cloud
