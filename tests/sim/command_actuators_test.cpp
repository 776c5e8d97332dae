// Actuators of the devices' file, between what is commanded and a unit that has none of its own.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "base/error.h"
#include "sim/serve_unit.h"
#include "some_unit.h"
#include "support/temporary_folder.h"
#include "unit_driver.h"

namespace command_actuators_test {

using sim_tests::Driver, sim_tests::description_2, sim_tests::scalar_2, sim_tests::write_unit;
using ::testing::HasSubstr;

constexpr double kStep_s = 0.01, kDead_s = 0.055, kLag_s = 0.1;

sim::ServeOptions options_of(const support::TemporaryFolder& folder) {
  sim::ServeOptions options;
  options.socket_path = folder.path("s");
  options.commands = {"percent"};
  options.measurements = {"b"};
  options.step_s = kStep_s;
  options.stop_s = 1.0;
  options.lockstep = true;
  options.every = 1;
  options.patience_s = 5.0;
  vehicle::SignalCommand percent;
  percent.name = "percent";
  percent.signal = "a";
  percent.gain = 0.01;
  percent.dead_time_s = kDead_s;
  percent.lag_s = kLag_s;
  options.devices.commands = {percent};
  return options;
}

std::string unit_in(const support::TemporaryFolder& folder) {
  return write_unit(
      folder, description_2("through", scalar_2("a", 10, "input") + scalar_2("b", 20, "output")),
      2);
}

/// Critically damped, after a step at 0: 1 - (1 + t / lag) exp(-t / lag).
double answer(double time_s) {
  return time_s <= 0.0 ? 0.0 : 1.0 - (1.0 + time_s / kLag_s) * std::exp(-time_s / kLag_s);
}

TEST(CommandActuators, AnswerAStepAsTheirEquationSays) {
  const support::TemporaryFolder folder;
  const sim::ServeOptions options = options_of(folder);
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    for (int k = 1; k <= 100; ++k) {
      driver.say(fmt::format(R"({{"sequence": {}, "set": {{"percent": 50}}}})", k));
      const double told = driver.hear().at("values").at("b");
      // A dead time of five steps and a half is the mean of both commands for one step.
      const double t_s = kStep_s * k;
      const double wanted = 0.5 * 0.5 * (answer(t_s - 0.05) + answer(t_s - 0.06));
      ASSERT_NEAR(told, wanted, 1e-12) << k;
      ASSERT_NEAR(told, 0.5 * answer(t_s - kDead_s), 2e-3) << k;
    }
  });
  const sim::ServeRun run = sim::serve_unit(unit_in(folder), options);
  drives.join();
  EXPECT_EQ(run.rows(), 101u);
}

TEST(CommandActuators, BeginAtRestWhereTheUnitIsAlsoAfterAReset) {
  const support::TemporaryFolder folder;
  sim::ServeOptions options = options_of(folder);
  options.starts = {{"a", "0.3"}};
  std::thread drives([&] {
    const Driver driver(options.socket_path);
    const auto after = [&](const char* said) {
      driver.say(said);
      return driver.hear().at("values").at("b").get<double>();
    };
    EXPECT_NEAR(after(R"({"sequence": 1})"), 0.3, 1e-12) << "nothing was said yet";
    for (int k = 2; k <= 40; ++k)
      after(fmt::format(R"({{"sequence": {}, "set": {{"percent": 90}}}})", k).c_str());
    EXPECT_NEAR(after(R"({"sequence": 41, "reset": {}})"), 0.3, 1e-12);
    EXPECT_NEAR(after(R"({"sequence": 42})"), 0.3, 1e-12);
    driver.say(R"({"sequence": 43, "end": true})");
  });
  sim::serve_unit(unit_in(folder), options);
  drives.join();
}

TEST(CommandActuators, ADeadTimeOfTooManyStepsIsRefused) {
  const support::TemporaryFolder folder;
  sim::ServeOptions options = options_of(folder);
  options.step_s = 0.001;
  options.devices.commands[0].dead_time_s = 0.6;
  try {
    sim::serve_unit(unit_in(folder), options);
    FAIL() << "0.51 s is the most";
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("the command percent has a dead time of 0.6 s, and steps "
                                        "of 0.001 s allow 0.51 s at most"));
  }
}

}  // namespace command_actuators_test
