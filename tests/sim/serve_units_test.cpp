// Several units in one run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include "base/error.h"
#include "sim/serve_unit.h"
#include "some_unit.h"
#include "unit_driver.h"

namespace serve_units_test {

using sim_tests::Driver, sim_tests::description_2, sim_tests::scalar_2, sim_tests::write_unit;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Column = std::vector<double>;

/// Stands where it is told to, and tells whom it sees.
std::string car_like(const std::string& kind) {
  return description_2(kind, scalar_2("to", 10, "input") +
                                 scalar_2("input.opponent[1].active", 12, "input", "Boolean") +
                                 scalar_2("input.opponent[1].x", 13, "input") +
                                 scalar_2("input.opponent[1].y", 14, "input") +
                                 scalar_2("car.x", 20, "output") + scalar_2("car.y", 21, "output") +
                                 scalar_2("sees", 22, "output", "Boolean") +
                                 scalar_2("sees.x", 23, "output"));
}

struct Two {
  support::TemporaryFolder folder;
  sim::ServedUnit red, blue;

  explicit Two(const std::string& kind_of_red = "through") {
    for (const auto& [unit, name, kind] :
         {std::tuple{&red, "red", kind_of_red}, {&blue, "blue", "through"}}) {
      unit->name = name;
      write(*unit, car_like(kind));
      sim::ServeOptions& options = unit->options;
      options.socket_path = folder.path(unit->name);
      options.commands = {"to"};
      options.measurements = {"car.x", "sees", "sees.x"};
      options.step_s = 0.01;
      options.stop_s = 1.0;
      options.lockstep = true;
      options.every = 1;
    }
  }
  void write(sim::ServedUnit& unit, const std::string& description) const {
    unit.path = folder.path(unit.name + ".fmu");
    std::filesystem::rename(write_unit(folder, description, 2), unit.path);
  }
  std::vector<sim::ServeRun> run() const { return sim::serve_units({red, blue}); }
  std::vector<sim::ServeRun> sound_run() const {
    try {
      return run();
    } catch (const base::Error& error) {
      ADD_FAILURE() << error.what();
      return std::vector<sim::ServeRun>(2);
    }
  }
};

Column column(const sim::ServeRun& run, const std::string& name) {
  const auto at = std::find(run.columns.begin(), run.columns.end(), name) - run.columns.begin();
  Column out;
  for (std::size_t k = static_cast<std::size_t>(at); k < run.values.size(); k += run.columns.size())
    out.push_back(run.values[k]);
  return out;
}

/// Commands first, first + 1 ..., each after a while; then ends, or says nothing more.
void drive(const std::string& path, double first, int commands, bool ends,
           std::chrono::milliseconds between = std::chrono::milliseconds(0)) {
  const Driver driver(path);
  for (int k = 0; k < commands; ++k) {
    std::this_thread::sleep_for(between);
    driver.say(fmt::format(R"({{"sequence": {}, "set": {{"to": {}}}}})", k + 1, first + k));
    EXPECT_EQ(driver.hear().at("sequence"), k + 1);
  }
  if (ends) driver.say(fmt::format(R"({{"sequence": {}, "end": true}})", commands + 1));
}

TEST(ServeUnits, InLockstepAStepIsTakenWhenAllHaveTheirCommands) {
  const Two two;
  const auto run = [&](int slow_ms) {
    std::thread red([&] { drive(two.red.options.socket_path, 100.0, 20, true); });
    std::thread blue([&] {
      drive(two.blue.options.socket_path, 200.0, 20, true, std::chrono::milliseconds(slow_ms));
    });
    const std::vector<sim::ServeRun> runs = two.sound_run();
    red.join();
    blue.join();
    return runs;
  };
  const std::vector<sim::ServeRun> runs = run(0);
  ASSERT_EQ(runs.size(), 2u);
  for (const sim::ServeRun& one : runs) {
    EXPECT_EQ(one.failed, "");
    EXPECT_EQ(one.counts.steps, 20u);
    EXPECT_EQ(one.counts.others_seen, 1u);
    EXPECT_TRUE(one.counts.tells_its_place);
  }
  // Each step knows where the other was at its begin: what was commanded for the step before.
  const Column red_x = column(runs[0], "car.x"), seen_x = column(runs[1], "sees.x");
  EXPECT_EQ(red_x.back(), 119.0);
  ASSERT_EQ(seen_x.size(), 21u);
  for (std::size_t row = 1; row < seen_x.size(); ++row) EXPECT_EQ(seen_x[row], red_x[row - 1]);
  // Whoever is slow: the same bytes.
  const std::vector<sim::ServeRun> again = run(5);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(again[k].values, runs[k].values);
}

TEST(ServeUnits, WhoEndsIsNoLongerOnTheRoad) {
  const Two two;
  std::thread red([&] { drive(two.red.options.socket_path, 100.0, 5, true); });
  std::thread blue([&] { drive(two.blue.options.socket_path, 200.0, 30, true); });
  const std::vector<sim::ServeRun> runs = two.sound_run();
  red.join();
  blue.join();
  EXPECT_EQ(runs[0].counts.steps, 5u);
  EXPECT_EQ(runs[1].counts.steps, 30u);
  Column seen = column(runs[1], "sees"), wanted(31, 0.0);
  std::fill_n(wanted.begin() + 1, 5, 1.0);
  EXPECT_EQ(seen, wanted);
}

TEST(ServeUnits, ACrashEndsOneAndTheOthersDriveOn) {
  for (const auto& [kind, says] : {std::pair{"crashes", "the unit crashed after 0.45 s (signal 11"},
                                   {"leaves", "exit code 3"}}) {
    SCOPED_TRACE(kind);
    const Two two(kind);
    std::thread red([&] {
      const Driver driver(two.red.options.socket_path);
      for (int k = 1; k <= 45; ++k) {
        driver.say(fmt::format(R"({{"sequence": {}, "set": {{"to": 7}}}})", k));
        driver.hear();
      }
      driver.say(R"({"sequence": 46})");
    });
    std::thread blue([&] { drive(two.blue.options.socket_path, 200.0, 100, false); });
    const std::vector<sim::ServeRun> runs = two.sound_run();
    red.join();
    blue.join();
    EXPECT_THAT(runs[0].failed, HasSubstr(says));
    EXPECT_EQ(runs[0].rows(), 46u) << "what it told before";
    EXPECT_EQ(runs[1].failed, "");
    EXPECT_EQ(runs[1].counts.steps, 100u);
    const Column seen = column(runs[1], "sees");
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1.0), 46)
        << "at the begin of its last step, too";
    EXPECT_EQ(seen.back(), 0.0);
    EXPECT_FALSE(std::filesystem::exists(two.red.options.socket_path));
  }
}

TEST(ServeUnits, WhoseUnitFailsStandsOnTheRoad) {
  Two two("errs");
  two.red.options.patience_s = 0.3;
  std::thread red([&] { drive(two.red.options.socket_path, 7.0, 50, false); });
  std::thread blue([&] { drive(two.blue.options.socket_path, 200.0, 100, false); });
  const std::vector<sim::ServeRun> runs = two.sound_run();
  red.join();
  blue.join();
  EXPECT_THAT(runs[0].first_parked, HasSubstr("error from the unit"));
  EXPECT_TRUE(runs[0].counts.is_parked);
  EXPECT_EQ(runs[0].rows(), 46u);
  EXPECT_EQ(runs[1].counts.steps, 100u);
  const Column seen = column(runs[1], "sees");
  EXPECT_EQ(seen.back(), 1.0);
}

TEST(ServeUnits, WhoseStackDiesGoesOnWithItsSafeInputUntilNobodyDrives) {
  Two two;
  two.red.options.safe = {{"to", -1.0}};
  two.red.options.patience_s = 0.3;
  const auto run = [&] {
    std::thread red([&] { drive(two.red.options.socket_path, 100.0, 5, false); });
    std::thread blue([&] { drive(two.blue.options.socket_path, 200.0, 30, true); });
    const std::vector<sim::ServeRun> runs = two.sound_run();
    red.join();
    blue.join();
    return runs;
  };
  const std::vector<sim::ServeRun> runs = run();
  EXPECT_TRUE(runs[0].counts.silent);
  EXPECT_EQ(runs[0].counts.steps, 30u) << "it ends with the last that is driven";
  EXPECT_EQ(runs[0].counts.safe_steps, 25u);
  EXPECT_EQ(column(runs[0], "car.x").back(), -1.0);
  EXPECT_FALSE(runs[1].counts.silent);
  EXPECT_EQ(column(runs[1], "sees.x").back(), -1.0) << "it stays on the road";
  const std::vector<sim::ServeRun> again = run();
  for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(again[k].values, runs[k].values);
}

TEST(ServeUnits, InRealTimeNobodyWaitsAndAPauseStopsAll) {
  Two two("crashes");
  for (sim::ServedUnit* const one : {&two.red, &two.blue}) one->options.lockstep = false;
  two.red.options.safe_after_s = 10.0;
  std::thread drives([&] {
    const Driver red(two.red.options.socket_path), blue(two.blue.options.socket_path);
    red.say(R"({"sequence": 1, "pause": true, "set": {"to": 5}})");
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    blue.say(R"({"sequence": 1, "pause": false, "set": {"to": 6}})");
  });
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<sim::ServeRun> runs = two.sound_run();
  const double took_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  drives.join();
  EXPECT_GE(took_s, 1.3) << "1 s of the clock and most of half a second of pause";
  EXPECT_THAT(runs[0].failed, HasSubstr("crashed after 0.4"));
  EXPECT_EQ(runs[1].failed, "");
  EXPECT_EQ(runs[1].counts.steps, 100u);
  const Column seen = column(runs[1], "sees"), seen_x = column(runs[1], "sees.x");
  EXPECT_GE(std::count(seen_x.begin(), seen_x.end(), 5.0), 20);
  EXPECT_GE(std::count(seen.begin(), seen.end(), 1.0), 40);
  // Gone with its process. On a machine that is not calm the other may have ended before.
  const auto first = std::find(seen.begin(), seen.end(), 1.0);
  const auto gone = std::find(first, seen.end(), 0.0);
  EXPECT_EQ(std::count(gone, seen.end(), 1.0), 0);
}

TEST(ServeUnits, WhoHasNoPlaceIsNotSeen) {
  Two two;
  two.write(two.red,
            description_2("through", scalar_2("to", 10, "input") + scalar_2("out", 20, "output")));
  two.red.options.measurements = {"out"};
  std::thread red([&] { drive(two.red.options.socket_path, 1.0, 5, true); });
  std::thread blue([&] { drive(two.blue.options.socket_path, 2.0, 5, true); });
  const std::vector<sim::ServeRun> runs = two.sound_run();
  red.join();
  blue.join();
  EXPECT_FALSE(runs[0].counts.tells_its_place);
  EXPECT_EQ(runs[0].counts.others_seen, 0u);
  EXPECT_TRUE(runs[1].counts.tells_its_place);
  EXPECT_THAT(column(runs[1], "sees"), Each(0.0));
}

TEST(ServeUnits, RefusesInOneLine) {
  const auto refusal = [](const Two& two) -> std::string {
    try {
      two.run();
    } catch (const base::Error& error) {
      return error.what();
    }
    return "";
  };
  Two two;
  two.blue.options.stop_s = 2.0;
  EXPECT_THAT(refusal(two), HasSubstr("are not those of red; one clock for all wanted"));
  two.blue.options.stop_s = 1.0;
  // One that cannot begin: the others do not wait for it.
  two.blue.options.starts = {{"none", "1"}};
  EXPECT_THAT(refusal(two), HasSubstr("no variable 'none'"));
  EXPECT_FALSE(std::filesystem::exists(two.red.options.socket_path));
  two.blue.options.starts.clear();
  two.blue.options.socket_path = two.red.options.socket_path;
  EXPECT_THAT(refusal(two), HasSubstr("no socket can be made there"));
  EXPECT_THROW(sim::serve_units({}), base::Error);
  // Two opponents where the unit has inputs for one.
  two.blue.options.socket_path = two.folder.path("blue");
  sim::ServedUnit green = two.blue;
  green.options.socket_path = two.folder.path("green");
  try {
    sim::serve_units({two.red, two.blue, green});
    FAIL() << "no error";
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("input.opponent[2].active, which an opponent needs"));
  }
}

}  // namespace serve_units_test
