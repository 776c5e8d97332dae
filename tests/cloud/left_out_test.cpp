// What points scatter by their range, and what one pass left out says of stated deviations.
#include "left_out.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "cloud/error.h"
#include "cloud/synth.h"
#include "support/lidar_trial.h"
#include "support/temporary_folder.h"

namespace cloud {
namespace left_out_test {

TEST(NodeHeight, PointsScatterByTheirRange) {
  base::Random random(3);
  NodeSums sums(40, 1000);
  const auto stddev_m = [](double range_m) { return 0.009 / range_m; };
  for (std::size_t k = 0; k < 40'000; ++k) {
    const double range_m = k % 4 == 0 ? 4.5 : k % 4 == 1 ? 9.0 : k % 4 == 2 ? 18.0 : 36.0;
    const auto range = static_cast<std::uint8_t>(range_class(range_m));
    const int points = k % 3 == 0 ? 1 : 2;
    for (int i = 0; i < points; ++i) {
      double height_m = 0.03 + stddev_m(range_m) * random.normal();
      if (k % 101 == 1) height_m += 0.05 * random.uniform();  // a hundredth is wild
      sums.filled(k).add(static_cast<float>(height_m), range);
    }
  }
  const Noise noise = noise_of(sums);
  // Within 6 % of a class's own; its wild ones widen nine of ten pairs by some 3 %.
  for (const double range_m : {4.5, 9.0, 18.0, 36.0})
    EXPECT_NEAR(std::sqrt(noise.few_m2[range_class(range_m)]) / stddev_m(range_m), 1.02, 0.06)
        << range_m;
  // A class without pairs takes the nearest one's.
  EXPECT_EQ(noise.few_m2[range_class(1.5)], noise.few_m2[range_class(4.5)]);
  EXPECT_EQ(noise.few_m2[range_class(80.0)], noise.few_m2[range_class(36.0)]);
  PartSum one;
  one.points = 1.0, one.height = 0.03, one.height2 = 0.0009;
  one.range = static_cast<double>(range_class(9.0));
  EXPECT_NEAR(std::sqrt(measured(one, noise).variance), 0.001, 0.0001);
}

crg::Crg plane(int rows) {
  crg::ReferenceLine line;
  line.u_step_m = 0.2;
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  for (int j = -5; j <= 5; ++j) grid.v_m.push_back(0.2 * j);
  for (int i = 0; i < rows; ++i)
    line.x_m.push_back(0.2 * i), line.y_m.push_back(0.0), line.heading_rad.push_back(0.0);
  grid.z_m.assign(line.x_m.size() * grid.v_m.size(), 0.0f);
  return crg::make_crg(line, grid);
}

/// Where stripes are the same, sums are to the bit.
void expect_same(const NodeSums& a, const NodeSums& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].points, b[k].points) << k;
    EXPECT_EQ(a[k].height, b[k].height) << k;
    EXPECT_EQ(a[k].height2, b[k].height2) << k;
    EXPECT_EQ(a[k].range, b[k].range) << k;
  }
}

TEST(RoadSums, PartsMakeTheWhole) {
  const RoadFrame frame(plane(201));
  Drift drift;  // of stretches of 10 m: the second leaves out no pass, the last pass 1
  for (const int pass : {0, -1, 1, 1}) drift.apart.push_back({pass, {}});
  RoadSums whole(frame, drift), first(frame, drift), second(frame, drift);
  EXPECT_EQ(whole.left_out.size(), 26 * frame.columns());
  EXPECT_EQ(whole.all.stripes(), whole.left_out.stripes());
  base::Random random(5);
  for (int k = 0; k < 40'000; ++k) {
    // Rows 64 to 127 are seen by none; heights whose sums have no rounding.
    const std::size_t row = random.below(2) == 0 ? random.below(64) : 128 + random.below(73),
                      node = row * frame.columns() + random.below(frame.columns());
    const int pass = static_cast<int>(random.below(2));
    const auto height_m = static_cast<float>(random.below(64)) / 1024.0f;
    const auto range = static_cast<std::uint8_t>(random.below(kRanges));
    for (RoadSums* sums : {&whole, random.below(3) == 0 ? &first : &second})
      sums->add(node, pass, height_m, range), ++sums->read, ++sums->used;
  }
  const auto seen = [&](std::size_t row, const NodeSums& sums) {
    float points = 0.0f;
    for (std::size_t j = 0; j < frame.columns(); ++j)
      points += sums[row * frame.columns() + j].points;
    return points;
  };
  EXPECT_GT(seen(0, whole.left_out), 0.3f * seen(0, whole.all));
  EXPECT_LT(seen(0, whole.left_out), 0.7f * seen(0, whole.all));
  EXPECT_EQ(seen(7, whole.left_out), 0.0f);  // row 56: of the second stretch
  EXPECT_EQ(seen(8, whole.left_out), 0.0f);  // row 64
  EXPECT_TRUE(first.all.stripe(1).empty());
  EXPECT_TRUE(first.left_out.stripe(1).empty());
  EXPECT_GT(seen(24, whole.left_out), 0.0f);  // row 192
  RoadSums joined(frame, drift);
  joined.add(first), joined.add(second);
  expect_same(joined.all, whole.all);
  expect_same(joined.left_out, whole.left_out);
  EXPECT_EQ(joined.used, whole.used);

  const RoadSums nowhere(frame, Drift{});
  EXPECT_EQ(nowhere.left_out.size(), 0u);
  EXPECT_THROW(joined.add(nowhere), Error);
  EXPECT_THROW(joined.add(RoadSums(RoadFrame(plane(200)), drift)), Error);
}

struct Shifted {
  MapReport report;
  double within_90 = 0.0;
};

/// Two drives; each shows cells of 0.4 m, each for itself, higher or lower by up to so much.
Shifted refine(double shift_m) {
  const support::TemporaryFolder folder;
  const support::TrialRoads roads = support::trial_roads(0.2);
  ScanSynthOptions options;
  options.u_begin_m = 560.0, options.u_end_m = 720.0, options.azimuths = 128, options.cars = 0;
  const ScanSynthReport made = synth_scans(roads.truth, folder.path("scans"), options);
  const Trajectory trajectory = read_trajectory(made.trajectory_path),
                   truth = read_trajectory(made.truth_path);
  std::size_t hint = 0;
  const CloudSource source = [&](const ChunkSink& sink) {
    for (const std::string& path : made.scan_paths)
      read_chunks(path, {}, [&](Cloud&& chunk) {
        PosedInstant pose;
        for (std::size_t i = 0; i < chunk.size(); ++i) {
          if (!pose_at(truth, chunk.time_s[i], hint, pose)) continue;
          const Eigen::Vector3d p =
              pose.position_m + pose.orientation * (chunk.origin_m + chunk.point(i));
          const auto cell = [](double x_m) {
            return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x_m / 0.4)));
          };
          base::Random of_cell(cell(p.x()) * 1'000'003 + cell(p.y()) * 29 +
                               static_cast<std::uint64_t>(truth.piece[hint]));
          chunk.z_m[i] += shift_m * (2.0 * of_cell.uniform() - 1.0);
        }
        sink(std::move(chunk));
      });
  };
  const MapResult result = map_clouds(source, roads.truth, &trajectory);
  return {
      result.report,
      support::measure_trial({roads.truth, roads.truth}, result, truth, 580.0, 700.0).within_90};
}

// What a node's points have in common in each pass does not show in their scatter.
TEST(SlowLeftOut, OnePassTellsWhatScatterDoesNot) {
  const Shifted plain = refine(0.0), shifted = refine(0.002);
  std::printf(
      "held %.1f %%, times %.2f, against the truth %.1f %%; shifted %.1f %%, %.2f, %.1f %%\n",
      100.0 * plain.report.left_out_within_90, plain.report.noise_factor, 100.0 * plain.within_90,
      100.0 * shifted.report.left_out_within_90, shifted.report.noise_factor,
      100.0 * shifted.within_90);
  EXPECT_GT(plain.report.left_out_nodes, 5000u);
  EXPECT_GT(plain.report.left_out_within_90, 0.86);
  EXPECT_LT(plain.report.left_out_within_90, 0.97);
  EXPECT_LT(plain.report.noise_factor, 1.1);
  EXPECT_GT(plain.within_90, 0.85);
  EXPECT_LT(plain.within_90, 0.95);
  EXPECT_LT(shifted.report.left_out_within_90, 0.85);
  EXPECT_GT(shifted.report.noise_factor, 1.2);
  EXPECT_GT(shifted.within_90, 0.85);
  EXPECT_LT(shifted.within_90, 0.95);
}

}  // namespace left_out_test
}  // namespace cloud
