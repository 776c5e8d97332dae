// Forty drives and forty more: what stands at the road's edge, drives on it or lies on it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "support/figure.h"
#include "support/kerbed_road.h"

namespace cloud {
namespace forty_drives_test {

/// Made-up scans of one kind, and what they must not miss.
struct Kind {
  const char* name;
  double most_road_m;
  void (*set)(support::KerbedRoad& road, support::KerbedDrive& drive, base::Random& random);
};

const Kind kKinds[] = {
    {"wall, 0 to 1 m beside the asphalt", 0.0015,
     [](support::KerbedRoad&, support::KerbedDrive& d, base::Random& r) {
       d.wall_m = 5.0 + r.uniform();
     }},
    {"grass from the kerb's end", 0.003,
     [](support::KerbedRoad&, support::KerbedDrive& d, base::Random& r) {
       d.grass_m = 0.12 * r.uniform();
     }},
    {"cars that follow and come", 0.0015,
     [](support::KerbedRoad&, support::KerbedDrive& d, base::Random& r) {
       d.convoy = 1 + static_cast<int>(3.0 * r.uniform()), d.oncoming = r.uniform() < 0.5;
     }},
    {"rain of 0 to 3 %", 0.0015,
     [](support::KerbedRoad&, support::KerbedDrive& d, base::Random& r) {
       d.rain = 0.03 * r.uniform();
     }},
    {"one pass, with any of it", 0.003,
     [](support::KerbedRoad&, support::KerbedDrive& d, base::Random& r) {
       d.passes = 1, d.rain = r.uniform() < 0.5 ? 0.0 : 0.02 * r.uniform();
       d.grass_m = r.uniform() < 0.5 ? 0.0 : 0.06 * r.uniform();
       d.wall_m = r.uniform() < 0.5 ? 0.0 : 5.1 + r.uniform();
     }},
};

const Kind kOtherKinds[] = {
    {"kerbs with steps every 2 m", 0.0015,
     [](support::KerbedRoad& road, support::KerbedDrive&, base::Random& r) {
       road.step_m = 0.005 + 0.025 * r.uniform();
     }},
    {"painted lines", 0.0015,
     [](support::KerbedRoad&, support::KerbedDrive& d, base::Random& r) {
       d.paint_m = 0.01 * r.uniform();
     }},
    {"grass and behind it a wall, on one side", 0.003,
     [](support::KerbedRoad&, support::KerbedDrive& d, base::Random& r) {
       d.left_only = true, d.grass_m = 0.12 * r.uniform(), d.wall_m = 6.3 + 1.7 * r.uniform();
     }},
    {"a crown of 0 to 3 %", 0.0015,
     [](support::KerbedRoad& road, support::KerbedDrive&, base::Random& r) {
       road.crown = 0.03 * r.uniform();
     }},
    {"one pass in rain of 0 to 3 %", 0.003,
     [](support::KerbedRoad&, support::KerbedDrive& d, base::Random& r) {
       d.passes = 1, d.rain = 0.03 * r.uniform();
     }},
    {"cars that stand on the kerbs", 0.0015,
     [](support::KerbedRoad& road, support::KerbedDrive& d, base::Random& r) {
       for (int k = 0; k < 4; ++k)
         d.parked.push_back({(0.2 + 0.15 * (k + r.uniform())) * road.length_m,
                             (k % 2 == 0 ? 1.0 : -1.0) * (5.95 + 0.4 * r.uniform())});
     }},
};

/// Single drives keep to the bounds of heights and ramps; how far the stated deviations hold is
/// asked of all of them together, as half of a drive's nodes may share one error.
void expect_forty_right(const Kind* kinds, int count, std::uint64_t seed) {
  support::KerbedTallies all;
  for (int n = 0; n < 40; ++n) {
    const Kind& kind = kinds[n % count];
    const int k = n / count;
    base::Random random(seed + static_cast<std::uint64_t>(1000 * (n % count) + k));
    support::KerbedRoad road;
    road.radius_m = 60.0, road.tilt = 0.017 * (2.0 * random.uniform() - 1.0);
    support::KerbedDrive drive;
    drive.seed = seed + static_cast<std::uint64_t>(k) + 1;
    kind.set(road, drive, random);
    const support::KerbedScans made = scans_of(road, drive);
    const MapResult result = map_clouds([&](const ChunkSink& sink) { sink(Cloud(made.points)); },
                                        road.base(), &made.trajectory, MapOptions());
    const support::KerbedError e = error_of(road, result);
    all.add(e.tallies);
    support::figure_of_case("drive_road_mm", 1e3 * e.road_rmse_m);
    support::figure_of_case("drive_outer_mm", 1e3 * e.outer_rmse_m);
    support::figure_of_case("drive_kerb_p95_mm", 1e3 * e.measured_kerb_p95_m);
    support::figure_of_case("drive_banking_deg", e.banking_rad * 180.0 / M_PI);
    support::figure_of_case("drive_lost_percent", 100.0 * e.lost);
    support::figure_of_case("drive_ramp_over_correction", e.ramp_over_correction);
    SCOPED_TRACE(fmt::format("{}, {}: wall {:.2f} m, grass {:.3f} m, {} cars, rain {:.4f}",
                             kind.name, k, drive.wall_m, drive.grass_m, drive.convoy, drive.rain));
    EXPECT_TRUE(e.converged);
    EXPECT_TRUE(result.report.faults.empty());
    EXPECT_LT(e.road_rmse_m, kind.most_road_m);
    EXPECT_LT(e.outer_rmse_m, kind.most_road_m);
    EXPECT_LT(e.measured_kerb_p95_m, 0.005);
    EXPECT_LT(e.banking_rad, 0.02 * M_PI / 180.0);
    EXPECT_LT(e.lost, 0.005);
    EXPECT_LT(e.ramp_over_correction, 0.01);
  }
  for (const auto& [name, tally] : {std::pair("road", all.road),
                                    {"outer", all.outer},
                                    {"kerbs", all.kerbs},
                                    {"unmeasured", all.unmeasured}}) {
    SCOPED_TRACE(name);
    support::figure(fmt::format("{}_inside_percent", name), 100.0 * tally.share());
    support::figure(fmt::format("{}_mm", name), 1e3 * tally.rmse_m());
    EXPECT_GT(tally.share(), 0.85);
    EXPECT_LT(tally.share(), 0.95);
  }
  support::figure("unmeasured_stated_over_true",
                  all.unmeasured.stated_m() / all.unmeasured.rmse_m());
  EXPECT_LT(all.unmeasured.stated_m(), 3.0 * all.unmeasured.rmse_m());
}

TEST(SlowRoadEdge, FortyDrivesByKind) { expect_forty_right(kKinds, std::size(kKinds), 0); }

// Kinds that none of the code was made by.
TEST(SlowRoadEdge, FortyDrivesOfOtherKinds) {
  expect_forty_right(kOtherKinds, std::size(kOtherKinds), 500);
}

}  // namespace forty_drives_test
}  // namespace cloud
