// Read back from the bytes, and compared with the formula that the road was made of.
#include "inspect/height_raster.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "crg/file.h"
#include "mesh/error.h"

namespace height_raster_test {

double hill(double x_m, double y_m) {
  return 300.0 + 6.0 * std::sin(x_m / 40.0) + 0.03 * y_m + 0.2 * std::cos(y_m / 9.0);
}

/// A bend of 60 m radius over a quarter of a turn, 12 m wide, with a hole in its left half.
crg::Surface bend(double x_m = 0.0, double hill_share = 1.0) {
  crg::ReferenceLine line;
  constexpr std::size_t kRows = 401;
  constexpr double kTurn = 0.5 * M_PI / (kRows - 1), kRadius_m = 60.0;
  for (std::size_t i = 0; i < kRows; ++i) {
    const double turn = kTurn * static_cast<double>(i);
    line.x_m.push_back(x_m + kRadius_m * std::sin(turn));
    line.y_m.push_back(kRadius_m * (1.0 - std::cos(turn)));
    line.heading_rad.push_back(i == 0 ? 0.0 : turn - 0.5 * kTurn);
  }
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 2.0 * kRadius_m * std::sin(0.5 * kTurn);
  for (int j = -24; j <= 24; ++j) grid.v_m.push_back(0.25 * j);
  for (std::size_t i = 0; i < kRows; ++i)
    for (const double v : grid.v_m) {
      const crg::Point2 p = crg::node_position(line, i, v);
      const bool hole = i > 150 && i < 200 && v > 1.0;
      grid.z_m.push_back(hole ? std::numeric_limits<float>::quiet_NaN()
                              : static_cast<float>(hill_share * hill(p.x_m - x_m, p.y_m)));
    }
  return crg::Surface(crg::make_crg(line, grid));
}

TEST(HeightRaster, SamplesAreTheRoadWithinAMillimetreAndNothingBesideIt) {
  const road::HeightRaster raster = road::height_raster(bend(), 0.25);
  EXPECT_EQ(raster.z_step_m, 1e-3);
  const std::string bytes = road::raw_bytes(raster);
  ASSERT_EQ(bytes.size(), 2 * raster.rows * raster.columns);
  std::size_t on_road = 0;
  for (std::size_t k = 0; k < raster.levels.size(); ++k) {
    const double x = raster.x_m + static_cast<double>(k % raster.columns) * 0.25,
                 y = raster.y_m - static_cast<double>(k / raster.columns) * 0.25;
    const int level = static_cast<unsigned char>(bytes[2 * k]) +
                      256 * static_cast<unsigned char>(bytes[2 * k + 1]);
    const double from_centre_m = std::hypot(x, y - 60.0), turn = std::atan2(x, 60.0 - y);
    const double v = 60.0 - from_centre_m, row = turn / (0.5 * M_PI) * 400.0;
    if (std::abs(v) > 6.01 || row < -0.5 || row > 400.5) {
      ASSERT_EQ(level, 0) << x << ", " << y;
    } else if (row > 151.0 && row < 199.0 && v > 1.01) {
      ASSERT_EQ(level, 0) << "the hole, " << x << ", " << y;
    } else if (std::abs(v) < 5.98 && row > 0.1 && row < 399.9 &&
               (row < 149.0 || row > 201.0 || v < 0.7)) {
      ++on_road;
      ASSERT_NEAR(raster.z_m + raster.z_step_m * level, hill(x, y), 1e-3) << x << ", " << y;
    }
  }
  EXPECT_NEAR(static_cast<double>(on_road), (60.0 * M_PI / 2.0 * 12.0 - 11.8 * 5.0) * 16.0, 400.0);
}

TEST(HeightRaster, WhatIsLostIsMeasured) {
  const crg::Surface road = bend();
  const road::RasterLoss fine = road::raster_loss(road::height_raster(road, 0.25), road),
                         coarse = road::raster_loss(road::height_raster(road, 2.0), road);
  EXPECT_LT(fine.between_samples_m, 1.5e-3);
  // Between samples 2 m apart cos(y / 9) of 0.2 m bends by up to a^2 / 8 * 0.2 / 81 a way.
  EXPECT_GT(coarse.between_samples_m, 1e-3);
  EXPECT_LT(coarse.between_samples_m, 0.01);
  EXPECT_LT(coarse.rms_m, coarse.between_samples_m);
  EXPECT_LT(fine.nodes_without, 0.1);
  EXPECT_GT(coarse.nodes_without, fine.nodes_without);
}

// A ramp of one turn and half a radian more, 6 m higher where it comes over its own beginning.
TEST(HeightRaster, WhatLiesAboveAnotherLegIsCountedAndIsNoError) {
  crg::ReferenceLine line;
  crg::Grid grid;
  constexpr std::size_t kRows = 801;
  constexpr double kTurn = (2.0 * M_PI + 0.5) / (kRows - 1), kRadius_m = 30.0;
  line.u_step_m = grid.u_step_m = 2.0 * kRadius_m * std::sin(0.5 * kTurn);
  for (int j = -8; j <= 8; ++j) grid.v_m.push_back(0.5 * j);
  for (std::size_t i = 0; i < kRows; ++i) {
    const double turn = kTurn * static_cast<double>(i);
    line.x_m.push_back(kRadius_m * std::sin(turn));
    line.y_m.push_back(kRadius_m * (1.0 - std::cos(turn)));
    line.heading_rad.push_back(i == 0 ? 0.0 : turn - 0.5 * kTurn);
    for (std::size_t j = 0; j < grid.v_m.size(); ++j)
      grid.z_m.push_back(static_cast<float>(0.95 * turn));
  }
  const crg::Surface road(crg::make_crg(line, grid));
  const road::RasterLoss loss = road::raster_loss(road::height_raster(road, 0.2), road);
  EXPECT_LT(loss.between_samples_m, 0.02);
  // Half a radian of 2 pi + 0.5 lies under or over another half.
  EXPECT_GT(loss.nodes_of_other_legs, 0.05);
  EXPECT_LT(loss.nodes_of_other_legs, 0.16);
}

TEST(HeightRaster, AMountainGetsTheLevelsThatThereAre) {
  const crg::Surface road = bend(0.0, 10.0);  // 120 m of it
  const road::HeightRaster raster = road::height_raster(road, 0.5);
  EXPECT_GT(raster.z_step_m, 1e-3);
  EXPECT_LT(raster.z_step_m, 2e-3);
  EXPECT_EQ(road::raster_loss(raster, road).at_samples_m, 0.5 * raster.z_step_m);
}

TEST(HeightRaster, LiesOnTheSameGridWhereverTheRoadIs) {
  const road::HeightRaster here = road::height_raster(bend(), 0.5),
                           there = road::height_raster(bend(512.0), 0.5);
  EXPECT_EQ(there.x_m - here.x_m, 512.0);
  EXPECT_EQ(std::fmod(here.x_m, 0.5), 0.0);
  EXPECT_EQ(here.columns, there.columns);
}

TEST(HeightRaster, TooManySamplesAreRefusedWithACellThatFits) {
  try {
    road::height_raster(bend(), 0.005);
    FAIL();
  } catch (const road::Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("give --step-m 0.0"));
  }
}

}  // namespace height_raster_test
