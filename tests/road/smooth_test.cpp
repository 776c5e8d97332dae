#include "road/smooth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mesh/error.h"

namespace smooth_test {

using road::Provenance;
using road::SurfaceClass;

/// A grid of 400 rows 0.1 m apart and 5 columns with z(u, column).
template <typename Height>
road::SampledGrid grid_of(const Height& z) {
  road::SampledGrid s;
  s.grid.u_step_m = 0.1;
  s.grid.v_m = {-2, -1, 0, 1, 2};
  for (int i = 0; i < 400; ++i) {
    for (int j = 0; j < 5; ++j) s.grid.z_m.push_back(static_cast<float>(z(0.1 * i, j)));
  }
  s.provenance.assign(s.grid.z_m.size(), Provenance::mesh);
  s.surface_class.assign(s.grid.z_m.size(), SurfaceClass::road);
  return s;
}

TEST(Smooth, KeepsAConstantSlopeAndDampsAWaveByItsKnownFactor) {
  // A moving average over n samples damps cos(k u) by sin(n k d / 2) / (n sin(k d / 2)).
  constexpr double kWave_m = 4.0;
  auto s = grid_of([](double u, int j) {
    return 0.05 * u + (j == 2 ? 0.001 * std::cos(2 * M_PI * u / kWave_m) : 0.0);
  });
  const auto before = s;
  smooth(s, {.window_u_m = 2.0, .max_change_road_m = 1.0});
  const double k = 2 * M_PI / kWave_m,
               damping = std::sin(21 * k * 0.05) / (21 * std::sin(k * 0.05));
  for (std::size_t i = 30; i < 370; ++i) {
    const double u = 0.1 * static_cast<double>(i);
    EXPECT_NEAR(s.grid.at(i, 0), 0.05 * u, 1e-6);
    EXPECT_NEAR(s.grid.at(i, 2), 0.05 * u + damping * 0.001 * std::cos(k * u), 1e-6);
  }
}

TEST(Smooth, IsOffByDefault) {
  auto s = grid_of([](double u, int) { return std::sin(40 * u); });
  const auto before = s.grid.z_m;
  smooth(s, {});
  EXPECT_EQ(s.grid.z_m, before);
}

TEST(Smooth, MovesNoNodeFurtherThanAllowedAndSaysHowFarItWent) {
  auto s = grid_of([](double u, int) { return std::abs(u - 20.0) < 0.25 ? 0.1 : 0.0; });
  const auto before = s.grid.z_m;
  road::SmoothReport report;
  smooth(s, {.window_u_m = 2.0, .max_change_road_m = 0.002}, &report);
  for (std::size_t k = 0; k < before.size(); ++k)
    EXPECT_LE(std::abs(s.grid.z_m[k] - before[k]), 0.002f + 1e-6f);
  EXPECT_NEAR(report.largest_change_road_m, 0.002, 1e-9);
  EXPECT_GT(report.nodes_at_bound, 0u);
}

TEST(Smooth, LeavesKerbsAloneAndDoesNotMixThemIntoTheRoad) {
  auto s = grid_of([](double u, int) { return u > 15 && u < 25 ? 0.08 : 0.0; });
  for (std::size_t i = 151; i < 250; ++i) {
    for (std::size_t j = 0; j < 5; ++j) s.surface_class[i * 5 + j] = SurfaceClass::kerb;
  }
  const auto before = s.grid.z_m;
  road::SmoothReport report;
  smooth(s, {.window_u_m = 2.0, .max_change_road_m = 1.0}, &report);
  EXPECT_EQ(report.largest_change_kerb_m, 0.0);
  for (std::size_t i = 0; i < 400; ++i) {
    if (i == 150 || i == 250) continue;  // the flank itself belongs to the road side here
    EXPECT_NEAR(s.grid.at(i, 0), before[i * 5], 1e-6) << i;
  }
}

TEST(Smooth, DoesNotReachAcrossAHole) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  auto s = grid_of([](double u, int) { return u < 20 ? 0.0 : 1.0; });
  for (std::size_t i = 198; i < 202; ++i) s.grid.at(i, 3) = nan;
  smooth(s, {.window_u_m = 4.0, .max_change_road_m = 10.0});
  for (std::size_t i = 0; i < 400; ++i) {
    if (i >= 198 && i < 202) {
      EXPECT_TRUE(std::isnan(s.grid.at(i, 3)));
    } else {
      EXPECT_EQ(s.grid.at(i, 3), i < 200 ? 0.0f : 1.0f) << i;
    }
  }
  EXPECT_GT(s.grid.at(195, 0), 0.1f) << "the column without a hole is averaged";
}

TEST(Smooth, GoesRoundAClosedRoad) {
  auto s = grid_of([](double u, int) { return 0.01 * std::cos(2 * M_PI * u / 39.9); });
  smooth(s, {.window_u_m = 3.0, .max_change_road_m = 1.0, .closed = true});
  for (std::size_t j = 0; j < 5; ++j) EXPECT_EQ(s.grid.at(0, j), s.grid.at(399, j));
  // An average over a symmetric window at the crest lies below it; a cut-off window would not.
  EXPECT_LT(s.grid.at(0, 0), 0.01f - 1e-5f);
}

TEST(Smooth, RefusesAWindowLongerThanTheTrack) {
  auto s = grid_of([](double, int) { return 0.0; });
  EXPECT_THROW(smooth(s, {.window_u_m = 100.0, .closed = true}), road::Error);
  EXPECT_THROW(smooth(s, {.window_u_m = -1.0}), road::Error);
}

/// A grid of 1001 rows 0.1 m apart and even columns of 0.05 m from -3 to 3 m with z(u, v).
template <typename Height>
road::SampledGrid wide_grid_of(const Height& z) {
  road::SampledGrid s;
  s.grid.u_step_m = 0.1;
  for (int j = -60; j <= 60; ++j) s.grid.v_m.push_back(0.05 * j);
  for (int i = 0; i < 1001; ++i) {
    for (const double v : s.grid.v_m) s.grid.z_m.push_back(static_cast<float>(z(0.1 * i, v)));
  }
  s.provenance.assign(s.grid.z_m.size(), Provenance::mesh);
  s.surface_class.assign(s.grid.z_m.size(), SurfaceClass::road);
  return s;
}

TEST(Smooth, AlongVKeepsAPlaneAndDampsAWaveByItsKnownFactor) {
  // The mean of cos(k v) over a window w is sin(k w / 2) / (k w / 2) times its middle.
  const double k = 2 * M_PI / 2.0, damping = std::sin(k * 0.5) / (k * 0.5);
  auto s = wide_grid_of(
      [&](double u, double v) { return u < 50 ? 0.03 * u + 0.02 * v : 0.001 * std::cos(k * v); });
  // Uneven columns, as kerbs make them.
  for (std::size_t j = 1; j + 1 < s.grid.columns(); j += 7) {
    const double v = s.grid.v_m[j] += 0.02;
    for (std::size_t i = 0; i < 1001; ++i) {
      const double u = 0.1 * static_cast<double>(i);
      s.grid.at(i, j) = static_cast<float>(u < 50 ? 0.03 * u + 0.02 * v : 0.001 * std::cos(k * v));
    }
  }
  smooth(s, {.window_v_m = 1.0, .max_change_road_m = 1.0});
  for (std::size_t i = 0; i < 1001; i += 10) {
    const double u = 0.1 * static_cast<double>(i);
    for (std::size_t j = 0; j < s.grid.columns(); ++j) {
      const double v = s.grid.v_m[j];
      if (u < 50) {
        EXPECT_NEAR(s.grid.at(i, j), 0.03 * u + 0.02 * v, 1e-6);
      } else if (std::abs(v) < 2.4) {
        EXPECT_NEAR(s.grid.at(i, j), damping * 0.001 * std::cos(k * v),
                    5e-6);  // straight between columns
      }
    }
  }
}

TEST(Smooth, AlongVKeepsKerbEdgesAndHoles) {
  auto s = wide_grid_of([](double, double v) { return v > 2.0 ? 0.08 : 0.0; });
  for (std::size_t i = 0; i < 1001; ++i) {
    for (std::size_t j = 0; j < s.grid.columns(); ++j)
      if (s.grid.v_m[j] > 2.0) s.surface_class[i * s.grid.columns() + j] = SurfaceClass::kerb;
    s.grid.at(i, 20) = std::numeric_limits<float>::quiet_NaN();
  }
  const auto before = s.grid.z_m;
  smooth(
      s,
      {.window_u_m = 1.0, .window_v_m = 2.0, .max_change_road_m = 1.0, .max_change_kerb_m = 1.0});
  for (std::size_t node = 0; node < before.size(); ++node) {
    ASSERT_EQ(std::isnan(s.grid.z_m[node]), std::isnan(before[node]));
    if (std::isnan(before[node])) continue;
    ASSERT_NEAR(s.grid.z_m[node], before[node], 1e-6);
  }
}

TEST(Smooth, SaysWhichWavesItTook) {
  // A bump per metre, as in a braking zone, on a long wave: a window of 1 m takes the first and
  // leaves the second.
  auto s = wide_grid_of([](double u, double) {
    return 0.001 * std::sin(2 * M_PI * u) + 0.01 * std::sin(2 * M_PI * u / 16);
  });
  road::SmoothReport report;
  smooth(s, {.window_u_m = 1.0, .max_change_road_m = 1.0}, &report);
  ASSERT_TRUE(report.halved_waves_m);
  EXPECT_LT(report.halved_waves_m->shortest_m, 1.0);
  EXPECT_GT(report.halved_waves_m->longest_m, 1.0);
  EXPECT_LT(report.halved_waves_m->longest_m, 3.0);
  for (const road::SmoothedBand& band : report.bands) {
    const double wave_m = 1.0 / band.n_cpm, left = band.after_m3 / band.before_m3;
    if (std::abs(wave_m - 16.0) < 2.0) {
      EXPECT_NEAR(left, 1.0, 0.05);
    }
    if (std::abs(wave_m - 1.0) < 0.1) {
      EXPECT_LT(left, 0.05);
    }
  }
}

}  // namespace smooth_test
