#include "road_devices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "support/oval_road.h"
#include "vehicle/vec3.h"

namespace road_devices_test {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr sim::Pose kAtRest{};

/// A straight road along x from 0, from v = -6 to 6 m, with heights of its nodes.
std::shared_ptr<const crg::Surface> straight(double length_m,
                                             const std::function<double(double, double)>& z_m) {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 0.1;
  const auto rows = static_cast<std::size_t>(std::lround(length_m / grid.u_step_m)) + 1;
  for (int j = -60; j <= 60; ++j) grid.v_m.push_back(0.1 * j);
  for (std::size_t i = 0; i < rows; ++i) {
    line.x_m.push_back(grid.u_of(i));
    for (const double v_m : grid.v_m)
      grid.z_m.push_back(static_cast<float>(z_m(grid.u_of(i), v_m)));
  }
  line.y_m.assign(rows, 0.0);
  line.heading_rad.assign(rows, 0.0);
  return std::make_shared<const crg::Surface>(crg::make_crg(line, grid));
}

std::shared_ptr<const crg::Surface> of(const test_support::Oval& oval) {
  return std::make_shared<const crg::Surface>(crg::make_crg(oval.line, oval.grid));
}

vehicle::ScanSensor lidar() {
  vehicle::ScanSensor out;
  out.name = "lidar";
  out.beams_rad = {-2.0 * kDegree, -5.0 * kDegree, -30.0 * kDegree};
  out.field_rad = 360.0 * kDegree;
  out.step_rad = 2.0 * kDegree;
  out.reach_m = 40.0;
  return out;
}

vehicle::EdgeSensor camera() {
  vehicle::EdgeSensor out;
  out.name = "camera";
  out.mounting.at_m = {1.5, 0.0, 0.8};
  out.field_rad = 100.0 * kDegree;
  out.reach_m = 40.0;
  return out;
}

double range(const sim::ScanPoint& point) {
  return std::hypot(std::hypot(point.x_m, point.y_m), point.z_m);
}

/// The point of a sensor's frame on the map.
vehicle::Vec3<double> on_map(const std::array<double, 3>& point, const vehicle::Mounting& mounting,
                             const sim::Pose& pose) {
  const auto& turned = mounting.turned_rad;
  const auto& at = mounting.at_m;
  const vehicle::Vec3<double> in_car =
      vehicle::rotation(turned[0], turned[1], turned[2]).apply({point[0], point[1], point[2]}) +
      vehicle::Vec3<double>{at[0], at[1], at[2]};
  return vehicle::rotation(pose[3], pose[4], pose[5]).apply(in_car) +
         vehicle::Vec3<double>{pose[0], pose[1], pose[2]};
}

TEST(RoadDevices, OnAFlatRoadRangesAreThoseOfGeometry) {
  sim::NearbyRoad road(straight(200.0, [](double, double) { return 0.0; }));
  vehicle::ScanSensor sensor = lidar();
  sensor.mounting.at_m = {1.0, 0.0, 0.6};
  const sim::Pose pose{100.0, 0.0, 0.3, 0.0, 0.0, 0.0};  // so the sensor is 0.9 m above the road
  const sim::Scan scan = sim::scan_road(road, sensor, pose, base::Random(1));
  // 2 degrees: 25.8 m away; 6 m aside are reached within 13.4 degrees of ahead or behind, so by
  // azimuths of -13 to 13 degrees in steps of 2, twice. 5 degrees: 10.3 m away, asin(6 / 10.287)
  // = 35.7 degrees: 18 azimuths each way. 30 degrees: 1.6 m away, on the road all round.
  std::array<int, 3> hits{};
  for (const sim::ScanPoint& point : scan.points) {
    EXPECT_NEAR(point.z_m, -0.9, 1e-5);
    const double down = 0.9 / range(point);
    const std::size_t beam = down > 0.3 ? 2 : down > 0.05 ? 1 : 0;
    EXPECT_NEAR(range(point), 0.9 / std::sin(-sensor.beams_rad[beam]), 2e-4) << beam;
    EXPECT_NEAR(point.intensity, down, 1e-5) << "the cosine to the upright normal";
    EXPECT_LE(std::abs(point.y_m), 6.0 + 1e-4);
    ++hits[beam];
  }
  EXPECT_THAT(hits, testing::ElementsAre(28, 72, 180));

  // Mounted nose down by 10 degrees with one beam along its axis: the place ahead is 0.9 / tan 10
  // degrees; the same by the car's own pitch; by yaw it lies to the left.
  sensor.beams_rad = {0.0};
  sensor.field_rad = sensor.step_rad = 1.0 * kDegree;
  sensor.mounting.turned_rad = {0.0, 10.0 * kDegree, 0.0};
  const auto one = [&](const sim::Pose& at) {
    const sim::Scan seen = sim::scan_road(road, sensor, at, base::Random(1));
    EXPECT_EQ(seen.points.size(), 1u);
    const sim::ScanPoint& p = seen.points.at(0);
    EXPECT_NEAR(p.y_m, 0.0, 1e-6) << "in the frame of the sensor it is ahead";
    return on_map({p.x_m, p.y_m, p.z_m}, sensor.mounting, at);
  };
  EXPECT_NEAR(one(pose).x, 101.0 + 0.9 / std::tan(10.0 * kDegree), 1e-4);
  sensor.mounting.turned_rad[1] = 0.0;
  sensor.mounting.at_m = {0.0, 0.0, 0.6};
  const auto pitched = one({100.0, 0.0, 0.3, 0.0, 10.0 * kDegree, 0.0});
  const double height_m = 0.3 + 0.6 * std::cos(10.0 * kDegree);
  EXPECT_NEAR(pitched.x,
              100.0 + 0.6 * std::sin(10.0 * kDegree) + height_m / std::tan(10.0 * kDegree), 1e-4);
  sensor.mounting.turned_rad = {0.0, 20.0 * kDegree, 90.0 * kDegree};
  EXPECT_NEAR(one(pose).y, 0.9 / std::tan(20.0 * kDegree), 1e-4) << "to the left";
}

TEST(RoadDevices, PointsLieOnTheRoadWithBankingHillsKerbsAndRoughness) {
  test_support::OvalOptions options;
  options.iso_class = 'C';
  test_support::Oval oval = test_support::oval_road(options);
  const auto surface = of(oval);
  sim::NearbyRoad road(surface);
  vehicle::ScanSensor sensor = lidar();
  sensor.beams_rad.clear();
  for (int k = 0; k < 16; ++k) sensor.beams_rad.push_back(-(1.0 + 2.0 * k) * kDegree);
  sensor.mounting = {{1.0, 0.2, 0.8}, {0.01, 0.02, -0.3}};
  crg::Cursor cursor;
  double worst_m = 0.0;
  std::size_t points = 0, on_kerbs = 0, astray = 0;
  for (double u_m = 5.0; u_m < 900.0; u_m += 45.0) {
    const crg::Sample here = surface->at_uv(u_m, 3.0);
    const sim::Pose pose{here.x_m, here.y_m, here.z_m + 0.3, 0.03, -0.02, here.heading_rad + 0.2};
    for (const sim::ScanPoint& p : sim::scan_road(road, sensor, pose, base::Random(1)).points) {
      const auto at = on_map({p.x_m, p.y_m, p.z_m}, sensor.mounting, pose);
      const crg::Sample there = surface->at_xy(at.x, at.y, cursor);
      ASSERT_TRUE(there.valid);
      const double off_m = std::abs(there.z_m - at.z);
      worst_m = std::max(worst_m, off_m);
      astray += off_m > 1e-5 ? 1 : 0;
      on_kerbs += std::abs(there.v_m) > 6.0 && std::abs(there.v_m) < 7.0 ? 1 : 0;
      ++points;
    }
  }
  EXPECT_GT(points, 20'000u);
  EXPECT_GT(on_kerbs, 500u);
  // Measured: one point of 47,675, off by 0.16 mm; there Newton leads away, and the triangle
  // stands.
  EXPECT_LE(worst_m, 0.001);
  EXPECT_LE(static_cast<double>(astray), 1e-4 * static_cast<double>(points)) << astray;
}

TEST(RoadDevices, AHillHidesWhatIsBehindIt) {
  // A ridge of 2 m, 4 m long, 20 m ahead; beyond it the road goes on.
  sim::NearbyRoad road(straight(100.0, [](double u_m, double) {
    return 2.0 * std::max(0.0, 1.0 - std::abs(u_m - 30.0) / 2.0);
  }));
  vehicle::ScanSensor sensor = lidar();
  sensor.field_rad = sensor.step_rad = 1.0 * kDegree;
  sensor.beams_rad = {-1.0 * kDegree};  // reaches the road 57 m ahead, were nothing there
  sensor.reach_m = 80.0;
  const auto points =
      sim::scan_road(road, sensor, {10.0, 0.0, 1.0, 0.0, 0.0, 0.0}, base::Random(1)).points;
  ASSERT_EQ(points.size(), 1u);
  // The ray 1 - x tan 1 degree meets the slope x - 18 of one in one.
  EXPECT_NEAR(points[0].x_m, 19.0 / (1.0 + std::tan(1.0 * kDegree)), 1e-4);
  EXPECT_NEAR(points[0].intensity, std::cos(44.0 * kDegree), 1e-4) << "the slope rises 45 degrees";
}

TEST(RoadDevices, EdgesAreThoseOfTheRoadsOwnGrid) {
  test_support::OvalOptions options;
  options.half_width_m = 9.0;
  test_support::Oval oval = test_support::oval_road(options);
  // Left of 7.05 m there is no road, and there is an island of it beyond.
  test_support::plant(
      oval, [](double, double v_m) { return v_m > 7.05 && v_m < 8.05 ? std::nan("") : 0.0; });
  const auto surface = of(oval);
  const vehicle::EdgeSensor sensor = camera();
  crg::Cursor cursor;
  for (const bool against : {false, true})
    for (const double u_m : {1.0, 310.0, 400.0, 800.0}) {  // from the seam to within bends
      const crg::Sample here = surface->at_uv(u_m, 1.0);
      const sim::Pose pose{here.x_m,       here.y_m,
                           here.z_m + 0.3, 0.01,
                           0.02,           here.heading_rad + (against ? std::numbers::pi : 0.0)};
      const sim::Edges edges = sim::see_edges(*surface, sensor, pose, base::Random(1));
      const auto check = [&](const std::vector<std::array<float, 3>>& points, double v_m) {
        EXPECT_GE(points.size(), 10u) << u_m << against;
        for (const auto& point : points) {
          const auto at = on_map({point[0], point[1], point[2]}, {}, pose);
          const crg::Sample there = surface->at_xy(at.x, at.y, cursor);
          EXPECT_NEAR(there.v_m, v_m, 2e-5);
          EXPECT_NEAR(at.z, surface->z_at_uv(there.u_m, v_m > 0 ? v_m - 1e-4 : v_m + 1e-4), 2e-3);
          const double x_m = point[0] - 1.5;
          EXPECT_LE(std::atan2(std::abs(point[1]), x_m), 50.001 * kDegree);
          EXPECT_LE(std::hypot(std::hypot(x_m, point[1]), point[2] - 0.8), 40.001);
        }
        for (std::size_t k = 1; k < points.size(); ++k)
          EXPECT_LT(std::hypot(points[k][0] - points[k - 1][0], points[k][1] - points[k - 1][1]),
                    1.3)
              << "one after the other";
        EXPECT_LT(std::hypot(points.front()[0], points.front()[1]),
                  std::hypot(points.back()[0], points.back()[1]))
            << "from near to far";
      };
      check(against ? edges.right_m : edges.left_m, 7.0);
      check(against ? edges.left_m : edges.right_m, -9.0);
    }
}

TEST(RoadDevices, NoiseAndLossesAreThoseOfTheFile) {
  const auto surface = straight(200.0, [](double, double) { return 0.0; });
  sim::NearbyRoad road(surface);
  vehicle::ScanSensor sensor = lidar();
  sensor.beams_rad = {-30.0 * kDegree};
  sensor.noise_m = 0.03;
  sensor.lost = 0.1;
  const sim::Pose pose{100.0, 0.0, 0.9, 0.0, 0.0, 0.0};
  std::vector<double> off_m;
  std::size_t beams = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const sim::Scan scan = sim::scan_road(road, sensor, pose, base::Random(seed));
    beams += sensor.columns();
    for (const sim::ScanPoint& point : scan.points) off_m.push_back(range(point) - 1.8);
  }
  const auto spread = [](const std::vector<double>& values) {
    double mean = 0.0, square = 0.0;
    for (const double value : values) mean += value / static_cast<double>(values.size());
    for (const double value : values) square += (value - mean) * (value - mean);
    return std::array{mean, std::sqrt(square / static_cast<double>(values.size() - 1))};
  };
  EXPECT_NEAR(spread(off_m)[1], 0.03, 0.05 * 0.03);
  EXPECT_NEAR(spread(off_m)[0], 0.0, 0.001);
  EXPECT_NEAR(1.0 - static_cast<double>(off_m.size()) / static_cast<double>(beams), 0.1, 0.005);

  vehicle::EdgeSensor eye = camera();
  const std::size_t all = sim::see_edges(*surface, eye, pose, base::Random(1)).left_m.size();
  eye.noise_rad = 0.002;
  eye.lost = 0.2;
  std::vector<double> turned;
  std::size_t seen = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const sim::Edges edges = sim::see_edges(*surface, eye, pose, base::Random(seed));
    seen += edges.left_m.size();
    for (const auto& p : edges.left_m) {
      // Elevation alone: the true one is that of a point 1.7 m lower at the same distance.
      const double range_m = std::hypot(std::hypot(p[0] - 1.5, p[1]), p[2] - 0.8);
      turned.push_back(std::asin((p[2] - 0.8) / range_m) - std::asin(-1.7 / range_m));
    }
  }
  EXPECT_NEAR(spread(turned)[1], 0.002, 0.05 * 0.002);
  EXPECT_NEAR(static_cast<double>(seen) / static_cast<double>(300 * all), 0.8, 0.02);
}

TEST(RoadDevices, LooksArriveAfterTheirDelayAndAreTheSameAgain) {
  const auto surface = straight(200.0, [](double, double v_m) { return 0.05 * v_m; });
  vehicle::RoadSensorFile file;
  file.scans = {lidar()};
  file.scans[0].clock = {20.0, 0.03};
  file.scans[0].noise_m = 0.02;
  file.scans[0].lost = 0.1;
  file.edges = {camera()};
  file.edges[0].clock = {50.0, 0.0};
  file.edges[0].noise_rad = 0.01;
  struct Arrival {
    int step;
    std::string text;
  };
  const auto drive = [&](sim::RoadDevices& devices) {
    std::vector<Arrival> out;
    for (int step = 0; step <= 12; ++step) {  // of 10 ms
      devices.step({100.0 + 0.3 * step, 0.0, 0.5, 0.0, 0.0, 0.0});
      for (const sim::ToldSight& seen : devices.arrived())
        for (const std::string& text : seen.json) out.push_back({step, text});
    }
    return out;
  };
  sim::RoadDevices devices(surface, file, 7, 0.01, true);
  const std::vector<Arrival> first = drive(devices);
  std::vector<int> scans, edges;
  for (const Arrival& one : first)
    (one.text.starts_with(R"({"scan":"lidar")") ? scans : edges).push_back(one.step);
  EXPECT_THAT(scans, testing::ElementsAre(3, 8)) << "taken at steps 0 and 5, 30 ms ago";
  EXPECT_THAT(edges, testing::ElementsAre(0, 2, 4, 6, 8, 10, 12));
  EXPECT_NE(first[0].text.find(R"("time_s":0)"), std::string::npos);

  const auto texts = [](const std::vector<Arrival>& all) {
    std::vector<std::string> out;
    for (const Arrival& one : all) out.push_back(one.text);
    return out;
  };
  devices.restart();
  EXPECT_EQ(texts(drive(devices)), texts(first)) << "a reset";
  sim::RoadDevices other(surface, file, 8, 0.01, true);
  EXPECT_NE(texts(drive(other)), texts(first)) << "another seed";

  // A second car on the same road, and another sensor, change nothing.
  vehicle::RoadSensorFile both = file;
  both.scans.push_back(lidar());
  both.scans[1].name = "rear";
  sim::RoadDevices a(surface, both, 7, 0.01, true), b(surface, file, 7, 0.01, true);
  std::vector<std::string> of_b, lidar_of_a;
  for (int step = 0; step <= 12; ++step) {
    a.step({100.0 + 0.3 * step, 0.0, 0.5, 0.0, 0.0, 0.0});
    b.step({50.0 + 0.1 * step, 1.0, 0.5, 0.0, 0.0, 0.0});
    for (const sim::ToldSight& seen : a.arrived())
      for (const std::string& text : seen.json)
        if (!text.starts_with(R"({"scan":"rear")")) lidar_of_a.push_back(text);
    b.arrived();
  }
  EXPECT_EQ(lidar_of_a, texts(first));
}

TEST(RoadDevices, InRealTimeNothingIsWaitedForAndLateLooksAreLeftOut) {
  const auto surface = straight(200.0, [](double, double) { return 0.0; });
  vehicle::RoadSensorFile file;
  file.scans = {lidar()};
  file.scans[0].clock = {1000.0, 0.0};  // far more than can be worked out
  file.scans[0].step_rad = 0.1 * kDegree;
  sim::RoadDevices devices(surface, file, 7, 0.001, false);
  std::size_t told = 0;
  double last_s = -1.0;
  const auto begin = std::chrono::steady_clock::now();
  constexpr int kSteps = 2000;
  for (int step = 0; step < kSteps; ++step) {
    devices.step({100.0, 0.0, 0.5, 0.0, 0.0, 0.0});
    for (const sim::ToldSight& seen : devices.arrived()) {
      ++told;
      const double time_s = std::get<sim::Scan>(seen.sight).time_s;
      EXPECT_GT(time_s, last_s) << "in their order";
      last_s = time_s;
    }
  }
  const double took_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_LT(took_s, 2.0) << "a scan takes some 20 ms; 2000 of them would take 40 s";
  EXPECT_GE(devices.left_out(), 1000u);
  EXPECT_LE(told + devices.left_out(), static_cast<std::size_t>(kSteps));
  EXPECT_GE(told + devices.left_out() + sim::RoadDevices::kMostLate,
            static_cast<std::size_t>(kSteps));
  EXPECT_GE(told, 1u) << "the first is waited for";
}

TEST(RoadDevices, TrianglesOfALongRoadAreForgottenAndMadeAgain) {
  sim::NearbyRoad road(straight(4000.0, [](double, double v_m) { return 0.01 * v_m; }));
  const road::Ray down{{10.0, 1.0, 1.0}, {0.0, 0.0, -1.0}};
  std::size_t most = 0;
  for (double x_m = 0.0; x_m <= 4000.0; x_m += 10.0) {
    road.look_around({x_m, 0.0, 1.0}, 30.0);
    most = std::max(most, road.stretches_held());
  }
  EXPECT_GT(most, 10u);
  EXPECT_LE(most, 64u + 4u) << "4 stretches of 25 m are needed, 64 kept";
  EXPECT_FALSE(road.first_hit(down, 0.1, 5.0)) << "not looked at";
  road.look_around({10.0, 1.0, 1.0}, 30.0);
  const auto hit = road.first_hit(down, 0.1, 5.0);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->range_m, 0.99, 1e-6);
}

TEST(RoadDevices, RefusesWhatCannotBe) {
  vehicle::RoadSensorFile file;
  file.scans = {lidar()};
  EXPECT_THROW(sim::RoadDevices(nullptr, file, 1, 0.01, true), base::Error);
  file.scans[0].clock.rate_hz = 200.0;
  EXPECT_THROW(
      sim::RoadDevices(straight(10.0, [](double, double) { return 0.0; }), file, 1, 0.01, true),
      base::Error);
  sim::RoadDevices none(nullptr, {}, 1, 0.01, true);
  none.step(kAtRest);
  EXPECT_TRUE(none.arrived().empty());
  // A unit that has gone astray sees nothing.
  sim::NearbyRoad road(straight(10.0, [](double, double) { return 0.0; }));
  sim::Pose lost{};
  lost[0] = std::nan("");
  EXPECT_TRUE(sim::scan_road(road, lidar(), lost, base::Random(1)).points.empty());
  const auto surface = straight(10.0, [](double, double) { return 0.0; });
  for (const double far_m : {1e12, -1e12, 1e200, 1e308}) {
    lost[0] = far_m;
    EXPECT_TRUE(sim::scan_road(road, lidar(), lost, base::Random(1)).points.empty());
    const sim::Edges seen = sim::see_edges(*surface, camera(), lost, base::Random(1));
    EXPECT_TRUE(seen.left_m.empty() && seen.right_m.empty());
  }
}

}  // namespace road_devices_test
