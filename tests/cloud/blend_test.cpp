// How the base runs into what was measured, on roads of a few nodes.
#include "blend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace cloud {
namespace blend_test {

constexpr int kRows = 161, kColumns = 81;
constexpr double kStep_m = 0.25;

/// Flat, straight, 40 m x 20 m.
crg::Crg flat_road() {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = kStep_m;
  for (int j = 0; j < kColumns; ++j) grid.v_m.push_back(kStep_m * (j - kColumns / 2));
  for (int i = 0; i < kRows; ++i) {
    line.x_m.push_back(kStep_m * i), line.y_m.push_back(0.0), line.heading_rad.push_back(0.0);
    grid.z_m.insert(grid.z_m.end(), kColumns, 0.0f);
  }
  return crg::make_crg(line, grid);
}

/// With `height_m(u, v)` where it is a number, which is measured.
template <typename Height>
MapResult blended(const Height& height_m) {
  const crg::Crg road = flat_road();
  MapResult result{road.grid, road.grid, road.grid, {}, {}};
  for (std::size_t i = 0; i < kRows; ++i)
    for (std::size_t j = 0; j < kColumns; ++j) {
      const double z_m = height_m(kStep_m * static_cast<double>(i), road.grid.v_m[j]);
      const bool is = std::isfinite(z_m);
      result.grid.at(i, j) = is ? static_cast<float>(z_m) : 0.0f;
      result.stddev.at(i, j) = is ? 0.001f : 0.02f;
      result.source.at(i, j) = static_cast<float>(is ? NodeSource::lidar : NodeSource::base);
    }
  blend(RoadFrame(road), road.grid, MapOptions(), result);
  return result;
}

/// Of all pairs of neighbours with one that was not measured, along and across.
double steepest_ramp(const MapResult& result) {
  double steepest = 0.0;
  const auto measured = [&](std::size_t i, std::size_t j) {
    return result.source.at(i, j) == static_cast<float>(NodeSource::lidar);
  };
  for (std::size_t i = 0; i + 1 < kRows; ++i)
    for (std::size_t j = 0; j + 1 < kColumns; ++j)
      for (const auto& [k, l] : {std::pair(i + 1, j), std::pair(i, j + 1)})
        if (!measured(i, j) || !measured(k, l))
          steepest = std::max(
              steepest,
              std::abs(static_cast<double>(result.grid.at(k, l) - result.grid.at(i, j))) / kStep_m);
  return steepest;
}

const double kNothing = std::nan("");

// Where the nearest measured node is another, neighbours lay 18 mm apart.
TEST(Blend, HasNoStepBetweenWhatDiffersFarApart) {
  const MapResult result = blended([](double u_m, double v_m) {
    if (std::abs(v_m) > 5.0) return kNothing;
    return u_m < 18.0 ? 0.03 : u_m > 22.0 ? 0.0 : kNothing;
  });
  EXPECT_LT(steepest_ramp(result), 0.0101);
  EXPECT_NEAR(static_cast<double>(result.grid.at(0, 12)), 0.018, 0.003);  // 2 m beside it
  for (std::size_t k = 0; k < result.grid.z_m.size(); ++k)
    EXPECT_GE(result.stddev.z_m[k],
              result.source.z_m[k] == static_cast<float>(NodeSource::lidar) ? 0.001f : 0.02f);
}

// Too near to each other for such a ramp: evenly from one to the other.
TEST(Blend, GoesStraightWhereItMustBeSteeper) {
  const MapResult result = blended([](double, double v_m) {
    return v_m < 0.1 ? 0.0 : v_m > 1.9 ? 0.08 : kNothing;
  });
  EXPECT_LT(steepest_ramp(result), 1.05 * 0.08 / 2.0);
}

}  // namespace blend_test
}  // namespace cloud
