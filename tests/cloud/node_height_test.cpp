// What the nodes around a node say of it.
#include "node_height.h"

#include <gtest/gtest.h>

namespace cloud {
namespace node_height_test {

constexpr std::size_t kRows = 5, kColumns = 5;

/// Four points in each node that `slope` gives the height of, m per column.
NodeSums sloping(double slope, std::size_t last_column) {
  NodeSums sums(kRows, kColumns);
  for (std::size_t i = 0; i < kRows; ++i)
    for (std::size_t j = 0; j <= last_column; ++j)
      for (const float noise_m : {-0.001f, 0.001f, -0.001f, 0.001f})
        sums.filled(i * kColumns + j)
            .add(static_cast<float>(slope * static_cast<double>(j)) + noise_m, 0);
  return sums;
}

RoadFrame flat_frame() {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 0.25;
  for (std::size_t j = 0; j < kColumns; ++j) grid.v_m.push_back(0.125 * static_cast<double>(j));
  for (std::size_t i = 0; i < kRows; ++i) {
    line.x_m.push_back(0.25 * static_cast<double>(i)), line.y_m.push_back(0.0);
    line.heading_rad.push_back(0.0);
    grid.z_m.insert(grid.z_m.end(), kColumns, 0.0f);
  }
  return RoadFrame(crg::make_crg(line, grid));
}

NodeHeight around(const NodeSums& sums, std::size_t row, std::size_t column) {
  return between_neighbours(sums, row, column, flat_frame(), 1.0f, noise_of(sums), {});
}

// Points of a kerb's crest are a column wide: where some miss, a plane went down to its foot.
TEST(NodeHeight, GapsInACrestLieOnItsLineAlongTheRoad) {
  NodeSums sums = sloping(0.0, kColumns - 1);
  for (std::size_t i = 0; i < kRows; ++i)
    for (int k = 0; k < 4; ++k) sums.filled(i * kColumns + 2).height += 0.03f;
  sums.filled(2 * kColumns + 2) = {};
  const NodeHeight along = along_column(sums, 2, 2, flat_frame(), 1.0f, noise_of(sums), {});
  EXPECT_NEAR(along.mean, 0.03, 0.001);
  EXPECT_LT(std::sqrt(along.variance), 0.002);
  EXPECT_EQ(better(around(sums, 2, 2), along).mean, along.mean);
  sums.filled(3 * kColumns + 2) = sums.filled(4 * kColumns + 2) = {};
  EXPECT_EQ(along_column(sums, 2, 2, flat_frame(), 1.0f, noise_of(sums), {}).source,
            NodeSource::base);
}

// The mean of those on one side was half a column's slope off: ramps of 1 % beside gaps.
TEST(NodeHeight, GapsLieOnThePlaneOfThoseAround) {
  NodeSums sums = sloping(0.002, 2);
  sums.filled(2 * kColumns + 2) = {};
  const NodeHeight gap = around(sums, 2, 2);
  EXPECT_EQ(gap.source, NodeSource::interpolated);
  EXPECT_NEAR(gap.mean, 0.004, 0.0003);
  EXPECT_LT(gap.variance, 0.002 * 0.002);
  EXPECT_EQ(around(sums, 2, 4).source, NodeSource::base);
}

// Two columns have a plane, whatever step lies between them: on which side the node lies they do
// not tell. Of a step of 6 mm it is half way, and as uncertain.
TEST(NodeHeight, AStepBetweenColumnsIsNotKnownToAPoint) {
  for (const float step_m : {0.025f, 0.006f}) {
    NodeSums sums = sloping(0.0, 1);
    for (std::size_t i = 0; i < kRows; ++i) sums.filled(i * kColumns + 3).add(step_m, 0);
    const NodeHeight gap = around(sums, 2, 2);
    if (step_m > 0.02f) {
      EXPECT_EQ(gap.source, NodeSource::base);
      continue;
    }
    EXPECT_NEAR(gap.mean, 0.003, 0.001);
    EXPECT_GT(gap.variance, 0.0015 * 0.0015);
  }
}

// A drop of rain 15 mm above the road stayed, and was stated to 1.4 mm.
TEST(NodeHeight, ASinglePointAboveThoseAroundIsNoGround) {
  NodeSums sums = sloping(0.002, 4);
  NodeSum& drop = sums.filled(2 * kColumns + 2);
  drop = {};
  drop.add(0.029f, 0);
  const Noise noise = noise_of(sums);
  EXPECT_TRUE(is_wild(measured(drop, noise), around(sums, 2, 2)));
  EXPECT_NEAR(around(sums, 2, 1).mean, 0.002, 0.0003);  // nor does it count beside
  EXPECT_FALSE(is_wild(measured(sums[3 * kColumns + 3], noise), around(sums, 3, 3)));
  drop = {};
  drop.add(0.006f, 0);
  const NodeHeight own = measured(drop, noise), both = together(own, around(sums, 2, 2));
  EXPECT_EQ(both.source, NodeSource::lidar);
  EXPECT_LT(both.variance, own.variance);
  EXPECT_NEAR(both.mean, 0.004, 0.0015);
}

}  // namespace node_height_test
}  // namespace cloud
