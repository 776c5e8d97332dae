#include "cloud/ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <tuple>

#include "cloud/read_cloud.h"
#include "support/places.h"

namespace cloud {
namespace {

TEST(Ground, TakesABoxOffASlope) {
  Cloud cloud;
  std::vector<bool> on_box;
  for (int i = 0; i < 120; ++i)
    for (int j = 0; j < 120; ++j) {
      const double x = 0.5 * i, y = 0.5 * j;
      const bool box = x > 20 && x < 32 && y > 20 && y < 28;
      cloud.x_m.push_back(x), cloud.y_m.push_back(y),
          cloud.z_m.push_back(0.05 * x + (box ? 4.0 : 0.0));
      on_box.push_back(box);
    }
  const std::vector<std::uint8_t> ground = classify_ground(cloud);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < ground.size(); ++i) wrong += (ground[i] != 0) == on_box[i] ? 1 : 0;
  EXPECT_LT(wrong, ground.size() / 200);
  EXPECT_TRUE(classify_ground(Cloud{}).empty());
}

TEST(RealClouds, GroundOfSamp11) {
  const std::string folder = places::data() + "/lidar/";
  if (!std::ifstream(folder + "samp11-utm.pcd")) GTEST_SKIP() << "no ../shared/data";
  const Cloud all = read_cloud(folder + "samp11-utm.pcd"),
              labelled = read_cloud(folder + "samp11-utm-ground.pcd");
  std::map<std::tuple<double, double, double>, int> wanted;
  const auto key = [](const Cloud& c, std::size_t i) {
    return std::tuple(c.origin_m.x() + c.x_m[i], c.origin_m.y() + c.y_m[i],
                      c.origin_m.z() + c.z_m[i]);
  };
  for (std::size_t i = 0; i < labelled.size(); ++i) ++wanted[key(labelled, i)];
  const std::vector<std::uint8_t> ground = classify_ground(all);
  std::size_t wrong = 0, labels = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    int& left = wanted[key(all, i)];
    const bool is_ground = left > 0;
    left -= is_ground ? 1 : 0;
    labels += is_ground ? 1 : 0;
    wrong += is_ground != (ground[i] != 0) ? 1 : 0;
  }
  EXPECT_EQ(labels, labelled.size());
  EXPECT_LT(static_cast<double>(wrong) / static_cast<double>(all.size()), 0.12);  // measured 0.093
}

}  // namespace
}  // namespace cloud
