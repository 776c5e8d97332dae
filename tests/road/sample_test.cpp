#include "road/sample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "mesh/error.h"
#include "road/reference_line.h"
#include "support/strip_road.h"

namespace sample_test {

using road::Provenance;
using road::SurfaceClass;
using support::circle;
using support::make_strip;

struct Sampled {
  crg::ReferenceLine line;
  road::SampledGrid sampled;
  road::SampleReport report;
};

Sampled sample(const road::RoadMesh& road, const road::SampleOptions& options = {}) {
  const auto centreline = road::trace_centreline(road);
  Sampled result;
  result.line = road::fit_reference_line(centreline);
  result.sampled = road::sample_grid(road, road::RaySurface(road.mesh), result.line, centreline,
                                     options, &result.report);
  return result;
}

std::size_t column_near(const crg::Grid& grid, double v_m) {
  std::size_t best = 0;
  for (std::size_t j = 0; j < grid.columns(); ++j) {
    if (std::abs(grid.v_m[j] - v_m) < std::abs(grid.v_m[best] - v_m)) best = j;
  }
  return best;
}

TEST(Sample, ReadsAPlaneExactly) {
  // z = 0.03 x - 0.02 y + 7 is a plane whatever the curve, so every node is known.
  const auto plan = [](double s) { return circle(s, 60.0); };
  const auto road = make_strip(plan, 2 * M_PI * 60.0, 2.0, true, {-6, 6}, [&](double s, double v) {
    const auto p = plan(s);
    return 0.03 * (p.x_m - v * std::sin(p.heading_rad)) -
           0.02 * (p.y_m + v * std::cos(p.heading_rad)) + 7.0;
  });
  const auto [line, sampled, report] = sample(road);
  EXPECT_EQ(report.holes, 0u);
  // The last row repeats the first, 1 mm and half a step of turn away from it.
  for (std::size_t i = 0; i + 1 < sampled.grid.rows(); ++i) {
    for (std::size_t j = 0; j < sampled.grid.columns(); ++j) {
      if (std::isnan(sampled.grid.at(i, j))) continue;
      const auto p = crg::node_position(line, i, sampled.grid.v_m[j]);
      ASSERT_NEAR(sampled.grid.at(i, j), 0.03 * p.x_m - 0.02 * p.y_m + 7.0, 2e-5);
    }
  }
  EXPECT_GE(sampled.grid.v_m.back(), 5.8);
  EXPECT_LE(sampled.grid.v_m.back(), 6.05) << "empty columns are dropped";
}

TEST(Sample, RepeatsTheFirstRowAsTheLastOfAClosedRoad) {
  const auto [line, sampled, report] =
      sample(make_strip([](double s) { return circle(s, 60.0); }, 2 * M_PI * 60.0, 2.0, true,
                        {-6, 6}, [](double s, double) { return 3.0 * std::sin(s / 60.0); }));
  const std::size_t last = sampled.grid.rows() - 1;
  for (std::size_t j = 0; j < sampled.grid.columns(); ++j) {
    EXPECT_EQ(std::isnan(sampled.grid.at(0, j)), std::isnan(sampled.grid.at(last, j)));
    if (!std::isnan(sampled.grid.at(0, j))) {
      EXPECT_EQ(sampled.grid.at(0, j), sampled.grid.at(last, j));
    }
  }
}

TEST(Sample, StaysOnItsDeckUnderAndOverABridge) {
  const double size_m = 150.0;
  const auto plan = [&](double s) -> support::PlanPoint {
    const double t = s / size_m;
    return {size_m * std::sin(t), size_m * std::sin(t) * std::cos(t),
            std::atan2(std::cos(2 * t), std::cos(t))};
  };
  const auto road = make_strip(plan, 2 * M_PI * size_m, 2.0, true, {-5, 0, 5},
                               [&](double s, double) { return 4.4 * std::cos(s / size_m); });
  const auto [line, sampled, report] = sample(road);
  EXPECT_EQ(report.holes, 0u);
  for (std::size_t i = 0; i + 1 < sampled.grid.rows(); ++i) {
    for (std::size_t j = 0; j < sampled.grid.columns(); ++j) {
      const float here = sampled.grid.at(i, j), next = sampled.grid.at(i + 1, j);
      if (std::isnan(here) || std::isnan(next)) continue;
      ASSERT_LT(std::abs(next - here), 0.05) << "row " << i << " column " << j;
    }
  }
  // The road is whole at the crossing: no row is narrower than the road.
  for (std::size_t i = 0; i < sampled.grid.rows(); ++i) {
    EXPECT_FALSE(std::isnan(sampled.grid.at(i, column_near(sampled.grid, 4.8)))) << i;
    EXPECT_FALSE(std::isnan(sampled.grid.at(i, column_near(sampled.grid, -4.8)))) << i;
  }
}

TEST(Sample, TrimsTheInsideOfABendTighterThanTheGridIsWide) {
  // Run-off reaches 14 m to the inside of a bend with 10 m radius: it would fold over itself.
  const auto plan = [](double s) -> support::PlanPoint {
    constexpr double kStraight = 60.0, kRadius = 10.0, kArc = M_PI * kRadius;
    s = std::fmod(s, 2 * (kStraight + kArc));
    const bool back = s >= kStraight + kArc;
    if (back) s -= kStraight + kArc;
    support::PlanPoint p =
        s < kStraight
            ? support::PlanPoint{s, -kRadius, 0.0}
            : support::PlanPoint{kStraight + kRadius * std::sin((s - kStraight) / kRadius),
                                 -kRadius * std::cos((s - kStraight) / kRadius),
                                 (s - kStraight) / kRadius};
    if (back) p = {kStraight - p.x_m, -p.y_m, p.heading_rad + M_PI};
    return p;
  };
  const double length_m = 2 * (60.0 + M_PI * 10.0);
  const auto road = make_strip(
      plan, length_m, 1.0, true, {-14, -4, 4, 9}, support::flat,
      [](double v) { return std::abs(v) < 4 ? SurfaceClass::road : SurfaceClass::runoff; });
  const auto [line, sampled, report] = sample(road);
  ASSERT_FALSE(report.folds.empty());
  // Neighbouring nodes of one column never run backwards: that is what a fold is.
  for (std::size_t i = 0; i + 1 < sampled.grid.rows(); ++i) {
    for (std::size_t j = 0; j < sampled.grid.columns(); ++j) {
      if (std::isnan(sampled.grid.at(i, j)) || std::isnan(sampled.grid.at(i + 1, j))) continue;
      const auto a = crg::node_position(line, i, sampled.grid.v_m[j]),
                 b = crg::node_position(line, i + 1, sampled.grid.v_m[j]);
      const double ahead = (b.x_m - a.x_m) * std::cos(line.heading_rad[i + 1]) +
                           (b.y_m - a.y_m) * std::sin(line.heading_rad[i + 1]);
      ASSERT_GT(ahead, 0.0) << "row " << i << " v " << sampled.grid.v_m[j];
    }
  }
}

TEST(Sample, CutsAtTheMiddleBetweenTwoLegsSideBySide) {
  // Two straights 16 m apart share one paved area: each leg owns the half on its side.
  const auto plan = [](double s) -> support::PlanPoint {
    constexpr double kStraight = 150.0, kRadius = 8.0, kArc = M_PI * kRadius;
    s = std::fmod(s, 2 * (kStraight + kArc));
    const bool back = s >= kStraight + kArc;
    if (back) s -= kStraight + kArc;
    support::PlanPoint p =
        s < kStraight
            ? support::PlanPoint{s, -kRadius, 0.0}
            : support::PlanPoint{kStraight + kRadius * std::sin((s - kStraight) / kRadius),
                                 -kRadius * std::cos((s - kStraight) / kRadius),
                                 (s - kStraight) / kRadius};
    if (back) p = {kStraight - p.x_m, -p.y_m, p.heading_rad + M_PI};
    return p;
  };
  const double length_m = 2 * (150.0 + M_PI * 8.0);
  const auto road = make_strip(
      plan, length_m, 1.0, true, {-12, -4, 4, 7.9}, support::flat,
      [](double v) { return std::abs(v) < 4 ? SurfaceClass::road : SurfaceClass::runoff; });
  road::SampleOptions options;
  options.max_gap_m = 0.5;
  const auto [line, sampled, report] = sample(road, options);
  EXPECT_FALSE(report.neighbours.empty());
  for (std::size_t i = 0; i < sampled.grid.rows(); ++i) {
    for (std::size_t j = 0; j < sampled.grid.columns(); ++j) {
      if (std::isnan(sampled.grid.at(i, j))) continue;
      EXPECT_LT(sampled.grid.v_m[j], 8.1) << "beyond the middle at row " << i;
    }
  }
}

TEST(Sample, KeepsTheRoadBeyondAHoleAndCountsTheHole) {
  auto road = make_strip([](double s) { return circle(s, 60.0); }, 2 * M_PI * 60.0, 2.0, true,
                         {-6, -2, 2, 6}, support::flat);
  road::RoadMesh holed = road;
  holed.mesh.triangles.erase(holed.mesh.triangles.begin() + 62,
                             holed.mesh.triangles.begin() + 64);  // a middle quad
  holed.mesh.object_of_triangle.resize(holed.mesh.triangles.size());
  holed.class_of_triangle.resize(holed.mesh.triangles.size());
  const auto [line, sampled, report] = sample(holed);
  EXPECT_EQ(report.folds.size(), 0u);
  // 4 m x 2 m without road at 0.1 m: 800 nodes, give or take its border.
  EXPECT_NEAR(static_cast<double>(report.holes), 800.0, 80.0);
  EXPECT_EQ(report.filled, 0u);
  std::size_t narrow = 0;
  for (std::size_t i = 0; i < sampled.grid.rows(); ++i)
    narrow += std::isnan(sampled.grid.at(i, column_near(sampled.grid, 5.8))) ? 1 : 0;
  EXPECT_EQ(narrow, 0u) << "the outer strip beyond the hole is road";
}

TEST(Sample, FillsCracksAndFlagsThem) {
  // Two half roads with a crack of 15 cm between them.
  auto road = make_strip([](double s) { return circle(s, 60.0); }, 2 * M_PI * 60.0, 2.0, true,
                         {-6, 1.0, 1.15, 6}, [](double, double v) { return 0.02 * v; });
  road::RoadMesh cracked = road;
  cracked.mesh.triangles.clear();
  for (std::size_t t = 0; t < road.mesh.triangles.size(); ++t) {
    if (t % 6 / 2 != 1) cracked.mesh.triangles.push_back(road.mesh.triangles[t]);
  }
  cracked.mesh.object_of_triangle.resize(cracked.mesh.triangles.size());
  cracked.class_of_triangle.resize(cracked.mesh.triangles.size());
  const auto [line, sampled, report] = sample(cracked);
  EXPECT_EQ(report.holes, 0u);
  EXPECT_GT(report.filled, sampled.grid.rows() / 2);
  for (std::size_t node = 0; node < sampled.provenance.size(); ++node) {
    if (sampled.provenance[node] != Provenance::filled) continue;
    EXPECT_NEAR(sampled.grid.z_m[node], 0.02 * sampled.grid.v_m[node % sampled.grid.columns()],
                1e-3);
  }
}

TEST(Sample, EndsWhereTheSurfaceStepsUpOrDown) {
  // A wall of 1 m at v = 5 with more surface behind it.
  const auto road = make_strip(
      [](double s) { return circle(s, 60.0); }, 2 * M_PI * 60.0, 2.0, true, {-6, -4, 4, 5, 5.01, 9},
      [](double, double v) { return v > 5.005 ? 1.0 : 0.0; },
      [](double v) { return std::abs(v) < 4 ? SurfaceClass::road : SurfaceClass::runoff; });
  const auto [line, sampled, report] = sample(road);
  EXPECT_NEAR(sampled.grid.v_m.back(), 5.0, 0.06);
}

TEST(Sample, GivesTheSameBytesForAnyNumberOfThreads) {
  const auto road = make_strip([](double s) { return circle(s, 60.0); }, 2 * M_PI * 60.0, 2.0, true,
                               {-6, -2, 2, 6},
                               [](double s, double v) { return std::sin(s / 9.0) + 0.01 * v * v; });
  road::SampleOptions one, many;
  one.threads = 1;
  many.threads = 5;
  const auto a = sample(road, one), b = sample(road, many);
  ASSERT_EQ(a.sampled.grid.z_m.size(), b.sampled.grid.z_m.size());
  EXPECT_EQ(0, std::memcmp(a.sampled.grid.z_m.data(), b.sampled.grid.z_m.data(),
                           a.sampled.grid.z_m.size() * sizeof(float)));
}

TEST(Sample, RefusesImpossibleGrids) {
  const auto road = make_strip([](double s) { return circle(s, 60.0); }, 2 * M_PI * 60.0, 2.0, true,
                               {-6, 6}, support::flat);
  EXPECT_THROW(sample(road, {.v_step_m = 0.0}), road::Error);
  EXPECT_THROW(sample(road, {.v_step_m = 2.0, .v_max_m = 1.0}), road::Error);
  EXPECT_THROW(sample(road, {.v_step_m = 1e-6}), road::Error) << "asked before the memory is taken";
}

}  // namespace sample_test
