// PCL computes in float32: points go to it relative to an origin of their own. What it prints is
// turned off; what it does not do is found by its results.
#include "cloud/pcl.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <thread>

#include "cloud/error.h"
#include "local_origin.h"
#include "pcl_headers.h"

namespace cloud {
namespace {

using Point = pcl::PointXYZ;
using Points = pcl::PointCloud<Point>;
using Normals = pcl::PointCloud<pcl::Normal>;
using Features = pcl::PointCloud<pcl::FPFHSignature33>;

void quiet() { pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); }

unsigned threads_of(unsigned threads) {
  return threads != 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
}

Points::Ptr points_of(const Cloud& cloud, const Eigen::Vector3d& origin) {
  auto out = std::make_shared<Points>();
  out->reserve(cloud.size());
  const Eigen::Vector3d shift = cloud.origin_m - origin;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = (cloud.point(i) + shift).cast<float>();
    out->push_back(Point(p.x(), p.y(), p.z()));
  }
  return out;
}

/// What each block of 1000 x 1000 x 1000 cubes holds, thinned by itself: `each` gets the block's
/// corner (cloud frame), its points, their numbers in the cloud, and the means of the cubes.
template <typename Each>
void thin_blocks(const Cloud& cloud, double voxel_m, const Each& each) {
  constexpr double kSide = 1000.0;
  using Block = std::array<double, 3>;
  std::map<Block, std::vector<std::size_t>> blocks;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = cloud.point(i) / (kSide * voxel_m);
    blocks[{std::floor(p.x()), std::floor(p.y()), std::floor(p.z())}].push_back(i);
  }
  for (const auto& [block, numbers] : blocks) {
    const Eigen::Vector3d corner = Eigen::Vector3d(block[0], block[1], block[2]) * kSide * voxel_m;
    auto points = std::make_shared<Points>();
    points->reserve(numbers.size());
    for (const std::size_t i : numbers) {
      const Eigen::Vector3f p = (cloud.point(i) - corner).cast<float>();
      points->push_back(Point(p.x(), p.y(), p.z()));
    }
    pcl::VoxelGrid<Point> grid;
    const auto side = static_cast<float>(voxel_m);
    grid.setLeafSize(side, side, side);
    grid.setInputCloud(points);
    Points means;
    grid.filter(means);
    each(corner, points, numbers, means);
  }
}

/// Points with their features, of what is not flat around.
struct Described {
  Points::Ptr points = std::make_shared<Points>();
  Features::Ptr features = std::make_shared<Features>();
};

constexpr float kFlat = 0.01f;  ///< smallest of the three variances of neighbours over their sum

Described describe_shapes(const Points::Ptr& all, double voxel_m) {
  // Normals look to the middle: near where both clouds were seen from, when they overlap.
  Normals::Ptr normals = std::make_shared<Normals>();
  pcl::NormalEstimationOMP<Point, pcl::Normal> estimate_normals(threads_of(0));
  estimate_normals.setInputCloud(all);
  estimate_normals.setRadiusSearch(2.5 * voxel_m);
  estimate_normals.compute(*normals);
  Described out;
  for (std::size_t i = 0; i < all->size(); ++i)
    if ((*normals)[i].curvature > kFlat) out.points->push_back((*all)[i]);
  if (out.points->empty()) return out;
  pcl::FPFHEstimationOMP<Point, pcl::Normal, pcl::FPFHSignature33> estimate(threads_of(0));
  estimate.setInputCloud(out.points);
  estimate.setSearchSurface(all);
  estimate.setInputNormals(normals);
  estimate.setRadiusSearch(5.0 * voxel_m);
  estimate.compute(*out.features);
  return out;
}

/// Counts its iterations.
class Gicp : public pcl::GeneralizedIterativeClosestPoint<Point, Point> {
 public:
  int iterations() const { return nr_iterations_; }
};

std::vector<std::uint8_t> marked(const pcl::Indices& indices, std::size_t size) {
  std::vector<std::uint8_t> out(size, 0);
  for (const auto index : indices) out[static_cast<std::size_t>(index)] = 1;
  return out;
}

/// Cubes with so many points of the second cloud and none of the first near them; means of these
/// points.
std::vector<OctreeChange> cubes_of_second_alone(const Points::Ptr& first, const Points::Ptr& second,
                                                double cube_m, std::size_t min_points) {
  pcl::octree::OctreePointCloudChangeDetector<Point> octree(cube_m);
  // Both clouds in one box, so that their cubes are the same.
  Eigen::Vector4f low, high, low2, high2;
  pcl::getMinMax3D(*first, low, high);
  pcl::getMinMax3D(*second, low2, high2);
  low = low.cwiseMin(low2), high = high.cwiseMax(high2);
  octree.defineBoundingBox(static_cast<double>(low.x()), static_cast<double>(low.y()),
                           static_cast<double>(low.z()), static_cast<double>(high.x()),
                           static_cast<double>(high.y()), static_cast<double>(high.z()));
  octree.setInputCloud(first);
  octree.addPointsFromInputCloud();
  octree.switchBuffers();
  octree.setInputCloud(second);
  octree.addPointsFromInputCloud();
  pcl::Indices indices;
  octree.getPointIndicesFromNewVoxels(indices, static_cast<pcl::uindex_t>(min_points));
  // A surface that runs along the side of a cube is on both sides of it.
  pcl::KdTreeFLANN<Point> tree;
  tree.setInputCloud(first);
  pcl::Indices nearest(1);
  std::vector<float> distance2(1);
  // The points of a cube together again.
  std::map<std::array<std::int64_t, 3>, OctreeChange> cubes;
  double least_x = 0.0, least_y = 0.0, least_z = 0.0, most_x = 0.0, most_y = 0.0, most_z = 0.0;
  octree.getBoundingBox(least_x, least_y, least_z, most_x, most_y, most_z);
  for (const auto index : indices) {
    const Point& point = (*second)[static_cast<std::size_t>(index)];
    if (tree.nearestKSearch(point, 1, nearest, distance2) == 0 ||
        static_cast<double>(distance2[0]) < 0.25 * cube_m * cube_m)
      continue;
    const Eigen::Vector3d p = point.getVector3fMap().cast<double>();
    const auto part = [&](double value, double least) {
      return static_cast<std::int64_t>(std::floor((value - least) / cube_m));
    };
    OctreeChange& cube = cubes[{part(p.x(), least_x), part(p.y(), least_y), part(p.z(), least_z)}];
    cube.x_m += p.x(), cube.y_m += p.y(), cube.z_m += p.z(), cube.points += 1;
  }
  std::vector<OctreeChange> out;
  for (auto& [key, cube] : cubes) {
    if (cube.points < min_points) continue;
    const auto n = static_cast<double>(cube.points);
    cube.x_m /= n, cube.y_m /= n, cube.z_m /= n;
    out.push_back(cube);
  }
  return out;
}

}  // namespace

std::string pcl_version() { return PCL_VERSION_PRETTY; }

void require_pcl(const std::string&) {}

void to_pcl(const Cloud& cloud, const Eigen::Vector3d& origin_m,
            pcl::PointCloud<pcl::PointXYZI>& out) {
  out.clear();
  out.reserve(cloud.size());
  const Eigen::Vector3d shift = cloud.origin_m - origin_m;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = (cloud.point(i) + shift).cast<float>();
    pcl::PointXYZI& point = out.emplace_back();
    point.x = p.x(), point.y = p.y(), point.z = p.z();
    point.intensity = cloud.intensity.empty() ? 0.0f : cloud.intensity[i];
  }
}

Cloud from_pcl(const pcl::PointCloud<pcl::PointXYZI>& cloud, const Eigen::Vector3d& origin_m) {
  Cloud out;
  out.origin_m = origin_m;
  for (const pcl::PointXYZI& point : cloud) {
    if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) continue;
    out.x_m.push_back(static_cast<double>(point.x));
    out.y_m.push_back(static_cast<double>(point.y));
    out.z_m.push_back(static_cast<double>(point.z));
    out.intensity.push_back(point.intensity);
  }
  return out;
}

std::vector<std::uint8_t> statistical_inliers(const Cloud& cloud, int neighbours, double sigma) {
  quiet();
  if (cloud.size() <= static_cast<std::size_t>(neighbours))
    return std::vector<std::uint8_t>(cloud.size(), 1);
  pcl::StatisticalOutlierRemoval<Point> filter;
  filter.setInputCloud(points_of(cloud, middle_of(cloud)));
  filter.setMeanK(neighbours);
  filter.setStddevMulThresh(sigma);
  pcl::Indices kept;
  filter.filter(kept);
  return marked(kept, cloud.size());
}

Cloud voxel_means(const Cloud& cloud, double voxel_m) {
  quiet();
  Cloud out;
  out.origin_m = cloud.origin_m;
  thin_blocks(cloud, voxel_m,
              [&](const Eigen::Vector3d& corner, const Points::Ptr&,
                  const std::vector<std::size_t>&, const Points& means) {
                for (const Point& mean : means) {
                  const Eigen::Vector3d p = corner + mean.getVector3fMap().cast<double>();
                  out.x_m.push_back(p.x()), out.y_m.push_back(p.y()), out.z_m.push_back(p.z());
                }
              });
  return out;
}

std::vector<std::uint8_t> voxel_representatives(const Cloud& cloud, double voxel_m) {
  quiet();
  std::vector<std::uint8_t> out(cloud.size(), 0);
  thin_blocks(cloud, voxel_m,
              [&](const Eigen::Vector3d&, const Points::Ptr& points,
                  const std::vector<std::size_t>& numbers, const Points& means) {
                pcl::KdTreeFLANN<Point> tree;
                tree.setInputCloud(points);
                pcl::Indices nearest(1);
                std::vector<float> distance2(1);
                for (const Point& mean : means)
                  if (tree.nearestKSearch(mean, 1, nearest, distance2) > 0)
                    out[numbers[static_cast<std::size_t>(nearest[0])]] = 1;
              });
  return out;
}

Eigen::Isometry3d coarse_start(const Cloud& target, const Cloud& source,
                               const CoarseOptions& options, CoarseReport* report) {
  quiet();
  constexpr std::size_t kMostPoints = 20'000, kFewestPoints = 100;
  constexpr double kLeastShare = 0.3;
  CoarseReport unused;
  CoarseReport& facts = report != nullptr ? *report : unused;
  facts = {};
  facts.voxel_m = options.voxel_m;
  Cloud to = voxel_means(target, facts.voxel_m), from = voxel_means(source, facts.voxel_m);
  while (std::max(to.size(), from.size()) > kMostPoints) {
    facts.voxel_m *= 2.0;
    to = voxel_means(to, facts.voxel_m), from = voxel_means(from, facts.voxel_m);
  }
  const Eigen::Vector3d to_middle = middle_of(to), from_middle = middle_of(from);
  const Described there = describe_shapes(points_of(to, to_middle), facts.voxel_m),
                  here = describe_shapes(points_of(from, from_middle), facts.voxel_m);
  facts.points = here.points->size();
  if (std::min(here.points->size(), there.points->size()) < kFewestPoints)
    throw Error(
        fmt::format("no start without a guess: {} and {} of the points, thinned to {:g} m, are not "
                    "flat around, "
                    "{} each wanted; bring the clouds nearly into place first",
                    there.points->size(), here.points->size(), facts.voxel_m, kFewestPoints));
  Eigen::Matrix4f best = Eigen::Matrix4f::Identity();
  for (int attempt = 0; attempt < options.tries; ++attempt) {
    std::srand(options.seed + static_cast<unsigned>(attempt));  // PCL draws by std::rand()
    pcl::SampleConsensusPrerejective<Point, Point, pcl::FPFHSignature33> align;
    align.setInputSource(here.points);
    align.setSourceFeatures(here.features);
    align.setInputTarget(there.points);
    align.setTargetFeatures(there.features);
    align.setMaximumIterations(options.draws);
    align.setNumberOfSamples(3);
    align.setCorrespondenceRandomness(3);
    align.setSimilarityThreshold(0.9f);
    align.setMaxCorrespondenceDistance(1.5 * facts.voxel_m);
    align.setInlierFraction(0.1f);
    Points moved;
    align.align(moved);
    const double share = align.hasConverged() ? static_cast<double>(align.getInliers().size()) /
                                                    static_cast<double>(here.points->size())
                                              : 0.0;
    if (share > facts.share) facts.share = share, best = align.getFinalTransformation();
  }
  if (facts.share < kLeastShare)
    throw Error(fmt::format(
        "no start without a guess: the best of {} tries brings {:.0f} % of the shapes together, "
        "{:.0f} % wanted; the clouds show different places, or flat ground alone",
        options.tries, 100.0 * facts.share, 100.0 * kLeastShare));
  return in_map(best, to_middle, from_middle);
}

Eigen::Isometry3d register_by_gicp(const Cloud& target, const Cloud& source,
                                   const RegisterOptions& options, RegisterReport* report) {
  quiet();
  const Cloud to = voxel_means(target, options.voxel_m),
              from = voxel_means(source, options.voxel_m);
  const Eigen::Vector3d origin = middle_of(to);
  // The source in place already: its float32 coordinates are small, too.
  Cloud placed = from;
  placed.origin_m = origin;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d p = options.start * (from.origin_m + from.point(i)) - origin;
    placed.x_m[i] = p.x(), placed.y_m[i] = p.y(), placed.z_m[i] = p.z();
  }
  if (std::min(to.size(), from.size()) <= static_cast<std::size_t>(options.neighbours))
    throw Error(
        fmt::format("{} and {} points are left of the clouds at {:g} m; more than {} wanted",
                    to.size(), from.size(), options.voxel_m, options.neighbours));
  Gicp gicp;
  gicp.setInputTarget(points_of(to, origin));
  gicp.setInputSource(points_of(placed, origin));
  gicp.setMaxCorrespondenceDistance(options.max_distance_m);
  gicp.setCorrespondenceRandomness(options.neighbours);
  gicp.setMaximumIterations(options.max_iterations);
  Points moved;
  gicp.align(moved);
  if (report != nullptr) {
    *report = {};
    report->points = from.size();
    report->iterations = gicp.iterations();
    // PCL calls it converged when the iterations are used up, too.
    report->converged = gicp.hasConverged() && gicp.iterations() < options.max_iterations;
  }
  return in_map(gicp.getFinalTransformation(), origin, origin) * options.start;
}

std::vector<std::uint8_t> ground_by_pcl(const Cloud& cloud, const PclGroundOptions& options) {
  quiet();
  if (cloud.size() == 0) return {};
  const Points::Ptr points = points_of(cloud, middle_of(cloud));
  pcl::Indices ground;
  const auto run = [&](auto& filter, double cells_per_unit) {
    filter.setInputCloud(points);
    filter.setCellSize(static_cast<float>(options.cell_m));
    filter.setMaxWindowSize(
        std::max(1, static_cast<int>(std::lround(2.0 * options.max_window_m * cells_per_unit))));
    filter.setSlope(static_cast<float>(options.slope));
    filter.setInitialDistance(static_cast<float>(options.height_m));
    filter.setMaxDistance(static_cast<float>(std::max(options.max_height_m, options.height_m)));
    filter.extract(ground);
  };
  if (!options.approximate) {
    pcl::ProgressiveMorphologicalFilter<Point> filter;
    run(filter, 1.0);
    return marked(ground, cloud.size());
  }
  const auto [x0, x1] = std::minmax_element(cloud.x_m.begin(), cloud.x_m.end());
  const auto [y0, y1] = std::minmax_element(cloud.y_m.begin(), cloud.y_m.end());
  const double cells = ((*x1 - *x0) / options.cell_m + 1.0) * ((*y1 - *y0) / options.cell_m + 1.0),
               window = 2.0 * (2.0 * options.max_window_m / options.cell_m) + 1.0;
  if (cells * window * window > 4e10 || cells > 5e7)
    throw Error(fmt::format(
        "the points spread over {:.0f} x {:.0f} m: PCL's approximate filter works on every cell of "
        "{:g} m there, {:.3g} million; take points far away out, give a larger cell, or use our "
        "own "
        "method, which does not mind",
        *x1 - *x0, *y1 - *y0, options.cell_m, cells / 1e6));
  pcl::ApproximateProgressiveMorphologicalFilter<Point> filter;
  filter.setNumberOfThreads(1);  // more of them write to one cell at once
  run(filter, 1.0 / options.cell_m);
  return marked(ground, cloud.size());
}

std::vector<OctreeChange> octree_changes(const Cloud& before, const Cloud& after, double cube_m,
                                         std::size_t min_points) {
  quiet();
  if (before.size() == 0 || after.size() == 0) return {};
  const Eigen::Vector3d origin = middle_of(before);
  const Points::Ptr old_points = points_of(before, origin), new_points = points_of(after, origin);
  std::vector<OctreeChange> out;
  for (const bool appeared : {true, false})
    for (OctreeChange cube :
         appeared ? cubes_of_second_alone(old_points, new_points, cube_m, min_points)
                  : cubes_of_second_alone(new_points, old_points, cube_m, min_points)) {
      cube.x_m += origin.x(), cube.y_m += origin.y(), cube.z_m += origin.z();
      cube.appeared = appeared;
      out.push_back(cube);
    }
  return out;
}

}  // namespace cloud
