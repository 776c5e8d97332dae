#include "road/kerb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "road/reference_line.h"
#include "support/strip_road.h"

namespace kerb_test {

using road::SurfaceClass;

/// A ring with a kerb from v = 4.03 to 5.02: a ramp to 8 cm, then a vertical face down to the
/// run-off.
road::RoadMesh kerbed_ring() {
  return support::make_strip([](double s) { return support::circle(s, 60.0); }, 2 * M_PI * 60.0,
                             1.0, true, {-6, 4.03, 5.02, 5.0201, 8},
                             [](double, double v) { return v > 5.02005 || v < 4.04 ? 0.0 : 0.08; },
                             [](double v) {
                               if (v > 4.03 && v < 5.02) return SurfaceClass::kerb;
                               return v < 4.03 ? SurfaceClass::road : SurfaceClass::runoff;
                             });
}

struct Refined {
  road::SampledGrid before, after;
  road::KerbReport report;
};

Refined refine(const road::RoadMesh& road, const road::KerbOptions& options = {}) {
  const auto centreline = road::trace_centreline(road);
  const auto line = road::fit_reference_line(centreline);
  const road::RaySurface surface(road.mesh);
  Refined result;
  result.before = road::sample_grid(road, surface, line, centreline);
  result.after = road::refine_kerbs(result.before, surface, road, line, options, &result.report);
  return result;
}

/// Bilinear height of row i at v.
double height(const crg::Grid& grid, std::size_t i, double v_m) {
  const auto right = static_cast<std::size_t>(
      std::upper_bound(grid.v_m.begin(), grid.v_m.end(), v_m) - grid.v_m.begin());
  const double t = (v_m - grid.v_m[right - 1]) / (grid.v_m[right] - grid.v_m[right - 1]);
  return (1 - t) * static_cast<double>(grid.at(i, right - 1)) +
         t * static_cast<double>(grid.at(i, right));
}

TEST(Kerb, IsFoundWithItsPlaceAndHeight) {
  const auto result = refine(kerbed_ring());
  ASSERT_EQ(result.report.kerbs.size(), 1u);
  const road::Kerb& kerb = result.report.kerbs[0];
  // The line runs in the middle of the road, 0.985 m right of the strip's own zero.
  const double shift = 0.5 * (-6 + 4.03);
  EXPECT_NEAR(kerb.v_begin_m, 4.03 - shift, 0.11);
  EXPECT_NEAR(kerb.v_end_m, 5.02 - shift, 0.11);
  EXPECT_NEAR(kerb.height_m, 0.08, 0.01);
  EXPECT_GT(result.report.cells, 0u);
}

TEST(Kerb, NewColumnsCarryTheVerticalFace) {
  const auto result = refine(kerbed_ring());
  EXPECT_GT(result.report.columns_added, 0u);
  EXPECT_LE(result.after.grid.columns(), result.before.grid.columns() * 3 / 2);
  const double face = 5.02 - 0.5 * (-6 + 4.03);
  double worst_before = 0.0, worst_after = 0.0;
  for (std::size_t i = 0; i < result.after.grid.rows(); i += 7) {
    // 2 cm outside the face the mesh is at 0.
    worst_before = std::max(worst_before, std::abs(height(result.before.grid, i, face + 0.02)));
    worst_after = std::max(worst_after, std::abs(height(result.after.grid, i, face + 0.02)));
  }
  EXPECT_GT(worst_before, 0.02) << "the test would show nothing";
  EXPECT_LT(worst_after, 0.002);
}

TEST(Kerb, LeavesAGridWithoutKerbsAsItIs) {
  const auto road = support::make_strip([](double s) { return support::circle(s, 60.0); },
                                        2 * M_PI * 60.0, 1.0, true, {-6, 6}, support::flat);
  const auto result = refine(road);
  EXPECT_TRUE(result.report.kerbs.empty());
  EXPECT_EQ(result.after.grid.v_m, result.before.grid.v_m);
}

TEST(Kerb, AddsNoMoreColumnsThanAllowed) {
  const auto result = refine(kerbed_ring(), {.max_extra_columns_share = 0.01});
  EXPECT_LE(result.report.columns_added, result.before.grid.columns() / 100 + 1);
}

}  // namespace kerb_test
