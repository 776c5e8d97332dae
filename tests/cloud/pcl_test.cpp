#include "cloud/pcl.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <map>
#include <numbers>
#include <tuple>

#include "cloud/error.h"
#include "cloud/filter.h"
#include "cloud/ground.h"
#include "cloud/read_cloud.h"
#include "support/figure.h"
#include "support/places.h"
#include "support/street_scan.h"

namespace cloud {
namespace pcl_test {

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

using SlowPcl = Pcl;

TEST_F(SlowPcl, ScansFortyDegreesAndThreeMetresApartAreRegisteredWithoutAGuess) {
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
              ThrowsMessage<cloud::Error>(HasSubstr("not flat around")));
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation().z() = 2.0;
  const Cloud street = support::scan_street(pose, 1, 1);
  Cloud heap;  // nothing but scattered points
  for (std::size_t i = 0; i < 20000; ++i)
    add(heap, 0.003 * static_cast<double>((i * 7919) % 20011),
        0.003 * static_cast<double>((i * 104729) % 20011),
        0.001 * static_cast<double>((i * 1299709) % 5003));
  EXPECT_THAT([&] { coarse_start(street, heap); },
              ThrowsMessage<cloud::Error>(HasSubstr("no start without a guess")));
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
              ThrowsMessage<cloud::Error>(HasSubstr("points far away")));
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

// Prints its tables; docs/evidence.md has their means.
class Compared : public Pcl {
 protected:
  void SetUp() override {
    Pcl::SetUp();
    if (std::getenv("KERBSTONE_HEAVY") == nullptr) GTEST_SKIP() << "KERBSTONE_HEAVY=1 wanted";
  }
};

/// Of the processor, all threads together.
template <typename Work>
double seconds(const Work& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Share of the points that are ground by hand and not here, or the other way round.
double total_error(const Cloud& all, const Cloud& labelled,
                   const std::vector<std::uint8_t>& ground) {
  const auto key = [](const Cloud& c, std::size_t i) {
    const Eigen::Vector3d p = c.origin_m + c.point(i);
    return std::tuple(p.x(), p.y(), p.z());
  };
  std::map<std::tuple<double, double, double>, int> wanted;
  for (std::size_t i = 0; i < labelled.size(); ++i) ++wanted[key(labelled, i)];
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    int& left = wanted[key(all, i)];
    wrong += (left > 0) != (ground[i] != 0) ? 1 : 0;
    left -= left > 0 ? 1 : 0;
  }
  return static_cast<double>(wrong) / static_cast<double>(all.size());
}

TEST_F(Compared, GroundOfTheIsprsSamples) {
  const std::string folder = places::data() + "/lidar/isprs/";
  if (!std::ifstream(folder + "samp11-utm.pcd")) GTEST_SKIP() << "no ../shared/data";
  std::array<double, 4> sums{};
  fmt::print("sample: own; own, outliers 20 3 out before; pmf; pmf-grid: total error, seconds\n");
  for (const char* name :
       {"samp11", "samp12", "samp22", "samp31", "samp42", "samp51", "samp61", "samp71"}) {
    const Cloud all = read_cloud(folder + name + "-utm.pcd"),
                labelled = read_cloud(folder + name + "-utm-ground.pcd");
    fmt::print("{}", name);
    for (std::size_t method = 0; method < 4; ++method) {
      std::vector<std::uint8_t> ground;
      const double time_s = seconds([&] {
        PclGroundOptions options;
        options.approximate = method == 3;
        if (method >= 2) {
          ground = ground_by_pcl(all, options);
          return;
        }
        const std::vector<std::uint8_t> kept = method == 1
                                                   ? statistical_inliers(all, 20, 3.0)
                                                   : std::vector<std::uint8_t>(all.size(), 1);
        Cloud left;
        left.origin_m = all.origin_m;
        for (std::size_t i = 0; i < all.size(); ++i)
          if (kept[i] != 0) add(left, all.x_m[i], all.y_m[i], all.z_m[i]);
        const std::vector<std::uint8_t> found = classify_ground(left);
        std::size_t at = 0;
        for (std::size_t i = 0; i < all.size(); ++i)
          ground.push_back(kept[i] != 0 ? found[at++] : 0);
      });
      if (method == 0) {
        EXPECT_LT(time_s, 0.3) << name;
      }
      const double error = total_error(all, labelled, ground);
      sums[method] += error / 8.0;
      fmt::print("; {:.2f} %, {:.2f} s", 100.0 * error, time_s);
    }
    fmt::print("\n");
  }
  support::figure("pmf_percent", 100.0 * sums[2]);
  EXPECT_LT(sums[0], 0.035);
  EXPECT_LT(sums[0], sums[2]);
}

TEST_F(Compared, Registration) {
  struct Case {
    std::string name = {};
    Cloud target = {}, source = {};
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    bool apart = false;
  };
  std::vector<Case> cases;
  const std::string folder = places::data() + "/lidar/";
  if (std::ifstream truth(folder + "street_T_target_source.txt"); truth) {
    Case street{.name = "street pair",
                .target = read_cloud(folder + "street_target.ply"),
                .source = read_cloud(folder + "street_source.ply")};
    for (int i = 0; i < 16; ++i) truth >> street.T.matrix()(i / 4, i % 4);
    cases.push_back(street);
    street.name = "street pair, 40 degrees and 3 m off", street.apart = true;
    Eigen::Isometry3d off = apart();
    for (std::size_t i = 0; i < street.source.size(); ++i) {
      const Eigen::Vector3d p = off * street.source.point(i);
      street.source.x_m[i] = p.x(), street.source.y_m[i] = p.y(), street.source.z_m[i] = p.z();
    }
    street.T = street.T * off.inverse();
    cases.push_back(street);
  }
  Eigen::Isometry3d first = Eigen::Isometry3d::Identity();
  first.translation() = Eigen::Vector3d(0.0, -1.5, 1.9);
  for (const std::uint32_t scene : {11u, 12u})
    cases.push_back({.name = fmt::format("own scans {}, 40 degrees and 3 m off", scene),
                     .target = support::scan_street(first, scene, 1),
                     .source = support::scan_street(first * apart(), scene, 2),
                     .T = apart(),
                     .apart = true});
  for (const Case& c : cases) {
    fmt::print("{}\n", c.name);
    const auto tell = [&](const char* method, const Eigen::Isometry3d& T, double time_s) {
      const double off_m = (T.translation() - c.T.translation()).norm(),
                   off_deg = Eigen::AngleAxisd(T.linear().transpose() * c.T.linear()).angle() *
                             180.0 / std::numbers::pi;
      fmt::print("  {}: {:.1f} mm, {:.3f} degrees, {:.2f} s\n", method, 1e3 * off_m, off_deg,
                 time_s);
      return std::pair(off_m, off_deg);
    };
    RegisterOptions options;
    options.voxel_m = 0.1;
    if (c.apart) {
      const double time_s = seconds([&] { options.start = coarse_start(c.target, c.source); });
      tell("coarse start", options.start, time_s);
    }
    Eigen::Isometry3d T;
    double own_s = 1e9, gicp_s = 1e9;  // the best of five
    for (int k = 0; k < 5; ++k) {
      own_s = std::min(own_s, seconds([&] { T = register_clouds(c.target, c.source, options); }));
      gicp_s = std::min(gicp_s, seconds([&] { register_by_gicp(c.target, c.source, options); }));
    }
    const auto [off_m, off_deg] = tell("own", T, own_s);
    EXPECT_LT(off_m, 0.02);
    EXPECT_LT(off_deg, 0.1);
    const double best_s = own_s;
    options.robust = true;
    own_s = seconds([&] { T = register_clouds(c.target, c.source, options); });
    tell("robust", T, own_s);
    options.robust = false;
    const auto [gicp_m, gicp_deg] =
        tell("gicp", register_by_gicp(c.target, c.source, options), gicp_s);
    // Where it gets there: it stops early elsewhere.
    if (gicp_m < 0.02 && gicp_deg < 0.1) {
      EXPECT_LT(best_s, gicp_s);
    }
    Cloud target, source;
    const auto without = [](const Cloud& cloud) {
      const std::vector<std::uint8_t> kept = statistical_inliers(cloud, 20, 2.0);
      Cloud out;
      out.origin_m = cloud.origin_m;
      for (std::size_t i = 0; i < cloud.size(); ++i)
        if (kept[i] != 0) add(out, cloud.x_m[i], cloud.y_m[i], cloud.z_m[i]);
      return out;
    };
    const double outliers_s =
        seconds([&] { target = without(c.target), source = without(c.source); });
    own_s = seconds([&] { T = register_clouds(target, source, options); });
    tell("own, --outliers 20 2", T, outliers_s + own_s);
    tell("gicp, --outliers 20 2", register_by_gicp(target, source, options), outliers_s + gicp_s);
    const double thin_s = seconds([&] { source = voxel_means(c.source, 0.1); });
    fmt::print("  voxel grid: {} of {} points left, {:.3f} s\n", source.size(), c.source.size(),
               thin_s);
  }
}

}  // namespace pcl_test
}  // namespace cloud
