// Kerbs with grass from where they end.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/figure.h"
#include "support/kerbed_road.h"

namespace cloud {
namespace kerb_beside_grass_test {

support::KerbedError refine(int passes, double grass_m, std::uint64_t seed) {
  const support::KerbedRoad road;
  support::KerbedDrive drive;
  drive.passes = passes, drive.grass_m = grass_m, drive.seed = seed;
  const support::KerbedScans made = scans_of(road, drive);
  const support::KerbedError out =
      error_of(road, map_clouds([&](const ChunkSink& sink) { sink(Cloud(made.points)); },
                                road.base(), &made.trajectory));
  support::figure_of_case("road_mm", 1e3 * out.road_rmse_m);
  support::figure_of_case("kerb_p95_mm", 1e3 * out.kerb_p95_m);
  return out;
}

// The left kerb is 25 mm higher than the base has it: where it is taken for grass, it stays so.
void expect_road_and_kerbs(const support::KerbedError& seen, double most_road_m) {
  EXPECT_TRUE(seen.converged);
  EXPECT_GT(seen.road_nodes, 20000u);
  EXPECT_GT(seen.kerb_nodes, 3000u);
  EXPECT_LT(seen.road_rmse_m, most_road_m);
  EXPECT_LT(seen.banking_rad, 0.02 * M_PI / 180.0);
  EXPECT_LT(seen.kerb_p95_m, 0.005);
  EXPECT_LT(seen.lost, 0.005);
}

TEST(KerbBesideGrass, IsMeasuredAndNoGrass) { expect_road_and_kerbs(refine(2, 0.06, 1), 0.003); }

TEST(SlowKerbBesideGrass, IsMeasuredWhateverTheGrassStandsHigh) {
  for (const double grass_m : {0.0, 0.015, 0.03, 0.06, 0.12})
    for (const int passes : {2, 1}) {
      SCOPED_TRACE(fmt::format("{} passes, grass of {} m", passes, grass_m));
      expect_road_and_kerbs(refine(passes, grass_m, 2),
                            passes == 1 || grass_m >= 0.06 ? 0.003 : 0.0015);
    }
}

}  // namespace kerb_beside_grass_test
}  // namespace cloud
