// Drives of several cars in one estimate: what all agree on is the road's, what one has its own.
#include "explain/fleet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "synthetic_drive.h"
#include "vehicle/error.h"

namespace explain {
namespace fleet_test {

using explain_test::synthetic_drive, explain_test::SyntheticCar, explain_test::World;
using ::testing::HasSubstr;

std::vector<DriveSummary> drives_of(const World& world, int cars, double mechanism = 0.0,
                                    double own = 0.0, int drives_per_car = 1) {
  std::vector<DriveSummary> out;
  for (int k = 0; k < cars; ++k)
    for (int d = 0; d < drives_per_car; ++d)
      out.push_back(synthetic_drive(world,
                                    {.name = "car" + std::to_string(k),
                                     .mechanism = k == 2 ? mechanism : 0.0,
                                     .own = own,
                                     .seed = static_cast<std::uint64_t>(100 + k)},
                                    static_cast<std::uint64_t>(1000 + 10 * k + d)));
  return out;
}

FleetFindings explained(const std::vector<DriveSummary>& drives, unsigned threads = 1) {
  return explain_fleet(drives.size(), [&](std::size_t k) { return drives[k]; }, {threads, {}});
}

const FleetFinding* found(const FleetFindings& all, const std::string& mechanism) {
  for (const FleetFinding& f : all.findings)
    if (f.mechanism == mechanism) return &f;
  return nullptr;
}

TEST(Fleet, WhatAllCarsAgreeOnIsTheRoadAndWhatOneHasIsItsOwn) {
  const FleetFindings all = explained(drives_of({.banking = 0.04}, 6, 0.5));
  EXPECT_EQ(all.verdict, FleetVerdict::kDivided);
  ASSERT_EQ(all.findings.size(), 2u);
  const FleetFinding* road = found(all, "road.banking");
  ASSERT_NE(road, nullptr);
  EXPECT_EQ(road->belongs_to, "road");
  EXPECT_EQ(road->agreeing, 6u);
  EXPECT_NEAR(road->amount, 0.04, 0.008);
  EXPECT_LT(road->low, 0.04);
  EXPECT_GT(road->high, 0.04);
  // Knots 5 to 9 of 24 on 600 m.
  ASSERT_EQ(road->where.size(), 1u);
  EXPECT_NEAR(road->where[0].u_begin_m, 112.5, 25.1);
  EXPECT_NEAR(road->where[0].u_end_m, 237.5, 25.1);
  const FleetFinding* car = found(all, "vehicle.0");
  ASSERT_NE(car, nullptr);
  EXPECT_EQ(car->belongs_to, "car");
  EXPECT_EQ(car->owner, "car2");
  EXPECT_EQ(car->agreeing, 0u);
  EXPECT_NEAR(car->amount, 0.5, 0.02);
}

TEST(Fleet, OneCarDoesNotTellWhoseItIs) {
  const std::vector<DriveSummary> six = drives_of({.banking = 0.04}, 6);
  for (const DriveSummary& drive : six) {
    const FleetFindings one = explained({drive});
    EXPECT_EQ(one.verdict, FleetVerdict::kCannotTell) << drive.car;
    EXPECT_TRUE(one.findings.empty()) << drive.car;
    ASSERT_EQ(one.undivided.size(), 1u);
    EXPECT_EQ(one.undivided[0].what, "banking added");
    EXPECT_THAT(one.undivided[0].separating, HasSubstr("2 or more other cars"));
  }
  // Nor does it say that nothing is there.
  EXPECT_EQ(explained(drives_of({}, 2)).verdict, FleetVerdict::kCannotTell);
}

TEST(Fleet, WhatEachCarGetsWrongByItselfIsNoRoad) {
  // As large as a road error would be, but another one in each car.
  const FleetFindings all = explained(drives_of({}, 6, 0.0, 0.02, 2));
  EXPECT_EQ(found(all, "road.banking"), nullptr);
  EXPECT_GT(all.own_size[0], 0.005);
  EXPECT_LT(all.own_size[0], 0.05);
}

TEST(Fleet, NothingIsFoundWhereNothingIs) {
  int alarms = 0;
  const int rounds = std::getenv("KERBSTONE_HEAVY") != nullptr ? 20 : 8;
  for (int round = 0; round < rounds; ++round) {
    std::vector<DriveSummary> drives;
    for (int k = 0; k < 5; ++k)
      drives.push_back(synthetic_drive({},
                                       {.name = "car" + std::to_string(k),
                                        .own = 0.003,
                                        .seed = static_cast<std::uint64_t>(100 * round + k)},
                                       static_cast<std::uint64_t>(7000 + 100 * round + k)));
    alarms += explained(drives).verdict == FleetVerdict::kNone ? 0 : 1;
  }
  EXPECT_LE(alarms, rounds / 20);
}

TEST(Fleet, DrivesOfOneCarShareItAndThreadsChangeNothing) {
  const std::vector<DriveSummary> drives = drives_of({.banking = 0.03}, 4, 0.4, 0.002, 3);
  const FleetFindings all = explained(drives);
  ASSERT_EQ(all.cars.size(), 4u);
  for (const FleetCar& car : all.cars) {
    EXPECT_EQ(car.drives, 3u);
    EXPECT_EQ(car.laps, 15u);
  }
  // Parameters of a car are up to 0.01 off and its intervals hold them.
  EXPECT_EQ(fleet_page(all, "x"), fleet_page(explained(drives, 2), "x"));
}

TEST(Fleet, ASensorThatIsOffIsTheDrivesOwn) {
  std::vector<DriveSummary> drives = drives_of({.sensors = 1}, 4);
  // The first sensor's error of one drive, 0.2: what it does to the sums.
  DriveSummary& d = drives[1];
  const std::size_t q = d.columns.size(), road = d.road_columns(), at = q - 1;
  const double amount = 0.2;
  for (std::size_t k = 0; k < road; ++k)
    d.by_forces.right[k] += amount * d.by_forces.across[at * road + k];
  for (std::size_t k = 0; k < q; ++k)
    d.by_forces.right[road + k] += amount * d.by_forces.among[at * (at + 1) / 2 + k];
  const FleetFindings all = explained(drives);
  const FleetFinding* sensor = found(all, "sensor.0");
  ASSERT_NE(sensor, nullptr);
  EXPECT_EQ(sensor->belongs_to, "drive");
  EXPECT_EQ(sensor->owner, d.recording);
  EXPECT_NEAR(sensor->amount, amount, 0.03);
  EXPECT_EQ(all.findings.size(), 1u);
}

void expect_refused(const std::vector<DriveSummary>& drives, const std::string& why) {
  try {
    explained(drives);
    FAIL() << why;
  } catch (const vehicle::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(why));
  }
}

TEST(Fleet, DrivesThatDoNotGoTogetherAreRefused) {
  const std::vector<DriveSummary> good = drives_of({}, 2);
  expect_refused({}, "no summaries");
  std::vector<DriveSummary> drives = good;
  drives[1].road_sha256 = "b";
  expect_refused(drives, "was driven on another road file");
  drives = good;
  drives[1].program = "crgexplain 9";
  expect_refused(drives, "make all with one program");
  drives = good;
  drives[1].recording_sha256 = drives[0].recording_sha256;
  expect_refused(drives, "the same recording as");
  drives = good;
  drives[1].columns[1] = drives[1].columns[0];
  expect_refused(drives, "an unknown twice");
  drives = good;
  drives[1].car_sha256 = drives[0].car_sha256;
  drives[1].columns[0].deviation *= 2;
  expect_refused(drives, "stated otherwise than in another drive of the same car");
  drives = good;
  drives[1].by_forces.among.back() = -1e9;
  expect_refused(drives, "none of a fit");
  drives = good;
  for (int k = 0; k < 300; ++k) {
    drives.push_back(good[0]);
    drives.back().car_sha256 = drives.back().recording_sha256 = std::to_string(k);
  }
  expect_refused(drives, "200 cars at most");
}

TEST(Fleet, ThePageSaysWhatWasFoundAndEscapesNames) {
  std::vector<DriveSummary> drives = drives_of({.banking = 0.04}, 4, 0.5);
  drives[2].car = "<b>late</b>";
  const std::string page = fleet_page(explained(drives), "Fleet");
  for (const char* word :
       {"road.banking", "vehicle.0", "&lt;b&gt;late&lt;/b&gt;", "divided", "<svg"})
    EXPECT_THAT(page, HasSubstr(word));
  EXPECT_EQ(page.find("<b>late"), std::string::npos);
  EXPECT_TRUE(page.ends_with("</html>\n"));
}

}  // namespace fleet_test
}  // namespace explain
