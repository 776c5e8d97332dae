// Nodes of a base that err each by itself.
#include "base_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "support/kerbed_road.h"

namespace cloud {
namespace base_noise_test {

constexpr double kRough_m = 0.01;

crg::Crg rough(crg::Crg base) {
  base::Random random(99);
  for (float& z_m : base.grid.z_m) z_m += static_cast<float>(kRough_m * random.normal());
  return base;
}

// What the points show over it tells whether the road is as rough itself.
TEST(BaseNoise, IsWhatTheRoadDoesNotHave) {
  const support::KerbedRoad road;
  const crg::Grid smooth = road.base().grid, base = rough(road.base()).grid;
  const std::size_t columns = base.columns();
  const auto mean_m = [&](std::size_t k) {  // about a node, of what a base of noise has too much
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        const std::size_t n = k + i * columns + j - columns - 1;
        sum += (i == 1 ? 0.75 : 0.125) * (j == 1 ? 0.75 : 0.125) *
               static_cast<double>(base.z_m[n] - smooth.z_m[n]);
      }
    return sum;
  };
  const auto inside = [&](std::size_t k) {
    return k % columns > 0 && k % columns + 1 < columns && k > columns &&
           k + columns + 1 < base.z_m.size();
  };
  const BaseNoise noise(base, false, [&](std::size_t k) { return inside(k) ? -mean_m(k) : NAN; });
  EXPECT_NEAR(noise.stddev_m(), kRough_m, 0.001);
  double left = 0.0, before = 0.0;
  for (std::size_t i = 10; i < 400; ++i) {
    const std::size_t k = i * columns + 80;
    const double error_m = static_cast<double>(base.z_m[k] - smooth.z_m[k]) - mean_m(k);
    before += error_m * error_m, left += std::pow(error_m - noise.over_mean_m(i, 80), 2);
  }
  EXPECT_LT(left, 0.01 * before);
  const BaseNoise right(base, false, [](std::size_t) { return 0.0; });
  EXPECT_EQ(right.stddev_m(), 0.0);
  EXPECT_EQ(right.over_mean_m(100, 80), 0.0);
}

// A half of it stayed in the road: 4.8 mm, 0.7 stated.
TEST(SlowBaseNoise, LeavesNothingInTheRoad) {
  support::KerbedRoad road;
  road.radius_m = 60.0;
  support::KerbedDrive drive;
  drive.seed = 4;
  const support::KerbedScans made = scans_of(road, drive);
  const MapResult result = map_clouds([&](const ChunkSink& sink) { sink(Cloud(made.points)); },
                                      rough(road.base()), &made.trajectory, MapOptions());
  const support::KerbedError seen = error_of(road, result);
  EXPECT_TRUE(result.report.faults.empty());
  EXPECT_LT(seen.road_rmse_m, 0.0015);
  EXPECT_GT(seen.tallies.road.share(), 0.85);
}

}  // namespace base_noise_test
}  // namespace cloud
