#include "sim/serve_unit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <thread>

#include "base/error.h"
#include "base/json_text.h"
#include "sim/dds.h"
#include "some_unit.h"
#include "support/demo_circuit.h"
#include "support/figure.h"
#include "support/own_domain.h"
#include "support/places.h"
#include "support/run_tool.h"
#include "unit_driver.h"

namespace serve_unit_test {

using sim_tests::Driver, sim_tests::description_2, sim_tests::scalar_2, sim_tests::write_unit;
using ::testing::HasSubstr;

const std::string kThrough = description_2(
    "through", scalar_2("a", 10, "input") + scalar_2("n", 11, "input", "Integer") +
                   scalar_2("b", 20, "output") + scalar_2("m", 21, "output", "Integer"));

sim::ServeOptions options_of(const support::TemporaryFolder& folder) {
  sim::ServeOptions options;
  options.socket_path = folder.path("s");
  options.commands = {"a", "n"};
  options.measurements = {"b", "m"};
  options.step_s = 0.01;
  options.stop_s = 0.5;
  return options;
}

TEST(ServeUnit, InLockstepEveryCommandIsFollowedByItsSteps) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, kThrough, 2);
  sim::ServeOptions options = options_of(folder);
  options.lockstep = true;
  options.every = 5;
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    driver.say(R"({"sequence": 1, "set": {"a": 0.5, "n": 3}})");
    EXPECT_EQ(
        driver.hear(),
        base::parse_json<nlohmann::json>(
            R"({"sequence": 1, "time_s": 0.05, "safe": false, "reset": false, "values": {"b": 0.5, "m": 3}})"));
    driver.say(R"({"sequence": 1, "set": {"a": 9}})");  // said again: not acted on again
    EXPECT_EQ(driver.hear().at("values").at("b"), 0.5);
    driver.say("nonsense");
    EXPECT_EQ(driver.hear().at("refused"), "neither JSON nor KSC1");
    driver.say(R"({"sequence": 0, "set": {"a": 8}})");  // old
    EXPECT_EQ(driver.hear().at("sequence"), 0);
    driver.say(R"({"sequence": 5, "set": {"a": -1}})");
    const nlohmann::json second = driver.hear();
    EXPECT_EQ(second.at("time_s"), 0.1);
    EXPECT_EQ(second.at("values").at("b"), -1.0);
    EXPECT_EQ(second.at("values").at("m"), 3.0) << "what a command does not name stays";
    driver.say(R"({"sequence": 6, "end": true})");
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_TRUE(run.counts.asked_to_end);
  EXPECT_EQ(run.counts.steps, 10u);
  EXPECT_EQ(run.counts.commands, 3u);
  EXPECT_EQ(run.counts.broken, 1u);
  EXPECT_EQ(run.counts.old, 1u);
  EXPECT_EQ(run.first_broken, "neither JSON nor KSC1");
  EXPECT_THAT(run.columns, testing::ElementsAre("time_s", "b", "m", "a", "n", "safe", "resets"));
  EXPECT_EQ(run.rows(), 3u);
  EXPECT_FALSE(std::filesystem::exists(options.socket_path));
}

TEST(ServeUnit, TheRecordHasEveryColumnOnce) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, kThrough, 2);
  sim::ServeOptions options = options_of(folder);
  options.lockstep = true;
  options.devices.commands = {{"a", "a", 1.0, 0.0, -0.5, 0.5}};
  options.measurements = {"a", "b"};
  options.recorded = {"n", "b", "n"};
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    driver.say(R"({"sequence": 1, "set": {"a": 2}})");
    driver.hear();
    driver.say(R"({"sequence": 2, "end": true})");
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_THAT(run.columns, testing::ElementsAre("time_s", "a", "b", "n", "a.commanded",
                                                "n.commanded", "safe", "resets"));
  ASSERT_EQ(run.rows(), 2u);
  EXPECT_EQ(run.values[8 + 1], 0.5) << "what the unit has";
  EXPECT_EQ(run.values[8 + 4], 2.0) << "what was asked for";

  options.measurements = {"b", "b"};
  try {
    sim::serve_unit(unit, options);
    FAIL() << "no error";
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("two columns b; name it once"));
  }
}

TEST(ServeUnit, InLockstepOnlyACommandEndsTheWaiting) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, kThrough, 2);
  sim::ServeOptions options = options_of(folder);
  options.lockstep = true;
  options.patience_s = 0.5;
  std::thread bothers([&] {
    const Driver driver(options.socket_path);
    for (int k = 0; k < 500 && std::filesystem::exists(options.socket_path); ++k) {
      driver.say(k % 2 == 0 ? R"({"watch": true})" : "nonsense");
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_FALSE(std::filesystem::exists(options.socket_path)) << "after 5 s it still waits";
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  bothers.join();
  EXPECT_TRUE(run.counts.silent);
  EXPECT_EQ(run.counts.steps, 0u);
  EXPECT_GT(run.counts.broken, 0u);
}

TEST(ServeUnit, InRealTimeTheSafeInputActsWhenCommandsStayOut) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, kThrough, 2);
  sim::ServeOptions options = options_of(folder);
  options.stop_s = 1.0;
  options.every = 1;
  options.safe_after_s = 0.2;
  options.safe = {{"a", -7.0}};
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    driver.say(R"({"sequence": 100, "set": {"a": 2}})");  // and then nothing more
    for (int k = 0; k < 200; ++k) driver.say("{\"set\": {\"a\": NaN}}");
  });
  const auto begin = std::chrono::steady_clock::now();
  const sim::ServeRun run = sim::serve_unit(unit, options);
  const double took_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  drives.join();
  EXPECT_EQ(run.counts.steps, 100u);
  EXPECT_GE(took_s, 0.95) << "real time";
  EXPECT_EQ(run.counts.commands, 1u);
  EXPECT_EQ(run.counts.broken, 200u);
  // Taken early in the run, acting for 0.2 s, then the safe input.
  const std::size_t last = run.rows() - 1;
  EXPECT_EQ(run.values[last * 7 + 1], -7.0);
  EXPECT_EQ(run.values[last * 7 + 5], 1.0);
  std::size_t acted = 0;
  for (std::size_t i = 0; i < run.rows(); ++i) acted += run.values[i * 7 + 1] == 2.0 ? 1 : 0;
  EXPECT_GE(acted, 19u);
  EXPECT_LE(acted, 21u);
  EXPECT_EQ(run.counts.safe_steps + 20, 100 - (run.counts.steps - run.counts.safe_steps - 20));
}

TEST(ServeUnit, APauseStopsTheClockOfTheUnit) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, kThrough, 2);
  sim::ServeOptions options = options_of(folder);
  options.stop_s = 0.6;
  options.every = 1;
  options.safe_after_s = 1.0;
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    driver.say(R"({"sequence": 1, "pause": true})");
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    driver.say(R"({"sequence": 2, "pause": false, "set": {"a": 3}})");
  });
  const auto begin = std::chrono::steady_clock::now();
  const sim::ServeRun run = sim::serve_unit(unit, options);
  const double took_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  drives.join();
  EXPECT_GE(took_s, 1.0) << "0.6 s of the unit and half a second of pause";
  EXPECT_EQ(run.counts.steps, 60u);
  EXPECT_EQ(run.counts.safe_steps, 0u) << "standing still is not staying out";
  EXPECT_EQ(run.values[(run.rows() - 1) * 7], 0.6);
  EXPECT_EQ(run.values[(run.rows() - 1) * 7 + 1], 3.0);
}

TEST(ServeUnit, RefusesInOneLine) {
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
  options.commands = {"b"};
  EXPECT_THAT(refusal(options), HasSubstr("b is no input of the unit"));
  options = options_of(folder);
  options.safe = {{"x", 1.0}};
  EXPECT_THAT(refusal(options), HasSubstr("the safe input x is no command of this run"));
  options = options_of(folder);
  options.measurements = {"none"};
  EXPECT_THAT(refusal(options), HasSubstr("no variable 'none'"));
  options = options_of(folder);
  folder.file("s", "a file");
  EXPECT_THAT(refusal(options), HasSubstr("no socket can be made there"));
  EXPECT_EQ(folder.read("s"), "a file");
  options = options_of(folder);
  options.socket_path = folder.path("t");
  options.lockstep = true;
  options.patience_s = 0.2;
  const sim::ServeRun silent = sim::serve_unit(unit, options);
  EXPECT_TRUE(silent.counts.silent);
}

TEST(ServeUnit, SensorsTellTheirOwnAndTheRecordHasTheTruth) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(folder, kThrough, 2);
  sim::ServeOptions options = options_of(folder);
  options.lockstep = true;
  options.every = 1;
  options.stop_s = 0.2;
  vehicle::SignalSensor slow;
  slow.name = "slow.b";
  slow.signal = "b";
  slow.rate_hz = 20.0;  // a step is 10 ms
  slow.delay_s = 0.02;
  slow.gain = 10.0;
  options.devices = {1, {slow}, {{"percent", "a", 0.01, 0.0, 0.0, 1.0}}, {{"fix", 0, 0}}};
  options.measurements = {"slow.b.age_s", "m", "slow.b", "fix.longitude_deg"};
  options.recorded = {"b"};
  EXPECT_THROW(sim::serve_unit(unit, options), base::Error) << "no road tells the place";
  options.to_latitude_longitude_deg = [](double x_m, double y_m) {
    return std::array{48.0 + 1e-5 * y_m, 11.0 + 1e-5 * x_m};
  };
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    for (int k = 1; k <= 20; ++k) {
      driver.say(fmt::format(R"({{"sequence": {}, "set": {{"a": {}}}}})", k, k));
      const nlohmann::json told = driver.hear();
      EXPECT_FALSE(told.at("values").contains("b"));
    }
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_THAT(run.columns,
              testing::ElementsAre("time_s", "slow.b.age_s", "m", "slow.b", "fix.longitude_deg",
                                   "b", "a", "n", "safe", "resets"));
  ASSERT_EQ(run.rows(), 21u);
  // After step 10 (0.1 s) a sample comes, of step 8; four steps later it is still there.
  EXPECT_EQ(run.values[10 * 10 + 5], 10.0);
  EXPECT_EQ(run.values[10 * 10 + 3], 80.0);
  EXPECT_EQ(run.values[10 * 10 + 4], 11.0 + 1e-5 * 80.0);
  EXPECT_NEAR(run.values[10 * 10 + 1], 0.02, 1e-12);
  EXPECT_EQ(run.values[14 * 10 + 3], 80.0);
  EXPECT_NEAR(run.values[14 * 10 + 1], 0.06, 1e-12);
  EXPECT_EQ(run.values[15 * 10 + 3], 130.0);

  // A pedal in per cent, held within what the unit takes.
  options.commands = {"percent"};
  options.every = 1;
  std::thread presses([&] {
    const Driver driver(options.socket_path);
    driver.say(R"({"sequence": 1, "set": {"percent": 40}})");
    driver.hear();
    driver.say(R"({"sequence": 2, "set": {"percent": 140}})");
    driver.hear();
    driver.say(R"({"sequence": 3, "end": true})");
  });
  const sim::ServeRun pressed = sim::serve_unit(unit, options);
  presses.join();
  ASSERT_EQ(pressed.rows(), 3u);
  EXPECT_EQ(pressed.columns[6], "percent");
  EXPECT_EQ(pressed.values[9 + 5], 0.4);
  EXPECT_EQ(pressed.values[9 + 6], 40.0);
  EXPECT_EQ(pressed.values[2 * 9 + 5], 1.0);

  options.devices.sensors[0].name = "m";
  try {
    sim::serve_unit(unit, options);
    FAIL() << "no error";
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("the sensor m has the name of a variable of the unit"));
  }
}

TEST(ServeUnit, AResetBeginsAnewAndGivesTheSame) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(
      folder,
      description_2(
          "decay",
          scalar_2("x", 1, "output") +
              R"(<ScalarVariable name="k" valueReference="3" causality="parameter" variability="tunable"><Real start="1"/></ScalarVariable>)" +
              scalar_2("a", 10, "input")),
      2);
  sim::ServeOptions options = options_of(folder);
  options.lockstep = true;
  options.every = 10;
  options.stop_s = 5.0;
  options.commands = {"a", "k"};
  options.starts = {{"k", "2"}};
  vehicle::SignalSensor noisy;
  noisy.name = "noisy";
  noisy.signal = "x";
  noisy.noise = 0.1;
  options.devices = {1, {noisy}, {}, {}};
  options.measurements = {"x", "noisy"};
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    const auto ask = [&](const std::string& text) {
      driver.say(text);
      return driver.hear();
    };
    const auto first = ask(R"({"sequence": 1})"), second = ask(R"({"sequence": 2})");
    EXPECT_EQ(first.at("reset"), false);
    EXPECT_LT(second.at("values").at("x"), first.at("values").at("x"));
    const auto anew = ask(R"({"sequence": 3, "reset": {}})");
    EXPECT_EQ(anew.at("reset"), true);
    EXPECT_EQ(anew.at("time_s"), 0.0);
    EXPECT_EQ(anew.at("values").at("x"), 1.0);
    const auto again = ask(R"({"sequence": 4})");
    EXPECT_EQ(again.at("time_s"), first.at("time_s"));
    EXPECT_EQ(again.at("values"), first.at("values")) << "the noise too";
    ask(R"({"sequence": 5, "reset": {"k": 0}})");
    EXPECT_EQ(ask(R"({"sequence": 6})").at("values").at("x"), 1.0) << "another start: no decay";
    EXPECT_LT(ask(R"({"sequence": 7, "set": {"k": 1}})").at("values").at("x"), 1.0)
        << "a parameter that may change while the unit runs";
    EXPECT_TRUE(ask(R"({"sequence": 8, "reset": {"x": 3}})").contains("refused")) << "no start";
    driver.say(R"({"sequence": 9, "end": true})");
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_EQ(run.counts.resets, 2u);
  EXPECT_EQ(run.counts.broken, 1u);
  EXPECT_THAT(run.first_broken, HasSubstr("no number of a parameter or input"));
  EXPECT_TRUE(run.counts.asked_to_end);
}

using Places = std::vector<std::pair<double, double>>;

/// Of a table, the column of this name and the one after it.
Places places_of(const std::string& text, const std::string& name) {
  Places out;
  std::istringstream rows(text);
  std::string row, cell;
  std::getline(rows, row);
  std::size_t column = 0;
  for (std::istringstream names(row); std::getline(names, cell, ',') && cell != name;) ++column;
  while (std::getline(rows, row)) {
    std::istringstream cells(row);
    for (std::size_t k = 0; k <= column; ++k) std::getline(cells, cell, ',');
    const double x_m = std::stod(cell);
    std::getline(cells, cell, ',');
    out.emplace_back(x_m, std::stod(cell));
  }
  return out;
}

/// How far the car gets from a line, m: car.x and car.y of a record, the line's first columns.
double largest_distance_m(const std::string& record, const std::string& line) {
  const Places middle = places_of(line, line.substr(0, line.find(',')));
  double largest_m = 0.0;
  for (const auto& [x_m, y_m] : places_of(record, "car.x")) {
    double nearest_m = 1e9;
    for (const auto& [ax_m, ay_m] : middle)
      nearest_m = std::min(nearest_m, std::hypot(ax_m - x_m, ay_m - y_m));
    largest_m = std::max(largest_m, nearest_m);
  }
  return largest_m;
}

/// The stack of examples/stack, which knows the messages only, drives a lap of a road in each form
/// of them. `make_road` is a line of a shell script. How far the car was from the line in truth, m.
double largest_distance_of_a_lap_m(const support::TemporaryFolder& folder,
                                   const std::string& make_road, const std::string& road,
                                   const std::string& forms, const std::string& more = "",
                                   const std::string& devices = "devices.yaml") {
  folder.file("all.sh", fmt::format(
                            R"(set -e; cd '{0}'
{1}
{2} export {3} -o line.csv --quiet
{4} fmu {5}/vehicles/open_wheel/vehicle.yaml --road {3} -o car.fmu --quiet
for form in {6}; do
  by="--socket s"; where=s; is_there="test -S s"; says=$form
  case $form in dds*) by="--dds --domain {9}"; where={9}; is_there=true; says=dds;; esac
  {7} serve car.fmu $by --lockstep --every 10 --stop-s 300 --patience-s 20 -o $form.csv \
    --command input.steering --command input.throttle --command input.brake.fl --command input.brake.fr \
    --command input.brake.rl --command input.brake.rr --command input.gear \
    --devices {5}/examples/stack/{10} {11} --measure gnss.x --measure gnss.y --measure gnss.x.age_s \
    --measure imu.yaw_rate --measure wheels.vx --record car.x --record car.y > $form.log &
  until $is_there; do sleep 0.05; done
  {8} $where line.csv $says >> lap.log
  wait $!
done)",
                            folder.path("."), make_road, places::crgbuild(), road,
                            places::crgdrive(), places::source(), forms, places::crgsim(),
                            EXAMPLE_STACK, places::own_domain(), devices, more));
  EXPECT_EQ(std::system(
                ("timeout 200 bash " + folder.path("all.sh") + " > " + folder.path("log") + " 2>&1")
                    .c_str()),
            0)
      << folder.read("log") << folder.read("lap.log");
  if (testing::Test::HasFailure()) return 1e9;
  EXPECT_THAT(folder.read("lap.log"), HasSubstr("lap in "));
  EXPECT_THAT(folder.read("binary.log"), HasSubstr("ended by a command"));
  const double off_m = largest_distance_m(folder.read("binary.csv"), folder.read("line.csv"));
  std::printf("%strue: at most %.2f m from the line\n", folder.read("lap.log").c_str(), off_m);
  return off_m;
}

// The roads are 10 m wide and more; 0.3 m of what is allowed are the receiver's bias. Measured:
// 0.66 to 1.25 m.
constexpr double kOnTheRoad_m = 3.0;

TEST(ServeUnit, AStackDrivesALap) {
  const support::TemporaryFolder folder;
  const std::string make =
      fmt::format("{} synth {} -o demo --quiet", places::crgbuild(), support::demo_circuit());
  const bool has_dds = !sim::dds_version().empty(),
             again = has_dds && std::getenv("KERBSTONE_HEAVY") != nullptr;
  EXPECT_LE(largest_distance_of_a_lap_m(folder, make, "demo/kerbstone-ring_truth.crg",
                                        again     ? "json binary dds dds_again"
                                        : has_dds ? "json binary dds"
                                                  : "json binary"),
            kOnTheRoad_m);
  EXPECT_EQ(folder.read("json.csv"), folder.read("binary.csv"));
  if (!has_dds) GTEST_SKIP() << "no topics: built without Cyclone DDS";
  if (again) {
    EXPECT_EQ(folder.read("dds.csv"), folder.read("dds_again.csv")) << "whatever else runs";
  }
  // The same lap by topics: their stamps are nanoseconds, and the stack's times differ in rounding.
  const Places by_socket = places_of(folder.read("binary.csv"), "car.x"),
               by_dds = places_of(folder.read("dds.csv"), "car.x");
  ASSERT_EQ(by_dds.size(), by_socket.size());
  double apart_m = 0.0;
  for (std::size_t k = 0; k < by_dds.size(); ++k)
    apart_m = std::max(apart_m, std::hypot(by_dds[k].first - by_socket[k].first,
                                           by_dds[k].second - by_socket[k].second));
  std::printf("by topics: at most %.2g m from the lap by socket\n", apart_m);
  EXPECT_LE(apart_m, 1e-6);  // measured 2.5e-11
}

// A wind that rises to 15 m/s and a road that becomes wet, beside the sensors of the road: the lap
// is another one, and the same again.
TEST(SlowServeUnit, AStackDrivesInChangingWeatherWithSensorsOfTheRoad) {
  const support::TemporaryFolder folder;
  folder.file("weather.csv",
              "time_s,parameter.environment.wind_mps,parameter.environment.wind_heading_rad,"
              "parameter.environment.road_grip\n0,0,0,1\n10,15,1.57,1\n40,15,1.57,0.9\n");
  const std::string make =
      fmt::format("{} synth {} -o demo --quiet", places::crgbuild(), support::demo_circuit());
  EXPECT_LE(largest_distance_of_a_lap_m(
                folder, make, "demo/kerbstone-ring_truth.crg", "binary json",
                "--road demo/kerbstone-ring_truth.crg --inputs weather.csv --sights $form.jsonl",
                "road_sensors.yaml"),
            kOnTheRoad_m);
  EXPECT_EQ(folder.read("json.csv"), folder.read("binary.csv"));
  EXPECT_EQ(folder.read("json.jsonl"), folder.read("binary.jsonl"));
  const std::string table = folder.read("binary.csv");
  EXPECT_THAT(table.substr(0, table.find('\n')), HasSubstr("parameter.environment.road_grip"));
  const auto [wind_mps, heading_rad] = places_of(table, "parameter.environment.wind_mps").back();
  EXPECT_EQ(wind_mps, 15.0);
  EXPECT_EQ(heading_rad, 1.57);

  // What the camera saw of the road's edges: the car is between them, but in the narrowest bends,
  // where the first place in its field lies beyond the bend.
  std::istringstream lines(folder.read("binary.jsonl"));
  std::size_t scans = 0, edges = 0, between = 0, plans = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto said = base::parse_json<nlohmann::json>(line);
    scans += said.contains("scan") ? 1 : 0;
    plans += said.contains("plan") ? 1 : 0;
    if (!said.contains("edges") || said.at("left").empty() || said.at("right").empty()) continue;
    ++edges;
    between += said.at("left").at(0).at(1) > 0.0 && said.at("right").at(0).at(1) < 0.0 ? 1 : 0;
  }
  EXPECT_GT(scans, 400u);
  EXPECT_GT(edges, 800u);
  EXPECT_GE(between, edges * 9 / 10);
  EXPECT_GT(plans, 800u);
}

// Measured 0.25 m/s and 0.13 m; the paper has 0.46 m/s and 0.143 m, of a car whose parameters were
// known.
TEST(ServeUnit, AStackDrivesTheLineOfARecordedLapAtItsSpeed) {
  const std::string recording = places::data() + "/recordings/putnam_run4_2.csv";
  if (!std::filesystem::exists(recording)) GTEST_SKIP() << recording << " is absent";
  const support::TemporaryFolder folder;
  const std::string tools =
      std::filesystem::path(places::crgsim()).parent_path().parent_path().string();
  const std::string command = fmt::format(
      "timeout 200 python3 '{0}/examples/stack/recorded_lap.py' '{1}' '{2}' "
      "'{0}/vehicles/av21/vehicle.yaml' '{3}' 5939 9960 '{4}' > '{4}.log' 2>&1",
      places::source(), tools, EXAMPLE_STACK, recording, folder.path("lap"));
  ASSERT_EQ(std::system(command.c_str()), 0) << folder.read("lap.log");
  const auto errors = base::parse_json<nlohmann::json>(folder.read("lap/errors.json"));
  for (const std::string name : {"vx_mps", "lateral_m"})
    support::figure(name, errors.at(name).at("rmse").get<double>());
  EXPECT_LE(errors.at("vx_mps").at("rmse"), 0.4);
  EXPECT_LE(errors.at("lateral_m").at("rmse"), 0.2);
  EXPECT_LE(errors.at("heading_rad").at("rmse"), 0.05);
  EXPECT_LE(errors.at("sideslip_rad").at("rmse"), 0.03);
  // Predictors that know the lap up to 2 s before; of the sideslip this car knows no more.
  for (const char* name : {"vx_mps", "lateral_m", "heading_rad"})
    for (const char* trivial : {"hold_rmse", "trend_rmse"})
      EXPECT_LT(errors.at(name).at("rmse"), errors.at(name).at(trivial)) << name << ' ' << trivial;
}

class RealTrack : public testing::TestWithParam<const char*> {};

TEST_P(RealTrack, IsDrivenByTheStack) {
  const std::string track = GetParam();
  if (!std::filesystem::exists(fmt::format("{0}/road/{1}/{1}.acc", places::torcs_tracks(), track)))
    GTEST_SKIP() << "the package torcs-data is not installed";
  if (track != "g-track-1" && std::getenv("KERBSTONE_HEAVY") == nullptr)
    GTEST_SKIP() << "10 s each: KERBSTONE_HEAVY=1";
  const support::TemporaryFolder folder;
  const std::string make =
      fmt::format("{} build {}/tracks/{}/track.yaml -o out --quiet --no-report", places::crgbuild(),
                  places::source(), track);
  EXPECT_LE(largest_distance_of_a_lap_m(folder, make, "out/" + track + ".crg", "binary"),
            kOnTheRoad_m);
}

INSTANTIATE_TEST_SUITE_P(SlowServeUnit, RealTrack,
                         testing::Values("g-track-1", "e-track-3", "aalborg"),
                         [](const auto& track) {
                           std::string name = track.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace serve_unit_test
