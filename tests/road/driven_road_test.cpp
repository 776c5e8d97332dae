#include "road/driven_road.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "crg/surface.h"
#include "driven_lap.h"
#include "mesh/error.h"
#include "road/track_crg.h"

namespace road {
namespace driven_road_test {

using ::testing::HasSubstr;

/// Laps beside each other, with noise as satellites have it, and one leap.
DrivenPlaces noisy_laps() {
  const DrivenLap drive = drive_round(3.2, 10.0);
  DrivenPlaces out{"log", {}, {}};
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.05);
  for (std::size_t i = 0; i < drive.x_m.size(); ++i) {
    const double x = drive.x_m[i], y = drive.y_m[i], r = std::hypot(x, y);
    const double out_m = drive.time_s[i] > 1.2 * drive.lap_s ? 4.0 : 0.0;  // beside the first lap
    out.x_m.push_back(x * (1.0 + out_m / r) + noise(random));
    out.y_m.push_back(y * (1.0 + out_m / r) + noise(random));
  }
  out.x_m[300] += 200.0;
  return out;
}

TEST(DrivenRoad, IsFlatClosedAndUnderEveryLap) {
  const DrivenPlaces drive = noisy_laps();
  DrivenRoadReport report;
  const EdgeRoad road = road_under(drive, &report);
  EXPECT_TRUE(report.edges.closed);
  EXPECT_EQ(report.leaps, 1u);
  EXPECT_LT(report.beside_share, 0.01);
  EXPECT_NEAR(report.length_m, drive_round(1.0).lap_m, 30.0);  // 4 m out is 25 m more
  const crg::Surface surface(track_crg(road.line, road.sampled.grid));
  crg::Cursor cursor;
  double last_u_m = -1.0;
  std::size_t back = 0, beside = 0;
  for (std::size_t i = 0; i < drive.x_m.size(); ++i) {
    if (i == 300) continue;
    const crg::Sample at = surface.at_xy(drive.x_m[i], drive.y_m[i], cursor);
    beside += std::isfinite(at.z_m) ? 0 : 1;
    if (std::isfinite(at.z_m)) EXPECT_EQ(at.z_m, 0.0);
    back += at.u_m < last_u_m ? 1 : 0;
    last_u_m = at.u_m;
  }
  EXPECT_EQ(beside, 0u);
  EXPECT_LE(back, 4u);  // where laps begin
}

TEST(DrivenRoad, FollowsAWayThatDoesNotComeBack) {
  const DrivenLap drive = drive_round(0.6);
  DrivenRoadReport report;
  const EdgeRoad road = road_under({"log", drive.x_m, drive.y_m}, &report);
  EXPECT_FALSE(report.edges.closed);
  EXPECT_NEAR(report.left_m, 5.0, 0.1);
  const crg::Surface surface(track_crg(road.line, road.sampled.grid));
  crg::Cursor cursor;
  for (std::size_t i = 5; i + 5 < drive.x_m.size(); ++i)
    ASSERT_LT(std::abs(surface.at_xy(drive.x_m[i], drive.y_m[i], cursor).v_m), 0.5) << i;
}

TEST(DrivenRoad, WantsADrive) {
  try {
    road_under({"some.csv", {1.0, NAN}, {2.0, 3.0}});
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("some.csv: 1 rows with a place"));
  }
}

}  // namespace driven_road_test
}  // namespace road
