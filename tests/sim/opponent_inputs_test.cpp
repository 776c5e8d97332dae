#include "opponent_inputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "base/error.h"
#include "sim/run_unit.h"
#include "some_unit.h"
#include "support/places.h"

namespace opponent_inputs_test {

using sim_tests::description_2, sim_tests::description_3, sim_tests::scalar_2, sim_tests::value_3,
    sim_tests::write_unit;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A circle of 100 m radius about the origin, driven counter-clockwise at 10 m/s, from angle 0.
vehicle::Opponent circle() {
  vehicle::Opponent out;
  for (int k = 0; k < 628; ++k) {
    out.time_s.push_back(0.1 * k);
    out.x_m.push_back(100.0 * std::cos(0.01 * k));
    out.y_m.push_back(100.0 * std::sin(0.01 * k));
  }
  return out;
}

TEST(OpponentInputs, APathGoesOnAheadOfTheCar) {
  const vehicle::Opponent drive = circle();
  sim::PathAhead path(drive);
  // Two laps inside the circle: 30 m ahead is 0.3 rad ahead, over the seam too. Between two points,
  // 1 m apart, the place is on the chord: off by 5 % of half a metre where the car is 5 % inside.
  for (double angle = 2.0; angle < 14.0; angle += 0.05) {
    const auto there = path.place(95.0 * std::cos(angle), 95.0 * std::sin(angle), 30.0);
    ASSERT_TRUE(there) << angle;
    EXPECT_NEAR(there->x_m, 100.0 * std::cos(angle + 0.3), 0.026) << angle;
    EXPECT_NEAR(there->y_m, 100.0 * std::sin(angle + 0.3), 0.026) << angle;
  }
  vehicle::Opponent half = drive;
  for (auto* const values : {&half.time_s, &half.x_m, &half.y_m}) values->resize(315);
  sim::PathAhead open(half);
  EXPECT_TRUE(open.place(0.0, 100.0, 30.0));
  EXPECT_FALSE(open.place(-100.0, 1.0, 30.0)) << "beyond its end";
  EXPECT_FALSE(open.place(100.0, 1.0, -30.0)) << "before its begin";
}

TEST(OpponentInputs, AreWrittenByTimeAndByPlaceIntoEitherVersion) {
  const support::TemporaryFolder folder;
  std::string names_2, names_3;
  for (const auto& [name, reference] : {std::pair{"active", 10}, {"x", 12}, {"y", 14}}) {
    for (int k = 0; k < 2; ++k) {
      names_2 +=
          scalar_2(fmt::format("input.opponent[{}].{}", k + 1, name), reference + k, "input");
      names_2 += scalar_2(fmt::format("{}{}", name, k + 1), 10 + reference + k, "output");
    }
    names_3 += value_3("Float64", fmt::format("input.opponent.{}", name), reference, "input", 2);
    names_3 += value_3("Float64", fmt::format("{}", name), 10 + reference, "output", 2);
  }
  // The car's place is an input that passes through, too.
  const std::string car = scalar_2("car.x", 16, "input") + scalar_2("car.y", 17, "input");
  const std::string car_3 =
      value_3("Float64", "car.x", 16, "input") + value_3("Float64", "car.y", 17, "input");
  sim::UnitRunOptions options;
  options.step_s = 0.1;
  options.stop_s = 1.0;
  options.opponents = {{"by time", circle(), {}}, {"by place", circle(), 30.0}};
  for (double& time_s : options.opponents[0].drive.time_s) time_s += 0.5;
  options.inputs = {{"car.x", "car.y"}, {0.0, 1.0}, {0.0, 100.0, 0.0, 100.0}};
  for (const int version : {2, 3}) {
    const std::string unit = write_unit(folder,
                                        version == 2 ? description_2("through", names_2 + car)
                                                     : description_3("through", names_3 + car_3),
                                        version);
    const sim::UnitRun run = sim::run_unit(unit, options);
    const std::vector<double> early(run.values.begin() + 7 * 3, run.values.begin() + 7 * 4),
        late(run.values.end() - 7, run.values.end());
    // time; active 1, 2; x 1, 2; y 1, 2. What is set at the begin of a step is of its begin.
    EXPECT_THAT(early,
                ElementsAre(DoubleNear(0.3, 1e-9), 0, 1, 0,
                            DoubleNear(100 * std::cos(0.5 * std::numbers::pi + 0.3), 0.01), 0,
                            DoubleNear(100 * std::sin(0.5 * std::numbers::pi + 0.3), 0.01)))
        << version;
    EXPECT_EQ(late[1], 1.0);
    EXPECT_NEAR(late[3], 100 * std::cos(0.04), 1e-9) << version;
    EXPECT_NEAR(late[5], 100 * std::sin(0.04), 1e-9) << version;
  }
  options.opponents.push_back(options.opponents[0]);
  try {
    sim::run_unit(folder.path("unit.fmu"), options);
    FAIL() << "no error";
  } catch (const base::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("no input input.opponent[3].active, which an opponent "
                                        "needs (by time); name fewer opponents"));
  }
}

// The law itself is tested in lib/vehicle; here that it acts: behind a car there is less drag.
TEST(OpponentInputs, ACarIsFasterInASlipstream) {
  const support::TemporaryFolder folder;
  folder.file("ahead.csv", "time_s,x_m,y_m\n0,-50,0\n100,5000,0\n");
  folder.file("controls.csv", "time_s,input.throttle,input.gear\n0,1,5\n");
  folder.file("all.sh", fmt::format(R"(set -e; cd '{0}'
{1} fmu {2}/vehicles/open_wheel/vehicle.yaml -o car.fmu --quiet
run() {{ {3} run car.fmu --inputs controls.csv --set start.speed=45 --stop-s 3 --step-s 0.01 \
  --record car.vx --quiet "$@"; }}
run -o alone.csv
run -o towed.csv --opponent ahead.csv@15m
run -o behind.csv --opponent ahead.csv@-400m
)",
                                    folder.path("."), places::crgdrive(), places::source(),
                                    places::crgsim()));
  ASSERT_EQ(std::system(
                ("timeout 60 bash " + folder.path("all.sh") + " > " + folder.path("log") + " 2>&1")
                    .c_str()),
            0)
      << folder.read("log");
  const auto last = [&](const std::string& name) {
    const std::string text = folder.read(name);
    return std::stod(text.substr(text.rfind(',') + 1));
  };
  EXPECT_GT(last("towed.csv"), last("alone.csv") + 0.1);
  EXPECT_LT(std::abs(last("behind.csv") - last("alone.csv")), 0.02);
}

}  // namespace opponent_inputs_test
