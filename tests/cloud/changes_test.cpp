#include "cloud/changes.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "cloud/error.h"
#include "support/figure.h"

namespace cloud {
namespace changes_test {

struct Bump {
  double x, y, radius, height;
  bool flat;  ///< with steep sides; else round
};

double bump_height(const std::vector<Bump>& bumps, double x, double y) {
  double sum = 0.0;
  for (const Bump& b : bumps) {
    const double r = std::hypot(x - b.x, y - b.y) / b.radius;
    if (r < 1.0) sum += b.flat ? b.height : b.height * 0.5 * (1.0 + std::cos(3.14159265 * r));
  }
  return sum;
}

struct Campaign {
  std::uint32_t seed = 1;
  std::vector<Bump> bumps = {};
  double per_m2 = 400.0, noise_m = 0.005, drift_m = 0.0;  ///< the latter over 100 m
  bool grass = false, cars = false;
};

/// A road of 200 x 10 m with grade, crossfall and waves, seen once.
CloudSource seen(const Campaign& c) {
  return [c](const ChunkSink& sink) {
    std::mt19937 generator(c.seed);
    const auto uniform = [&] { return static_cast<double>(generator()) / 4294967296.0; };
    const auto normal = [&] {
      double sum = -6.0;
      for (int k = 0; k < 12; ++k) sum += uniform();
      return sum;
    };
    Cloud cloud;
    cloud.origin_m = Eigen::Vector3d(485000.0, 5429000.0, 300.0);
    const double phase = 6.28 * uniform();
    const auto count = static_cast<int>(2000.0 * c.per_m2);
    for (int k = 0; k < count; ++k) {
      const double x = 200.0 * uniform(), y = 10.0 * uniform() - 5.0;
      double z =
          0.03 * x + 0.025 * y + 0.02 * std::sin(0.9 * x) + 0.006 * std::sin(5.0 * x + 3.0 * y);
      z += bump_height(c.bumps, x, y) + c.noise_m * normal();
      z += 2.0 * c.drift_m * std::sin(0.02 * x + phase) + 0.04 * c.drift_m * y * std::cos(0.03 * x);
      if (c.grass && std::abs(y) > 4.0) z += 0.05 * uniform();
      // Cars that pass, of which a third of the points comes, and strays.
      if (c.cars && std::fmod(x, 60.0) < 5.0 && std::abs(y) < 1.0 && uniform() < 0.35)
        z += 0.3 + uniform();
      if (c.cars && uniform() < 0.002) z += 6.0 * uniform() - 2.0;
      cloud.x_m.push_back(x), cloud.y_m.push_back(y), cloud.z_m.push_back(z);
    }
    sink(std::move(cloud));
  };
}

std::vector<Bump> twelve(double height) {
  std::vector<Bump> bumps = {};
  for (int k = 0; k < 12; ++k)
    bumps.push_back({10.0 + 16.0 * k, -3.0 + 1.7 * (k % 4), 0.5 + 0.15 * (k % 5),
                     k % 2 == 0 ? height : -height, k % 3 == 0});
  return bumps;
}

void expect_found(const ChangeResult& result, const std::vector<Bump>& bumps) {
  std::size_t found = 0;
  for (const Bump& b : bumps)
    for (const ChangePlace& place : result.places)
      if (std::hypot(place.x_m - 485000.0 - b.x, place.y_m - 5429000.0 - b.y) < 0.4) {
        ++found;
        // A cell of 0.25 m is the mean of what a round bump of 0.5 m has there.
        EXPECT_NEAR(place.peak_change_m, b.height, 0.008) << b.x;
        EXPECT_NEAR(place.area_m2, 3.14159 * b.radius * b.radius,
                    0.7 * 3.14159 * b.radius * b.radius + 0.1)
            << b.x;
        EXPECT_FALSE(place.object);
      }
  EXPECT_EQ(found, bumps.size());
  EXPECT_EQ(result.places.size(), bumps.size());
}

TEST(SlowChanges, TwelveOfTwelveAndNothingElse) {
  const std::uint32_t seeds = std::getenv("KERBSTONE_HEAVY") != nullptr ? 20 : 1;
  for (std::uint32_t seed = 1; seed <= seeds; ++seed)
    for (const bool busy : {false, true}) {
      SCOPED_TRACE(fmt::format("seed {} {}", seed, busy));
      Campaign before{.seed = seed}, after{.seed = 100 + seed, .bumps = twelve(0.02)};
      if (busy)
        before.drift_m = after.drift_m = 0.02,
        before.grass = after.grass = before.cars = after.cars = true;
      const ChangeResult result = find_changes(seen(before), seen(after));
      EXPECT_EQ(result.cell_m, 0.25);
      expect_found(result, after.bumps);
      after.bumps.clear();
      const ChangeResult same = find_changes(seen(before), seen(after));
      EXPECT_EQ(same.places.size(), 0u);
      for (const ChangePlace& p : same.places)
        ADD_FAILURE() << fmt::format(
            "{:.2f} {:.2f}: {:.4f} of {:.4f}, {:.4f} of {:.4f} over {:.2f} m2", p.x_m - 485000.0,
            p.y_m - 5429000.0, p.change_m, p.stddev_m, p.peak_change_m, p.peak_stddev_m, p.area_m2);
      // Deviations are what they say where nothing changed.
      std::size_t inside = 0;
      for (const ChangeCell& cell : same.cells)
        inside += std::abs(cell.change_m) < 1.645 * cell.stddev_m ? 1 : 0;
      const double share = static_cast<double>(inside) / static_cast<double>(same.cells.size());
      support::figure_of_case("inside_percent", 100.0 * share);
      support::figure_of_case("places", static_cast<double>(result.places.size()));
      EXPECT_GT(share, 0.85);
      EXPECT_LT(share, 0.95);
    }
}

TEST(Changes, FewPointsMeanLargerCells) {
  Campaign before{.seed = 1, .per_m2 = 20.0}, after{.seed = 2, .per_m2 = 20.0};
  after.bumps = {{60.0, 0.0, 2.5, 0.02, true}};
  const ChangeResult result = find_changes(seen(before), seen(after));
  EXPECT_EQ(result.cell_m, 1.0);
  ASSERT_EQ(result.places.size(), 1u);
  EXPECT_NEAR(result.places[0].change_m, 0.02, 0.005);
}

// Said of thin clouds: 4.2 deviations, which half of the places of two cells stay below by chance.
TEST(Changes, WhatIsSaidToBeToldIsTold) {
  double places = 0.0, told = 0.0;
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    const Campaign before{.seed = seed, .per_m2 = 20.0}, after{.seed = 100 + seed, .per_m2 = 20.0};
    const ChangeResult same = find_changes(seen(before), seen(after));
    ASSERT_EQ(same.cell_m, 1.0);
    // Raised by just that: two cells in every eighth row, y from -2 to 0 m.
    const auto raised = [](double x, double y) {
      return std::fmod(std::floor(x), 8.0) == 4.0 && y >= -2.0 && y < 0.0;
    };
    const CloudSource higher = [&](const ChunkSink& sink) {
      seen(after)([&](Cloud&& cloud) {
        for (std::size_t k = 0; k < cloud.size(); ++k)
          if (raised(cloud.x_m[k], cloud.y_m[k])) cloud.z_m[k] += same.smallest_told_m;
        sink(std::move(cloud));
      });
    };
    const ChangeResult result = find_changes(seen(before), higher);
    const double good = same.smallest_told_m / 5.0;
    for (double x = 4.0; x < 200.0; x += 8.0) {
      int cells = 0;
      for (const ChangeCell& cell : result.cells)
        cells += std::floor(cell.x_m - 485000.0) == x && std::abs(cell.y_m - 5428999.0) < 1.0 &&
                         cell.stddev_m < good
                     ? 1
                     : 0;
      if (cells != 2) continue;
      places += 1.0;
      for (const ChangePlace& place : result.places)
        if (std::abs(place.x_m - 485000.5 - x) < 0.6 && std::abs(place.y_m - 5428999.0) < 0.6) {
          told += 1.0;
          break;
        }
    }
  }
  std::printf("%.0f of %.0f\n", told, places);
  EXPECT_GT(places, 15.0);
  EXPECT_GT(told, 0.85 * places);
}

TEST(Changes, SlowDifferencesAreTakenOutAndSaid) {
  Campaign before{.seed = 1, .per_m2 = 200.0}, after{.seed = 2, .per_m2 = 200.0, .drift_m = 0.05};
  const ChangeResult result = find_changes(seen(before), seen(after));
  EXPECT_TRUE(result.places.empty());
  EXPECT_THAT(result.remarks, ::testing::Contains(::testing::HasSubstr("differ slowly")));
  ChangeOptions kept;
  kept.level_m = 0.0;
  EXPECT_FALSE(find_changes(seen(before), seen(after), kept).places.empty());
}

TEST(Changes, SomethingThatStandsThereIsNoChangeOfTheSurface) {
  Campaign before{.seed = 1, .per_m2 = 200.0}, after{.seed = 2, .per_m2 = 200.0};
  after.bumps = {{60.0, 0.0, 2.0, 1.4, true}};
  const ChangeResult result = find_changes(seen(before), seen(after));
  ASSERT_EQ(result.places.size(), 1u);
  EXPECT_TRUE(result.places[0].object);
}

TEST(Changes, CloudsThatDoNotMeetAreRefused) {
  const Campaign one{.seed = 1, .per_m2 = 40.0};
  const CloudSource far = [&](const ChunkSink& sink) {
    seen(one)([&](Cloud&& cloud) {
      cloud.origin_m.x() += 5000.0;
      sink(std::move(cloud));
    });
  };
  EXPECT_THAT([&] { find_changes(seen(one), far); },
              ::testing::ThrowsMessage<cloud::Error>(::testing::AllOf(
                  ::testing::HasSubstr("0 cells of"), ::testing::HasSubstr("490000"))));
}

}  // namespace changes_test
}  // namespace cloud
