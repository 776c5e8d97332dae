// What a stack sends ends no run: all of it is answered, and the car can be begun anew.
#include "odd_commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "base/error.h"
#include "base/json_text.h"
#include "crg/file.h"
#include "fmu/export_unit.h"
#include "sim/serve_unit.h"
#include "some_unit.h"
#include "support/places.h"
#include "support/temporary_folder.h"
#include "unit_driver.h"

namespace odd_commands_test {

using sim_tests::Driver, sim_tests::description_2, sim_tests::scalar_2, sim_tests::write_unit;
using ::testing::HasSubstr;

/// Straight along x from 0 to 200 m, 12 m wide; from 196 m on nothing is known of its height.
void write_road(const std::string& path) {
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = 1.0;
  for (int j = -6; j <= 6; ++j) grid.v_m.push_back(j);
  for (int i = 0; i <= 200; ++i) line.x_m.push_back(i);
  line.y_m.assign(201, 0.0);
  line.heading_rad.assign(201, 0.0);
  grid.z_m.assign(201 * grid.columns(), 0.0f);
  std::fill(grid.z_m.begin() + 196 * static_cast<std::ptrdiff_t>(grid.columns()), grid.z_m.end(),
            std::numeric_limits<float>::quiet_NaN());
  crg::write(crg::make_crg(line, grid), path, crg::Format::KRBI);
}

std::string vehicle() { return places::source() + "/vehicles/open_wheel/vehicle.yaml"; }

sim::ServeOptions car_options(const support::TemporaryFolder& folder) {
  write_road(folder.path("road.crg"));
  sim::ServeOptions options;
  options.socket_path = folder.path("s");
  options.commands = {"input.steering", "input.throttle", "input.gear", "input.brake.fl",
                      "parameter.environment.road_grip"};
  options.measurements = {"car.x", "car.vx", "car.roll"};
  options.starts = {{"road", folder.path("road.crg")}, {"start.u", "10"}, {"input.gear", "2"}};
  options.lockstep = true;
  options.every = 5;
  options.stop_s = 1e6;
  options.keep_row = [](const auto&, const auto&) {};
  return options;
}

/// Sends a command and gives the answer.
nlohmann::json answer(const Driver& driver, const std::string& command) {
  driver.say(command);
  return driver.hear();
}

void expect_refused(const Driver& driver, const std::string& command, const std::string& why) {
  const nlohmann::json answered = answer(driver, command);
  EXPECT_THAT(answered.value("refused", ""), HasSubstr(why)) << command << " -> " << answered;
}

TEST(OddCommands, AreRefusedWithTheReasonAndChangeNothing) {
  const support::TemporaryFolder folder;
  sim::ServeOptions options = car_options(folder);
  std::vector<std::string> log;
  options.keep_remark = [&](std::string_view line) { log.emplace_back(line); };
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    EXPECT_EQ(answer(driver, R"({"sequence": 1, "set": {"input.throttle": 0.5}})").at("time_s"),
              0.005);
    expect_refused(driver, R"({"sequence": 2, "set": {"input.gear": 11}})", "-1 to 10 wanted");
    expect_refused(driver, R"({"sequence": 2, "set": {"input.gear": 2.5, "input.throttle": 1}})",
                   "input.gear = 2.5; a whole number");
    expect_refused(driver, R"({"sequence": 2, "reset": {"start.speed": 999}})", "-50 to 120");
    expect_refused(driver, R"({"sequence": 2, "reset": {"start.u": 900}})", "no road at start.u");
    expect_refused(driver, R"({"sequence": 2, "set": {"parameter.environment.road_grip": -5}})",
                   "0.01 to 3 wanted");
    expect_refused(driver, R"({"sequence": 2, "set": {"input.throttle": "full"}})",
                   "finite number");
    expect_refused(driver, R"({"sequence": 2, "set": {"input.throttle": 1e999}})", "1e308");
    expect_refused(driver, R"({"sequence": 2, "set": {"input.wings": 1}})", "'input.wings'");
    expect_refused(driver, R"({"sequence": 0})", "came after 1");
    expect_refused(driver, std::string(60'001, ' '), "longer than 60 kB");
    const nlohmann::json next = answer(driver, R"({"sequence": 2})");
    EXPECT_EQ(next.at("time_s"), 0.01) << "what was refused took no step";
    const nlohmann::json clipped =
        answer(driver, R"({"sequence": 3, "set": {"input.throttle": 7}})");
    EXPECT_THAT(clipped.at("clipped"), HasSubstr("1 is taken"));
    EXPECT_FALSE(answer(driver, R"({"sequence": 4})").contains("clipped"));
    driver.say(R"({"sequence": 5, "end": true})");
  });
  const sim::ServeRun run = sim::serve_unit(vehicle(), options);
  drives.join();
  EXPECT_EQ(run.counts.commands, 5u);
  EXPECT_EQ(run.counts.broken, 9u);
  EXPECT_EQ(run.counts.old, 1u);
  EXPECT_EQ(run.counts.clipped, 1u);
  EXPECT_EQ(run.counts.resets, 0u);
  ASSERT_EQ(log.size(), 11u) << "all that was said is kept";
  EXPECT_EQ(log[0], R"({"refused":"input.gear = 11; a number from -1 to 10 wanted","sequence":2,)"
                    R"("time_s":0.005,"resets":0})");
}

/// Over the end of the road, then anew; of a vehicle file and of a unit.
void drive_off_the_road(const std::string& unit, const support::TemporaryFolder& folder) {
  sim::ServeOptions options = car_options(folder);
  std::vector<double> times_s;
  options.keep_row = [&](const auto&, std::span<const double> row) { times_s.push_back(row[0]); };
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    answer(driver, R"({"sequence": 1, "reset": {"start.u": 190, "start.speed": 40}})");
    nlohmann::json last;
    std::uint32_t k = 2;
    for (; k < 200 && !last.contains("parked"); ++k)
      last = answer(driver, fmt::format(R"({{"sequence": {}}})", k));
    EXPECT_THAT(last.value("parked", ""), HasSubstr("no road under"));
    EXPECT_NEAR(last.at("values").at("car.vx").get<double>(), 40.0, 2.0);
    EXPECT_GT(last.at("values").at("car.x").get<double>(), 191.0);
    if (!last.contains("parked")) return driver.say(R"({"sequence": 999, "end": true})");
    const nlohmann::json still =
        answer(driver, fmt::format(R"({{"sequence": {}, "set": {{"input.steering": 0.1}}}})", k));
    EXPECT_EQ(still.at("values"), last.at("values"));
    EXPECT_EQ(still.at("time_s"), last.at("time_s")) << "it stands";
    EXPECT_EQ(still.at("parked"), last.at("parked"));
    expect_refused(driver, fmt::format(R"({{"sequence": {}, "reset": {{"start.u": 900}}}})", k + 1),
                   "no road at");
    const nlohmann::json anew =
        answer(driver, fmt::format(R"({{"sequence": {}, "reset": {{}}}})", k + 1));
    EXPECT_FALSE(anew.contains("parked"));
    EXPECT_EQ(anew.at("time_s"), 0.0);
    EXPECT_EQ(answer(driver, fmt::format(R"({{"sequence": {}}})", k + 2)).at("time_s"), 0.005);
    driver.say(fmt::format(R"({{"sequence": {}, "end": true}})", k + 3));
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_EQ(run.counts.parked, 1u);
  EXPECT_FALSE(run.counts.is_parked);
  EXPECT_THAT(run.first_parked, HasSubstr("no road under"));
  EXPECT_EQ(run.counts.resets, 2u);
  int begins = 0;
  for (std::size_t k = 1; k < times_s.size(); ++k) {
    if (times_s[k] == 0.0) ++begins;
    if (times_s[k] != 0.0) {
      EXPECT_GT(times_s[k], times_s[k - 1]) << "no row while it stands";
    }
  }
  EXPECT_EQ(begins, 2);
}

TEST(OddCommands, ACarThatLeavesTheRoadStandsUntilAReset) {
  const support::TemporaryFolder folder;
  drive_off_the_road(vehicle(), folder);
}

TEST(OddCommands, SoDoesTheUnitOfACar) {
  const support::TemporaryFolder folder;
  fmu::ExportOptions options;
  options.vehicle_path = vehicle();
  options.binary_path = places::kerbstone_car();
  drive_off_the_road(folder.file("car.fmu", fmu::export_unit(options).bytes), folder);
}

TEST(OddCommands, ACarThatRollsOverStandsAndGoesBackToASavedState) {
  const support::TemporaryFolder folder;
  sim::ServeOptions options = car_options(folder);
  options.starts = {{"start.speed", "30"},
                    {"input.gear", "3"},
                    {"parameter.chassis.cog_height_m", "0.6"},
                    {"parameter.environment.road_grip", "2"}};
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    const nlohmann::json saved = answer(driver, R"({"sequence": 1, "save": "upright"})");
    nlohmann::json last;
    std::uint32_t k = 2;
    for (; k < 1000 && !last.contains("parked"); ++k)
      last =
          answer(driver, fmt::format(R"({{"sequence": {}, "set": {{"input.steering": 2}}}})", k));
    EXPECT_THAT(last.value("parked", ""), HasSubstr("rolled over"));
    const nlohmann::json back =
        answer(driver, fmt::format(R"({{"sequence": {}, "reset": {{"state": "upright"}}}})", k));
    EXPECT_FALSE(back.contains("parked"));
    EXPECT_EQ(back.at("time_s"), 0.0);
    EXPECT_EQ(answer(driver, fmt::format(R"({{"sequence": {}}})", k + 1)).at("values"),
              saved.at("values"));
    driver.say(fmt::format(R"({{"sequence": {}, "end": true}})", k + 2));
  });
  const sim::ServeRun run = sim::serve_unit(vehicle(), options);
  drives.join();
  EXPECT_EQ(run.counts.parked, 1u);
}

TEST(OddCommands, AnErrorOfAnyUnitParksItAndAResetBringsItBack) {
  const support::TemporaryFolder folder;
  for (const char* more :
       {"", " canGetAndSetFMUstate=\"true\"", " canBeInstantiatedOnlyOncePerProcess=\"true\""}) {
    const std::string unit = write_unit(
        folder,
        description_2("errs", scalar_2("a", 10, "input") + scalar_2("b", 20, "output"), more), 2);
    sim::ServeOptions options;
    options.socket_path = folder.path("s");
    options.commands = {"a"};
    options.measurements = {"b"};
    options.step_s = 0.1;
    options.every = 1;
    options.lockstep = true;
    std::thread drives([&] {
      const Driver driver(options.socket_path);
      for (int k = 1; k <= 4; ++k)
        EXPECT_FALSE(answer(driver, fmt::format(R"({{"sequence": {}}})", k)).contains("parked"));
      EXPECT_TRUE(answer(driver, R"({"sequence": 5})").contains("parked")) << more;
      EXPECT_EQ(answer(driver, R"({"sequence": 6, "reset": {}})").at("time_s"), 0.0);
      EXPECT_FALSE(answer(driver, R"({"sequence": 7})").contains("parked")) << more;
      driver.say(R"({"sequence": 8, "end": true})");
    });
    const sim::ServeRun run = sim::serve_unit(unit, options);
    drives.join();
    EXPECT_EQ(run.counts.parked, 1u);
  }
}

TEST(OddCommands, ASafeInputBeyondItsBoundsIsRefusedAtTheBegin) {
  const support::TemporaryFolder folder;
  sim::ServeOptions options = car_options(folder);
  options.safe = {{"input.gear", 11.0}};
  EXPECT_THAT([&] { sim::serve_unit(vehicle(), options); },
              ::testing::ThrowsMessage<base::Error>(HasSubstr("safe input: input.gear = 11")));
}

/// Each is answered, and then the car drives as one that nobody disturbed.
void answer_each(unsigned count) {
  const support::TemporaryFolder folder;
  sim::ServeOptions options = car_options(folder);
  std::uint64_t remarks = 0;
  options.keep_remark = [&](std::string_view) { ++remarks; };
  std::uint64_t refused = 0, measured = 0;
  nlohmann::json first, last;
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    const auto drive_after = [&](std::uint32_t sequence) {
      answer(driver,
             fmt::format(R"({{"sequence": {}, "reset": {{"start.speed": 20}}}})", sequence));
      return answer(driver, fmt::format(R"({{"sequence": {}, "set": {{"input.throttle": 0.3}}}})",
                                        sequence + 1));
    };
    sim_tests::OddCommands odd(7);
    first = drive_after(1);
    std::uint32_t sequence = 2;
    for (unsigned k = 0; k < count; ++k) {
      const std::string bytes = odd.datagram(++sequence, options.commands.size());
      driver.say(bytes);
      const std::string answered = driver.hear_bytes();
      if (answered.empty()) {
        ADD_FAILURE() << k << ": no answer to " << bytes.substr(0, 200);
        break;
      }
      const bool is_refusal = answered.starts_with("KSR1") || answered.starts_with(R"({"refused")");
      refused += is_refusal ? 1 : 0;
      measured += is_refusal ? 0 : 1;
      // One that was taken may have counted far ahead.
      if (!is_refusal && answered.starts_with("{"))
        sequence = base::parse_json<nlohmann::json>(answered).at("sequence").get<std::uint32_t>();
    }
    last = drive_after(sequence + 1);
    driver.say(fmt::format(R"({{"sequence": {}, "end": true}})", sequence + 3));
  });
  const sim::ServeRun run = sim::serve_unit(vehicle(), options);
  drives.join();
  EXPECT_TRUE(run.counts.asked_to_end);
  EXPECT_EQ(first.at("values"), last.at("values"));
  EXPECT_EQ(run.counts.broken + run.counts.old, refused);
  EXPECT_EQ(remarks, refused + run.counts.clipped + run.counts.parked);
  EXPECT_GT(refused, count / 5) << "odd enough";
  EXPECT_GT(measured, count / 20) << "some are sound";
}

TEST(OddCommands, EachIsAnsweredAndTheRunGoesOn) { answer_each(400); }

TEST(SlowOddCommands, TenThousandAreAnsweredAndTheRunGoesOn) { answer_each(10'000); }

// 1 / (0.25 - t^2), which is infinite at 0.5 s.
TEST(OddCommands, AUnitThatMeasuresNoNumberIsParkedUntilAReset) {
  const support::TemporaryFolder folder;
  const std::string unit = write_unit(
      folder, description_2("through", scalar_2("far", 31, "output") + scalar_2("a", 10, "input")),
      2);
  sim::ServeOptions options;
  options.socket_path = folder.path("s");
  options.commands = {"a"};
  options.measurements = {"far"};
  options.step_s = 0.125;
  options.every = 1;
  options.lockstep = true;
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    nlohmann::json last;
    for (int k = 1; k <= 4; ++k) {
      EXPECT_FALSE(last.contains("parked"));
      last = answer(driver, fmt::format(R"({{"sequence": {}}})", k));
    }
    EXPECT_THAT(last.value("parked", ""), HasSubstr("far is inf at 0.5 s"));
    EXPECT_DOUBLE_EQ(last.at("values").at("far"), 1.0 / (0.25 - 0.375 * 0.375));
    const nlohmann::json anew = answer(driver, R"({"sequence": 5, "reset": {}})");
    EXPECT_FALSE(anew.contains("parked"));
    EXPECT_EQ(anew.at("values").at("far"), 4.0);
    driver.say(R"({"sequence": 6, "end": true})");
  });
  const sim::ServeRun run = sim::serve_unit(unit, options);
  drives.join();
  EXPECT_EQ(run.counts.parked, 1u);
  EXPECT_FALSE(run.counts.is_parked);
  EXPECT_EQ(run.not_finite, "") << "no such value is in the record";
}

}  // namespace odd_commands_test
