#include "road/smooth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "road/error.h"

namespace {

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
  auto s = grid_of([](double u, int j) { return 0.05 * u + (j == 2 ? 0.001 * std::cos(2 * M_PI * u / kWave_m) : 0.0); });
  const auto before = s;
  smooth(s, {.window_m = 2.0, .max_change_road_m = 1.0});
  const double k = 2 * M_PI / kWave_m, damping = std::sin(21 * k * 0.05) / (21 * std::sin(k * 0.05));
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
  smooth(s, {.window_m = 2.0, .max_change_road_m = 0.002}, &report);
  for (std::size_t k = 0; k < before.size(); ++k) EXPECT_LE(std::abs(s.grid.z_m[k] - before[k]), 0.002f + 1e-6f);
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
  smooth(s, {.window_m = 2.0, .max_change_road_m = 1.0}, &report);
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
  smooth(s, {.window_m = 4.0, .max_change_road_m = 10.0});
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
  smooth(s, {.window_m = 3.0, .max_change_road_m = 1.0, .closed = true});
  for (std::size_t j = 0; j < 5; ++j) EXPECT_EQ(s.grid.at(0, j), s.grid.at(399, j));
  // An average over a symmetric window at the crest lies below it; a cut-off window would not.
  EXPECT_LT(s.grid.at(0, 0), 0.01f - 1e-5f);
}

TEST(Smooth, RefusesAWindowLongerThanTheTrack) {
  auto s = grid_of([](double, int) { return 0.0; });
  EXPECT_THROW(smooth(s, {.window_m = 100.0, .closed = true}), road::Error);
  EXPECT_THROW(smooth(s, {.window_m = -1.0}), road::Error);
}

}  // namespace
