#include "road/kerb_zones.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mesh/error.h"
#include "road/kerb.h"
#include "road/reference_line.h"
#include "support/strip_road.h"
#include "support/temporary_folder.h"

namespace road {
namespace kerb_zones_test {

using ::testing::HasSubstr;

/// A ring of road with a ridge of 6 cm from v = 3 to 4 on it, of this class.
RoadMesh ring(SurfaceClass ridge) {
  return support::make_strip(
      [](double s) { return support::circle(s, 60.0); }, 2 * M_PI * 60.0, 1.0, true,
      {-5, 2.999, 3, 4, 4.001, 5},
      [](double, double v) { return v > 2.9995 && v < 4.0005 ? 0.06 : 0.0; },
      [ridge](double v) { return v > 2.9995 && v < 4.0005 ? ridge : SurfaceClass::road; });
}

struct Refined {
  SampledGrid grid;
  KerbReport report;
};

Refined refine(const RoadMesh& mesh, const KerbOptions& options) {
  const Centreline centreline = trace_centreline(mesh);
  const crg::ReferenceLine line = fit_reference_line(centreline);
  const RaySurface surface(mesh.mesh);
  Refined out;
  out.grid = refine_kerbs(sample_grid(mesh, surface, line, centreline), surface, mesh, line,
                          options, &out.report);
  return out;
}

std::string zone_file(const support::TemporaryFolder& folder, const std::string& rows) {
  return folder.file("zones.csv", "u_begin_m,u_end_m,v_begin_m,v_end_m,kerb\n" + rows);
}

TEST(KerbZones, WhereOneSaysThatThereIsNoKerbNoneIsFound) {
  const support::TemporaryFolder folder;
  const RoadMesh mesh = ring(SurfaceClass::kerb);
  const Refined whole = refine(mesh, {});
  ASSERT_EQ(whole.report.kerbs.size(), 1u);
  const Refined part =
      refine(mesh, {.zones = read_kerb_zones(zone_file(folder, "100,150,-15,15,0\n"))});
  ASSERT_EQ(part.report.kerbs.size(), 2u);
  EXPECT_NEAR(part.report.kerbs[0].u_end_m, 100.0, 0.11);
  EXPECT_NEAR(part.report.kerbs[1].u_begin_m, 150.0, 0.11);
  EXPECT_NEAR(part.report.kerbs[1].v_begin_m, whole.report.kerbs[0].v_begin_m, 1e-9);
  // The heights stay what they are; only what it is called changes.
  EXPECT_EQ(part.grid.grid.v_m, whole.grid.grid.v_m);
  const auto same = [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  EXPECT_TRUE(std::equal(part.grid.grid.z_m.begin(), part.grid.grid.z_m.end(),
                         whole.grid.grid.z_m.begin(), same));
  const Refined none =
      refine(mesh, {.zones = read_kerb_zones(zone_file(folder, "0,1000,-15,15,0\n"))});
  EXPECT_TRUE(none.report.kerbs.empty());
  EXPECT_EQ(none.report.columns_added, 0u);
}

TEST(KerbZones, WhatOneCallsAKerbIsRefinedAsSuch) {
  const support::TemporaryFolder folder;
  const RoadMesh mesh = ring(SurfaceClass::road);
  EXPECT_TRUE(refine(mesh, {}).report.kerbs.empty());
  // Over the start, and a later row takes a piece out again.
  const Refined part = refine(
      mesh, {.zones = read_kerb_zones(zone_file(folder, "300,60,2.98,4.02,1\n20,30,-15,15,0\n"))});
  ASSERT_EQ(part.report.kerbs.size(), 3u);
  const Kerb& first = part.report.kerbs[0];
  EXPECT_NEAR(first.u_begin_m, 0.0, 1e-6);
  EXPECT_NEAR(first.u_end_m, 20.0, 0.11);
  EXPECT_NEAR(first.v_begin_m, 3.0, 0.11);
  EXPECT_NEAR(first.v_end_m, 4.0, 0.11);
  EXPECT_NEAR(first.height_m, 0.06, 0.002);
  EXPECT_NEAR(part.report.kerbs[1].u_begin_m, 30.0, 0.11);
  EXPECT_NEAR(part.report.kerbs[1].u_end_m, 60.0, 0.11);
  EXPECT_NEAR(part.report.kerbs[2].u_begin_m, 300.0, 0.11);
  // Columns stand at the edges of the zone.
  for (const double v : {2.975, 2.985, 4.015, 4.025})
    EXPECT_TRUE(std::any_of(part.grid.grid.v_m.begin(), part.grid.grid.v_m.end(), [v](double at) {
      return std::abs(at - v) < 1e-9;
    })) << v;
}

TEST(KerbZones, WrongRowsAreRefusedWithTheirLine) {
  const support::TemporaryFolder folder;
  const auto refused = [&](const std::string& row) -> std::string {
    try {
      read_kerb_zones(zone_file(folder, row + "\n"));
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refused("0,1,2,1,0"), HasSubstr("zones.csv:2: v_begin_m 2"));
  EXPECT_THAT(refused("0,1,1,2,0.5"), HasSubstr("zones.csv:2: kerb is 0.5; wanted 1 (kerb) or 0"));
  EXPECT_THAT(refused("0,1,1,,1"), HasSubstr("zones.csv:2: column 'v_end_m' is empty, wanted"));
  EXPECT_EQ(refused("9,1,1,1,1"), "accepted");
}

}  // namespace kerb_zones_test
}  // namespace road
