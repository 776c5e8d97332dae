// What is seen of the road and what is planned, in runs of a unit that is served.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/error.h"
#include "base/json_text.h"
#include "sim/serve_unit.h"
#include "some_unit.h"
#include "unit_driver.h"

namespace serve_sights_test {

using sim_tests::Driver, sim_tests::description_2, sim_tests::scalar_2, sim_tests::write_unit;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kThrough = description_2(
    "through", scalar_2("a", 10, "input") + scalar_2("n", 11, "input", "Integer") +
                   scalar_2("b", 20, "output") + scalar_2("m", 21, "output", "Integer"));

/// A flat road along x from 0 to 200 m, 12 m wide.
std::shared_ptr<const crg::Surface> flat_road() {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 1.0;
  for (int j = -6; j <= 6; ++j) grid.v_m.push_back(j);
  for (int i = 0; i <= 200; ++i) line.x_m.push_back(i);
  line.y_m.assign(201, 0.0);
  line.heading_rad.assign(201, 0.0);
  grid.z_m.assign(201 * grid.columns(), 0.0f);
  return std::make_shared<const crg::Surface>(crg::make_crg(line, grid));
}

/// The unit's b is the car's x; whatever else tells its place is m, and 0.
sim::ServeOptions options_of(const support::TemporaryFolder& folder) {
  sim::ServeOptions options;
  options.socket_path = folder.path("s");
  options.commands = {"a"};
  options.measurements = {"b"};
  options.step_s = 0.01;
  options.stop_s = 0.5;
  options.lockstep = true;
  options.every = 10;
  options.road = flat_road();
  options.devices.road.pose = {"b", "m", "m", "m", "m", "m"};
  vehicle::ScanSensor scan;
  scan.name = "lidar";
  scan.clock = {20.0, 0.02};
  scan.mounting.at_m = {0.0, 0.0, 1.0};
  for (int k = 1; k <= 32; ++k) scan.beams_rad.push_back(-0.03 * k);
  scan.field_rad = 6.28;
  scan.step_rad = 0.02;
  scan.noise_m = 0.01;
  options.devices.road.scans = {scan};
  vehicle::EdgeSensor edges;
  edges.name = "camera";
  edges.clock = {10.0, 0.0};
  edges.mounting.at_m = {0.0, 0.0, 1.0};
  edges.field_rad = 2.0;
  options.devices.road.edges = {edges};
  return options;
}

TEST(ServeSights, ComeBeforeTheMeasurementInBothFormsAndAreRecorded) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, kThrough, 2);
  sim::ServeOptions options = options_of(folder);
  std::vector<std::string> lines;
  options.keep_sight = [&](std::string_view line) { lines.emplace_back(line); };
  std::vector<nlohmann::json> told;
  std::size_t binary_points = 0, binary_parts = 0;
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    driver.say(R"({"sequence": 1, "set": {"a": 50}, "plan": [[51, 0, 10], [52, 0.5, 11]]})");
    do told.push_back(driver.hear());
    while (!told.back().contains("values"));
    // The same by the binary form; nobody reads for a while, and nothing is lost.
    std::string command = "KSC1";
    for (const std::uint32_t number : {2u, 0u, 1u})
      command.append(reinterpret_cast<const char*>(&number), sizeof number);
    const double place_m = 60.0;
    command.append(reinterpret_cast<const char*>(&place_m), sizeof place_m);
    driver.say(command);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    for (std::string bytes; !bytes.starts_with("KSM1");) {
      bytes = driver.hear_bytes();
      if (!bytes.starts_with("KSS1")) continue;
      std::uint32_t count = 0;
      std::memcpy(&count, bytes.data() + 16, sizeof count);
      binary_points += count;
      ++binary_parts;
    }
    driver.say(R"({"sequence": 3, "end": true})");
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_TRUE(run.counts.asked_to_end);

  // Within the 10 steps: scans of 0 and 0.05 s, told at 0.02 and 0.07 s; edges at 0.1 s.
  std::vector<double> scan_s, edges_s;
  for (std::size_t k = 0; k + 1 < told.size(); ++k)
    if (told[k].contains("scan") && told[k].at("part") == 0)
      scan_s.push_back(told[k].at("time_s"));
    else if (told[k].contains("edges"))
      edges_s.push_back(told[k].at("time_s"));
  EXPECT_THAT(scan_s, ElementsAre(0.0, 0.05));
  EXPECT_THAT(edges_s, ElementsAre(0.1));
  const nlohmann::json& edges = told[told.size() - 2];
  for (const auto& point : edges.at("left")) EXPECT_NEAR(point.at(1), 6.0, 1e-5);
  for (const auto& point : edges.at("right")) EXPECT_NEAR(point.at(1), -6.0, 1e-5);
  for (const auto& point : edges.at("left")) EXPECT_NEAR(point.at(2), 0.0, 1e-5);
  EXPECT_GT(edges.at("left").size(), 30u);

  // The record has the same, and what was told at 0 s besides; scans are whole there.
  std::vector<std::string> kinds;
  std::size_t points_then = 0;
  for (const std::string& line : lines) {
    const auto said = base::parse_json<nlohmann::json>(line);
    kinds.push_back(said.contains("scan") ? "scan" : said.contains("edges") ? "edges" : "plan");
    if (said.contains("plan")) {
      EXPECT_EQ(said, base::parse_json<nlohmann::json>(
                          R"({"plan": [[51, 0, 10], [52, 0.5, 11]], "sequence": 1, "time_s": 0})"));
    }
    if (said.contains("scan")) {
      EXPECT_EQ(said.at("parts"), 1);
      if (said.at("time_s") > 0.09) points_then += said.at("points").size();
    }
  }
  EXPECT_THAT(kinds,
              ElementsAre("edges", "plan", "scan", "scan", "edges", "scan", "scan", "edges"));
  EXPECT_EQ(binary_points, points_then);
  EXPECT_GT(binary_parts, 2u) << "a scan of that size is split";

  // The same commands once more: the same lines.
  std::vector<std::string> again;
  options.keep_sight = [&](std::string_view line) { again.emplace_back(line); };
  std::thread drives_again([&] {
    const Driver driver(options.socket_path);
    driver.say(R"({"sequence": 1, "set": {"a": 50}, "plan": [[51, 0, 10], [52, 0.5, 11]]})");
    while (!driver.hear().contains("values")) {
    }
    driver.say(R"({"sequence": 2, "set": {"a": 60}})");
    while (!driver.hear().contains("values")) {
    }
    driver.say(R"({"sequence": 3, "end": true})");
  });
  sim::serve_unit(unit, options);
  drives_again.join();
  EXPECT_EQ(again, lines);
}

TEST(ServeSights, WhoeverWatchesGetsCopiesAndChangesNothing) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, kThrough, 2);
  sim::ServeOptions options = options_of(folder);
  options.devices.road.scans.clear();
  std::thread drives([&] {
    const Driver driver(options.socket_path), watcher(options.socket_path, "watcher");
    watcher.say(R"({"watch": true})");
    driver.say(R"({"sequence": 1, "set": {"a": 50}, "plan": [[51, 0, 10]]})");
    while (!driver.hear().contains("values")) {
    }
    EXPECT_EQ(watcher.hear().at("sequence"), 1) << "the plan";
    EXPECT_TRUE(watcher.hear().contains("edges"));
    EXPECT_EQ(watcher.hear().at("values").at("b"), 50.0);
    // Commands of the driver stay its own: measurements still go there.
    watcher.say(R"({"watch": true})");
    driver.say(R"({"sequence": 2, "set": {"a": 60}})");
    EXPECT_TRUE(driver.hear().contains("edges")) << "its plan is not told back";
    EXPECT_EQ(driver.hear().at("values").at("b"), 60.0);
    driver.say(R"({"sequence": 3, "end": true})");
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_EQ(run.counts.commands, 3u);
  EXPECT_EQ(run.counts.broken, 0u);
}

TEST(ServeSights, InRealTimeADiskThatIsSlowHoldsNoStepUp) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, kThrough, 2);
  sim::ServeOptions options = options_of(folder);
  options.devices.road = {};
  options.lockstep = false;
  options.every = 1;
  options.stop_s = 30.0;
  constexpr double kDisk_s = 2.0;
  std::size_t lines = 0;
  options.keep_sight = [&](std::string_view) {
    if (++lines == 1) std::this_thread::sleep_for(std::chrono::duration<double>(kDisk_s));
  };
  // Some 12 kB a plan: the pipe to the process that records holds 64 kB.
  std::string plan = "[0.123456789012, 1.123456789012, 2.0]";
  for (int k = 1; k < 300; ++k) plan += ",[0.123456789012, 1.123456789012, 2.0]";
  constexpr unsigned kPlans = 50;
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    for (unsigned k = 1; k <= kPlans; ++k) {
      driver.say(fmt::format(R"({{"sequence": {}, "plan": [{}]}})", k, plan));
      driver.hear();
    }
    driver.say(fmt::format(R"({{"sequence": {}, "end": true}})", kPlans + 1));
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_TRUE(run.counts.asked_to_end);
  EXPECT_LT(run.counts.latest_s, 0.5 * kDisk_s);
  EXPECT_EQ(lines, run.counts.commands - 1) << "all that was taken is recorded";
  EXPECT_GE(lines, kPlans / 2);
}

TEST(ServeSights, WithoutARoadOrItsPlaceTheyAreRefused) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, kThrough, 2);
  const auto refusal = [&](const sim::ServeOptions& options) -> std::string {
    try {
      sim::serve_unit(unit, options);
    } catch (const base::Error& error) {
      return error.what();
    }
    return "";
  };
  sim::ServeOptions options = options_of(folder);
  options.road = nullptr;
  EXPECT_THAT(refusal(options), HasSubstr("lidar looks at the road, and none was given"));
  options = options_of(folder);
  options.devices.road.pose[2] = "car.z";
  EXPECT_THAT(refusal(options), HasSubstr("no variable 'car.z'"));
}

TEST(ServeUnit, WhatFollowsATableActsByTheClockAndAfterAResetAgain) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(
      folder,
      description_2(
          "decay",
          scalar_2("x", 1, "output") +
              R"(<ScalarVariable name="k" valueReference="3" causality="parameter" variability="tunable"><Real start="1"/></ScalarVariable>)" +
              scalar_2("a", 10, "input")),
      2);
  sim::ServeOptions options;
  options.socket_path = folder.path("s");
  options.commands = {"a"};
  options.measurements = {"x"};
  options.step_s = 0.01;
  options.stop_s = 5.0;
  options.lockstep = true;
  options.every = 10;
  // No decay until 0.1 s, then the faster the later, until 0.3 s.
  options.inputs = {{"k"}, {0.0, 0.1, 0.3}, {0.0, 0.0, 4.0}};
  std::vector<double> x;
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    for (int k = 1; k <= 8; ++k) {
      driver.say(fmt::format(R"({{"sequence": {}{}}})", k, k == 5 ? R"(, "reset": {})" : ""));
      x.push_back(driver.hear().at("values").at("x"));
    }
    driver.say(R"({"sequence": 9, "end": true})");
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  ASSERT_EQ(x.size(), 8u);
  EXPECT_EQ(x[0], 1.0);
  EXPECT_LT(x[1], 0.99);
  EXPECT_LT(x[2] / x[1], x[1] / x[0]);
  EXPECT_EQ(x[4], 1.0) << "a reset";
  EXPECT_THAT(std::vector(x.begin() + 5, x.end()), ElementsAre(x[0], x[1], x[2]));
  // It is recorded: what acted in the step before.
  EXPECT_THAT(run.columns, ElementsAre("time_s", "x", "k", "a", "safe", "resets"));
  EXPECT_EQ(run.values[2], 0.0);
  EXPECT_NEAR(run.values[2 * 6 + 2], 4.0 * 0.09 / 0.2, 1e-12) << "before the step to 0.2 s";
  EXPECT_EQ(run.values[4 * 6 + 2], 4.0);

  options.inputs.names = {"x"};
  EXPECT_THROW(sim::serve_unit(unit, options), base::Error) << "an output";
  options.inputs.names = {"a"};
  EXPECT_THROW(sim::serve_unit(unit, options), base::Error) << "a command too";
}

}  // namespace serve_sights_test
