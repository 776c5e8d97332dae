// The only file with PCL's headers, for pcl.cpp. Of its large libraries the templates are compiled
// here (impl/): to load those libraries takes 0.1 s, more than most commands.
#pragma once

#include <pcl/common/common.h>
#include <pcl/console/print.h>
#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/octree/octree_pointcloud_changedetector.h>
#include <pcl/pcl_config.h>
#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/sample_consensus_prerejective.h>

#include <pcl/features/impl/feature.hpp>
#include <pcl/features/impl/fpfh.hpp>
#include <pcl/features/impl/fpfh_omp.hpp>
#include <pcl/features/impl/normal_3d.hpp>
#include <pcl/features/impl/normal_3d_omp.hpp>
#include <pcl/filters/impl/filter_indices.hpp>
#include <pcl/filters/impl/morphological_filter.hpp>
#include <pcl/filters/impl/statistical_outlier_removal.hpp>
#include <pcl/filters/impl/voxel_grid.hpp>
#include <pcl/segmentation/impl/approximate_progressive_morphological_filter.hpp>
#include <pcl/segmentation/impl/progressive_morphological_filter.hpp>
