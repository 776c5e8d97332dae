#include "vehicle/road_sensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "support/temporary_folder.h"
#include "vehicle/error.h"
#include "vehicle/signal_sensors.h"

namespace road_sensors_test {

constexpr double kDegree = std::numbers::pi / 180.0;

vehicle::RoadSensorFile read(const std::string& text) {
  const support::TemporaryFolder folder;
  return vehicle::read_signal_sensors(folder.file("devices.yaml", text)).road;
}

std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const vehicle::Error& error) {
    return error.what();
  }
  return "";
}

TEST(RoadSensors, AreReadInDegreesAndMetres) {
  const vehicle::RoadSensorFile file = read(R"(
scans:
  lidar: {at_m: [1.2, 0, 0.6], turned_deg: [0, 5, -90], rate_hz: 20, delay_s: 0.05, beams_deg: [-15, 0, 2.5], field_deg: 90, step_deg: 0.2, nearest_m: 1, reach_m: 50, noise_m: 0.02, lost: 0.01}
edges:
  camera: {field_deg: 60, spacing_m: 2, noise_deg: 0.1}
pose: {x: px, yaw: heading}
)");
  ASSERT_EQ(file.scans.size(), 1u);
  const vehicle::ScanSensor& scan = file.scans[0];
  EXPECT_EQ(scan.name, "lidar");
  EXPECT_EQ(scan.clock.rate_hz, 20.0);
  EXPECT_EQ(scan.clock.delay_s, 0.05);
  EXPECT_THAT(scan.mounting.at_m, testing::ElementsAre(1.2, 0.0, 0.6));
  EXPECT_NEAR(scan.mounting.turned_rad[2], -90.0 * kDegree, 1e-12);
  ASSERT_EQ(scan.beams_rad.size(), 3u);
  EXPECT_NEAR(scan.beams_rad[2], 2.5 * kDegree, 1e-12);
  EXPECT_EQ(scan.columns(), 450u);
  EXPECT_EQ(scan.nearest_m, 1.0);
  EXPECT_EQ(scan.reach_m, 50.0);
  EXPECT_EQ(scan.noise_m, 0.02);
  EXPECT_EQ(scan.lost, 0.01);
  ASSERT_EQ(file.edges.size(), 1u);
  EXPECT_NEAR(file.edges[0].field_rad, 60.0 * kDegree, 1e-12);
  EXPECT_EQ(file.edges[0].spacing_m, 2.0);
  EXPECT_NEAR(file.edges[0].noise_rad, 0.1 * kDegree, 1e-12);
  EXPECT_EQ(file.edges[0].clock.rate_hz, 30.0);
  EXPECT_THAT(file.pose,
              testing::ElementsAre("px", "car.y", "car.z", "car.roll", "car.pitch", "heading"));
}

TEST(RoadSensors, WhatCannotBeIsRefusedWithItsLine) {
  using testing::HasSubstr;
  EXPECT_THAT(refusal("scans:\n  a: {rate_hz: 10}\n"), HasSubstr(":2: a: beams_deg has 0"));
  EXPECT_THAT(refusal("scans:\n  a: {beams_deg: [91]}\n"), HasSubstr("a beam at 91 degrees"));
  EXPECT_THAT(refusal("scans:\n  a: {beams_deg: [x]}\n"), HasSubstr("beams_deg"));
  EXPECT_THAT(refusal("scans:\n  a: {beams_deg: [0], beam: 1}\n"), HasSubstr("beam"));
  EXPECT_THAT(refusal("scans:\n  a: {beams_deg: [0], reach_m: 301}\n"), HasSubstr("reach_m"));
  EXPECT_THAT(refusal("scans:\n  a: {beams_deg: [0], nearest_m: 90}\n"),
              HasSubstr("nearest_m has to be below reach_m"));
  EXPECT_THAT(refusal("scans:\n  a: {beams_deg: [0], at_m: [0, 0, 101]}\n"),
              HasSubstr("at_m has 101, wanted -100 to 100"));
  std::string many = "scans:\n  a: {step_deg: 0.01, beams_deg: [0";
  for (int k = 1; k < 6; ++k) many += ", " + std::to_string(k);
  EXPECT_THAT(refusal(many + "]}\n"), HasSubstr("216000 beams in a scan, at most 200000"));
  EXPECT_THAT(refusal("scans:\n  a: {step_deg: 0.01, rate_hz: 100, beams_deg: [0]}\n"),
              HasSubstr("3600000 beams a second together, at most 2000000"));
  const std::string half = "{step_deg: 0.01, rate_hz: 40, beams_deg: [0], delay_s: ";  // 1.44 M/s
  EXPECT_THAT(refusal("scans:\n  a: " + half + "0}\n"), "");
  EXPECT_THAT(refusal("scans:\n  a: " + half + "0}\n  b: " + half + "0}\n"),
              HasSubstr("2880000 beams a second together"));
  EXPECT_THAT(refusal("scans:\n  a: " + half + "2}\n"),
              HasSubstr("2880000 beams on the way together"));
  EXPECT_THAT(refusal("edges:\n  c: {spacing_m: 0.1, reach_m: 60}\n"),
              HasSubstr("spacing_m is 0.1, and reach_m more than 200 times that"));
  EXPECT_THAT(refusal("edges:\n  c: {beams_deg: [0]}\n"), HasSubstr("beams_deg"));
}

}  // namespace road_sensors_test
