// What is wrong with a log is recognised, named, and limits the analysis.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>

#include "crg/file.h"
#include "explain/explain.h"
#include "explain/judge.h"
#include "explain/plausible_car.h"
#include "good_log.h"
#include "support/places.h"
#include "vehicle/error.h"
#include "vehicle/vehicle_file.h"

namespace explain {
namespace bad_input_test {

using BadInput = GoodLog;

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(BadInput, AGoodLogHasNoRemarks) { EXPECT_EQ(said(*log_), ""); }

TEST_F(BadInput, WrongUnitsAreNamed) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  for (const char* name : {"yaw_rate_radps", "yaw_rad", "steer_rad"})
    EXPECT_THAT(said(changed(name, [](double v) { return v * kDegrees; })),
                HasSubstr(fmt::format("'{}' looks like degrees", name)));
  for (const char* name : {"ax_mps2", "ay_mps2"})
    EXPECT_THAT(said(changed(name, [](double v) { return v / 9.81; })),
                HasSubstr(fmt::format("'{}' looks like multiples of g", name)));
  EXPECT_THAT(said(changed("throttle", [](double v) { return 100 * v; })), HasSubstr("per cent"));
  EXPECT_THAT(said(changed("vx_mps", [](double v) { return 3.6 * v; })), HasSubstr("another unit"));
  recording::Table bar = *log_, wheels = *log_, kilopascal = *log_;
  for (const char* wheel : {"fl", "fr", "rl", "rr"}) {
    for (double& v : column(bar, fmt::format("brake_{}_pa", wheel))) v *= 1e-5;
    for (double& v : column(kilopascal, fmt::format("brake_{}_pa", wheel))) v *= 3e-3;
    for (double& v : column(wheels, fmt::format("wheel_{}_radps", wheel)))
      v *= 60 / (2 * std::numbers::pi);
  }
  EXPECT_THAT(said(bar), HasSubstr("bar or another unit"));
  EXPECT_THAT(said(kilopascal), HasSubstr("bar or another unit"));
  EXPECT_THAT(said(wheels), HasSubstr("times the speed: another unit"));
}

TEST_F(BadInput, WrongSignsAreNamedAndForcesLeftAlone) {
  for (const char* name : {"yaw_rate_radps", "steer_rad", "vy_mps"}) {
    const recording::Table t = changed(name, [](double v) { return -v; });
    EXPECT_THAT(said(t), HasSubstr(fmt::format("'{}' has the other sign", name)));
    EXPECT_THAT(said(t), HasSubstr("forces are not compared"));
    EXPECT_FALSE(signals(t).present[kSteer]);
  }
  EXPECT_THAT(said(changed("yaw_rad", [](double v) { return v + 1.0; })),
              HasSubstr("another zero"));
}

TEST_F(BadInput, SwappedChannelsAreNamed) {
  recording::Table t = *log_;
  std::swap(column(t, "ax_mps2"), column(t, "ay_mps2"));
  EXPECT_THAT(said(t), HasSubstr("they are swapped"));
  EXPECT_FALSE(signals(t).present[kAx]);
  t = *log_;
  std::swap(column(t, "vx_mps"), column(t, "vy_mps"));
  EXPECT_THAT(said(t), HasSubstr("not the forward speed"));
  t = *log_;
  std::swap(column(t, "yaw_rate_radps"), column(t, "throttle"));
  EXPECT_THAT(said(t), HasSubstr("'yaw_rate_radps' does not follow"));
}

TEST_F(BadInput, ClocksAreNamed) {
  recording::Table t = *log_;
  std::vector<double>& rate = column(t, "yaw_rate_radps");
  rate.insert(rate.begin(), 50, 0.0);  // one second late
  rate.resize(log_->rows());
  // The course follows the heading by up to a tenth of a second.
  EXPECT_THAT(said(t), ::testing::ContainsRegex(
                           "'yaw_rate_radps' runs on another clock: (0.9|1.0). s late"));
  t = *log_;
  for (std::size_t i = 5000; i < t.rows(); ++i) column(t, "time_s")[i] -= 90.0;
  EXPECT_THAT(said(t), HasSubstr("row 5001: the clock goes back"));
}

TEST_F(BadInput, GapsConstantsAndRepeatsAreNamed) {
  recording::Table gap = rows(0, 3000);
  const recording::Table later = rows(3400, log_->rows());
  for (std::size_t k = 0; k < gap.columns.size(); ++k)
    gap.columns[k].insert(gap.columns[k].end(), later.columns[k].begin(), later.columns[k].end());
  EXPECT_THAT(said(gap), HasSubstr("a gap of 8"));
  EXPECT_THAT(said(changed("ay_mps2", [](double) { return 1.0; })),
              HasSubstr("'ay_mps2' is constant: not used"));
  recording::Table held = *log_;
  for (std::size_t i = 0; i < held.rows(); ++i)
    column(held, "ax_mps2")[i] = column(*log_, "ax_mps2")[i / 2 * 2];
  const Mapping mapping = identity_mapping(held);
  ASSERT_EQ(mapping.notes.size(), 1u);
  EXPECT_THAT(mapping.notes[0], HasSubstr("'ax_mps2': 50 % of the samples repeat"));
  EXPECT_TRUE(signals(held).present[kAx]);
  for (std::size_t i = 0; i < held.rows(); ++i)
    column(held, "ax_mps2")[i] = column(*log_, "ax_mps2")[i / 10 * 10];
  EXPECT_THAT(said(held), HasSubstr("'ax_mps2' has 5.0 measurements a second"));
}

TEST_F(BadInput, RatesFrom10To1000AreTaken) {
  const recording::Table slow = rows(0, log_->rows(), 5);
  EXPECT_NEAR(signals(slow).sample_hz, 10, 0.1);
  EXPECT_EQ(said(slow), "");
  recording::Table fast = *log_;
  std::mt19937 random(1);
  for (std::size_t k = 0; k < fast.columns.size(); ++k) {
    fast.columns[k].clear();
    for (std::size_t i = 0; i + 1 < 5000; ++i)
      for (int part = 0; part < 20; ++part)
        fast.columns[k].push_back(log_->columns[k][i] +
                                  part / 20.0 * (log_->columns[k][i + 1] - log_->columns[k][i]));
  }
  EXPECT_NEAR(signals(fast).sample_hz, 1000, 1);
  EXPECT_THAT(said(fast), Not(HasSubstr("not used")));
}

TEST_F(BadInput, LapsCountWhereverTheyBegin) {
  // Two laps of 44 s from the middle of one: one of them from line to line.
  EXPECT_THAT(said(rows(1300, 1300 + 5400)), Not(HasSubstr("laps: what comes back every lap")));
  EXPECT_THAT(said(rows(1300, 1300 + 4000)), HasSubstr("laps: what comes back every lap"));
}

TEST_F(BadInput, PositionsThatJitterTakeNoOtherColumnWithThem) {
  recording::Table t = *log_;
  std::mt19937 random(5);
  std::normal_distribution<double> jitter(0.0, 0.15);
  for (const char* position : {"x_m", "y_m"})
    for (double& v : column(t, position)) v += jitter(random);
  EXPECT_THAT(said(t), Not(HasSubstr("not used")));
}

TEST_F(BadInput, ALateralSpeedFarAheadOfTheMiddleIsNoWrongSign) {
  for (const double ahead_m : {-3.0, 3.0}) {
    recording::Table t = *log_;
    const std::vector<double> turning = column(t, "yaw_rate_radps");
    for (std::size_t i = 0; i < t.rows(); ++i) column(t, "vy_mps")[i] += ahead_m * turning[i];
    EXPECT_THAT(said(t), Not(HasSubstr("vy_mps"))) << ahead_m;
  }
  EXPECT_THAT(said(changed("vy_mps", [](double v) { return -v; })), HasSubstr("other sign"));
}

TEST_F(BadInput, TooShortAndOneLapOnly) {
  EXPECT_THAT(said(rows(0, 450)), HasSubstr("at least 10 s are wanted"));
  const vehicle::Vehicle car = vehicle::read_vehicle(folder_->path("none/vehicle.yaml"));
  const recording::Table lap = rows(0, 2600);  // a lap takes 44 s
  EXPECT_THAT(said(lap), HasSubstr("laps: what comes back every lap"));
  const Inventory found = inventory({signals(lap)}, car);
  for (const char* road : {"road.banking", "road.grade", "road.friction"})
    EXPECT_TRUE(std::any_of(found.untestable.begin(), found.untestable.end(),
                            [&](const Untestable& u) {
                              return u.mechanism == road && u.reason == "less than two laps";
                            }))
        << road;
}

TEST_F(BadInput, AnotherTrackAndAnotherFrame) {
  recording::Table t = *log_;
  for (std::size_t i = 0; i < t.rows(); ++i) {
    const double x = column(*log_, "x_m")[i], y = column(*log_, "y_m")[i];
    column(t, "x_m")[i] = 0.6 * x - 0.8 * y + 4000;
    column(t, "y_m")[i] = 0.8 * x + 0.6 * y - 300;
  }
  EXPECT_THAT(said(t),
              AllOf(HasSubstr("another frame"), HasSubstr("turned by"), HasSubstr("fits within")));
  for (double& y : column(t, "y_m")) y = -y;
  EXPECT_THAT(said(t), AllOf(HasSubstr("another track"), Not(HasSubstr("fits within")),
                             HasSubstr("mirrored, the path has the road's shape within")));
}

TEST_F(BadInput, HeadingsFromNorthAndRowsInReverse) {
  const recording::Table compass =
      changed("yaw_rad", [](double v) { return std::numbers::pi / 2 - v; });
  EXPECT_THAT(said(compass),
              HasSubstr("'yaw_rad' counts clockwise from north, where counter-clockwise from the x "
                        "axis is wanted: give it scale -1 and offset 1.5708"));
  Mapping mended = identity_mapping(compass);
  for (ColumnMapping& m : mended.columns)
    if (m.channel == "yaw_rad") m.scale = -1, m.offset = 1.5708;
  EXPECT_TRUE(make_signals(compass, mended, *road_, "log.csv").remarks.empty());
  recording::Table reverse = *log_;
  for (std::size_t k = 0; k < reverse.columns.size(); ++k)
    if (reverse.names[k] != "time_s")
      std::reverse(reverse.columns[k].begin(), reverse.columns[k].end());
  EXPECT_THAT(said(reverse), HasSubstr("the rows run backwards in time"));
}

using SlowBadInput = BadInput;
TEST_F(SlowBadInput, AnotherCar) {
  const vehicle::Vehicle car =
      vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  ExplainOptions options;
  options.nulls = 200;
  Findings found = explain_relations({signals(rows(0, 2650))}, car, options);  // a lap
  doubt_the_car(found);
  EXPECT_EQ(explain::judge(found), explain::Verdict::kUnknown);
  ASSERT_FALSE(found.remarks.empty());
  EXPECT_THAT(found.remarks.back().text,
              HasSubstr("is it the file of this car? Nothing about the car is named by forces"));
}

TEST_F(SlowBadInput, WithoutForcesNoCarIsNeeded) {
  const vehicle::Vehicle car =
      vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  ExplainOptions options;
  options.nulls = 200;
  options.forces = false;
  const Findings found = explain_relations({signals(rows(0, 2650))}, car, options);
  for (const Finding& f : found.findings)
    EXPECT_THAT(f.kind, testing::AnyOf("sensor", "road")) << f.mechanism;
  for (const explain::Unexplained& u : found.unexplained)
    EXPECT_THAT(u.channel, testing::Not(HasSubstr("force"))) << u.channel;
  EXPECT_FALSE(found.held_out.empty());
  // Of 11 s the few relations without forces say too little.
  const Findings few = explain_relations({signals(rows(0, 550))}, car, options);
  EXPECT_TRUE(few.findings.empty());
}

TEST(AnotherCarsFile, LeavesWhatNeedsNoForces) {
  Findings found;
  for (const char* kind : {"sensor", "parameter", "vehicle", "environment", "road"})
    found.findings.emplace_back().kind = kind;
  found.findings[2].mechanism = "vehicle.fuel_burn";
  const auto add_parameter = [&](const char* id, double value) {
    ParameterValue& p = found.parameters.emplace_back();
    p.id = id;
    p.stated = 1.0;
    p.value = value;
    p.beyond_prior = true;
  };
  add_parameter("parameter.downforce", 0.6);
  doubt_the_car(found);
  EXPECT_FALSE(found.doubtful_car) << "one alone may be off";
  add_parameter("parameter.downforce", 0.65);
  doubt_the_car(found);
  EXPECT_FALSE(found.doubtful_car) << "both axles' are off by one cause";
  EXPECT_EQ(found.findings.size(), 5u);
  add_parameter("parameter.drag", 1.4);
  doubt_the_car(found);
  EXPECT_TRUE(found.doubtful_car);
  ASSERT_EQ(found.findings.size(), 2u);
  EXPECT_EQ(found.findings[0].kind, "sensor");
  EXPECT_EQ(found.findings[1].kind, "road");
  EXPECT_THAT(found.remarks.back().text, HasSubstr("else it would name vehicle.fuel_burn"));
  found = Findings();
  add_parameter("parameter.drag", 0.75);
  add_parameter("parameter.mass", 1.23);
  doubt_the_car(found);
  EXPECT_FALSE(found.doubtful_car) << "two by a quarter are two errors";
  add_parameter("parameter.tyre_stiffness", 0.77);
  doubt_the_car(found);
  EXPECT_TRUE(found.doubtful_car);
  EXPECT_THAT(found.remarks.back().text, HasSubstr("each more than 20 % off"));
}

TEST_F(BadInput, ACorrectedInputNeverReplacesAnInput) {
  const std::string before = folder_->read("none/vehicle.yaml");
  EXPECT_NE(
      std::system(fmt::format("{0} run --road {1}/track.crg --car {1}/vehicle.yaml "
                              "--log {1}/run.csv -o {1} 2> {2}",
                              places::crgexplain(), folder_->path("none"), folder_->path("log"))
                      .c_str()),
      0);
  EXPECT_THAT(folder_->read("log"),
              AllOf(HasSubstr("none/vehicle.yaml: is read"), HasSubstr("choose another folder")));
  EXPECT_EQ(folder_->read("none/vehicle.yaml"), before);
}

}  // namespace bad_input_test
}  // namespace explain
