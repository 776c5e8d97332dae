#include "vehicle/opponent.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/places.h"
#include "test_car.h"
#include "test_roads.h"
#include "vehicle/error.h"
#include "vehicle/lap.h"
#include "vehicle/vehicle_file.h"

namespace opponent_test {

using namespace vehicle;  // NOLINT: a test of this library

recording::Table log_of(std::vector<double> t, std::vector<double> x, std::vector<double> y) {
  recording::Table out;
  out.add("time_s", std::move(t));
  out.add("x_m", std::move(x));
  out.add("y_m", std::move(y));
  return out;
}

TEST(Opponent, IsWhereItsLogSaysSeenFromTheCar) {
  // 10 m/s along +y from (5, 0); this car at (5, 2), heading along +y.
  const Opponent other = make_opponent(log_of({100, 101, 102}, {5, 5, 5}, {0, 10, 20}), 1.0, "log");
  State<double> s{};
  s[kX] = 5;
  s[kY] = 2;
  s[kYaw] = M_PI / 2;
  const auto wake =
      nearest_wake(std::vector{other}, 0.5, s);  // 1.5 s after the log's begin: y = 15
  ASSERT_TRUE(wake.has_value());
  EXPECT_NEAR(wake->x_m, 13.0, 1e-12);
  EXPECT_NEAR(wake->y_m, 0.0, 1e-12);
  EXPECT_FALSE(nearest_wake(std::vector{other}, 1.1, s).has_value());  // has left
  // One ahead counts before a nearer one behind.
  const Opponent behind = make_opponent(log_of({0, 9}, {6, 6}, {1, 1}), 0.0, "log");
  EXPECT_NEAR(nearest_wake(std::vector{behind, other}, 0.5, s)->x_m, 13.0, 1e-12);
  EXPECT_NEAR(nearest_wake(std::vector{behind}, 0.5, s)->x_m, -1.0, 1e-12);
  EXPECT_NEAR(nearest_wake(std::vector{behind}, 0.5, s)->y_m, -1.0, 1e-12);
}

TEST(Opponent, OfPlacesTheNearestAheadCounts) {
  State<double> s{};
  s[kX] = 5;
  s[kY] = 2;
  s[kYaw] = M_PI / 2;
  EXPECT_FALSE(nearest_wake(std::span<const OpponentPlace>{}, s).has_value());
  const std::vector<OpponentPlace> cars{{6, 1}, {5, 30}, {4, 15}};
  const auto wake = nearest_wake(cars, s);
  ASSERT_TRUE(wake.has_value());
  EXPECT_NEAR(wake->x_m, 13.0, 1e-12);
  EXPECT_NEAR(wake->y_m, 1.0, 1e-12);
}

TEST(Opponent, RefusesLogsThatAreNone) {
  using ::testing::HasSubstr;
  const auto message = [](const char* part) {
    return ::testing::ThrowsMessage<Error>(HasSubstr(part));
  };
  EXPECT_THAT([] { make_opponent(log_of({0}, {0}, {0}), 0, "a.csv"); }, message("a.csv: 1 rows"));
  EXPECT_THAT(
      [] {
        make_opponent(log_of({0, 1, 1}, {0, 0, 0}, {0, 0, 0}), 0, "a.csv");
      },
      message("row 3"));
  recording::Table no_y;
  no_y.add("time_s", {0, 1});
  no_y.add("x_m", {0, 1});
  EXPECT_THAT([&] { make_opponent(no_y, 0, "a.csv"); }, message("no column y_m"));
}

// Pushed by the same force, in a wake that leaves 0.64 of the drag: top speed by hand 1 /
// sqrt(0.64) = 1.25 times as high, and sqrt(2 F / (rho CdA)) alone.
TEST(Opponent, FollowingCarsTopSpeedIsThatByHand) {
  CarFiles files = test_car_files();
  files.tyre[0] = files.tyre[1] = symmetric_tyre();
  files.wake_drag_factor = {{0.0, 5000.0}, {-5.0, 5.0}, {0.64, 0.64, 0.64, 0.64}};
  files.wake_lift_factor = {};
  Parameters<double> p = default_parameters();
  p[Parameter::front_toe_rad] = p[Parameter::rear_toe_rad] = 0.0;
  Amplitudes<double> terms = default_amplitudes();
  for (const Term off : {Term::rolling_resistance, Term::aero_downforce, Term::aero_ride_height,
                         Term::aero_yaw, Term::fuel_burn, Term::tyre_moments})
    terms[off] = 0.0;
  const Car<double> car = make_car(files, p, terms);
  constexpr double kPush_n = 1500.0;
  const auto top_mps = [&](const std::vector<Opponent>& others) {
    Simulation<double> sim = start(car, Road(), StartOptions{.speed_mps = 45.0, .gear = 0});
    Detail<double> detail;
    for (int i = 0; i < 150000; ++i) {
      Controls<double> c;
      c.gear_command = 0;
      c.hold_n = kPush_n;
      if (const auto wake = nearest_wake(others, sim.time_s, sim.state)) {
        c.opponent = true;
        c.wake_x_m = wake->x_m;
        c.wake_y_m = wake->y_m;
      }
      if (!step(car, sim, c, Road(), {}, detail).ok()) return 0.0;
    }
    return sim.state[kVx];
  };
  const double alone = std::sqrt(2 * kPush_n / (1.2 * p[Parameter::aero_drag_area_m2]));
  EXPECT_NEAR(top_mps({}), alone, 1e-3 * alone);
  // It drives away at 80 m/s, on the same line.
  const Opponent leader = make_opponent(log_of({0, 200}, {10, 16010}, {0, 0}), 0.0, "log");
  EXPECT_NEAR(top_mps({leader}), 1.25 * alone, 2e-3 * alone);
}

// Two cars on one road: the second has the telemetry of the first, half a second ahead.
TEST(Opponent, SecondCarGainsInTheWakeOfTheFirstAndRepeatsToTheByte) {
  const Vehicle v = read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  const crg::Surface surface(stadium());
  LapOptions options;
  const LapResult first = drive_laps(car, Road(surface), options);
  options.opponents = {make_opponent(first.telemetry, 0.5, "first")};
  const LapResult second = drive_laps(car, Road(surface), options);
  const LapResult again = drive_laps(car, Road(surface), options);
  ASSERT_TRUE(second.complete) << second.problem;
  EXPECT_GT(second.top_mps, first.top_mps);
  EXPECT_EQ(recording::format_table(second.telemetry, 17),
            recording::format_table(again.telemetry, 17));
  ASSERT_NE(second.telemetry.find("wake_x_m"), nullptr);
  EXPECT_EQ(first.telemetry.find("wake_x_m"), nullptr);
  const double ahead_m = (*second.telemetry.find("wake_x_m"))[5];
  EXPECT_NEAR(ahead_m, 0.5 * first.telemetry.find("vx_mps")->front(), 1.0);
}

/// All columns but those of the wake.
std::string drive_of(const LapResult& result) {
  recording::Table out;
  for (std::size_t i = 0; i < result.telemetry.names.size(); ++i)
    if (!result.telemetry.names[i].starts_with("wake_"))
      out.add(result.telemetry.names[i], result.telemetry.columns[i]);
  return recording::format_table(out, 17);
}

// Two simulated cars in one run. Without slipstream each drives its single lap to the byte, also
// after the other has left; with it the one behind is faster on the straights than alone.
TEST(Opponent, TwoCarsInOneRun) {
  const Vehicle v = read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  Amplitudes<double> calm = v.terms;
  calm[Term::aero_slipstream] = 0.0;
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  const Car<double> alone = make_car(v.files, v.parameters, calm);
  const crg::Surface surface(stadium(400.0, 60.0));
  const Road road(surface);
  LapOptions behind, ahead;
  behind.laps = ahead.laps = 2;
  ahead.ahead_m = 12.0;
  const LapResult single = drive_laps(alone, road, behind), other = drive_laps(alone, road, ahead);
  const std::vector<Entrant> without{{&alone, behind}, {&alone, ahead}};
  const std::vector<LapResult> apart = drive_together(without, road);
  ASSERT_TRUE(apart[0].complete && apart[1].complete) << apart[0].problem << apart[1].problem;
  EXPECT_EQ(drive_of(apart[0]), drive_of(single));
  EXPECT_EQ(drive_of(apart[1]), drive_of(other));
  EXPECT_NEAR(apart[0].telemetry.find("wake_x_m")->front(), 12.0, 0.2);
  EXPECT_NEAR(apart[1].telemetry.find("wake_x_m")->front(), -12.0, 0.2);

  const std::vector<Entrant> both{{&car, behind}, {&car, ahead}};
  const std::vector<LapResult> towed = drive_together(both, road);
  ASSERT_TRUE(towed[0].complete && towed[1].complete) << towed[0].problem << towed[1].problem;
  EXPECT_GT(towed[0].top_mps, single.top_mps + 0.5);
  EXPECT_LT(towed[0].lap_s[1], single.lap_s[1] - 0.05);
  EXPECT_LT(towed[0].nearest_m, apart[0].nearest_m);
  EXPECT_EQ(towed[0].nearest_m, towed[1].nearest_m);
  // Another run gives the same, and in which order they are named changes nothing.
  const std::vector<Entrant> other_order{{&car, ahead}, {&car, behind}};
  const std::vector<LapResult> turned = drive_together(other_order, road);
  for (const std::size_t i : {0u, 1u})
    EXPECT_EQ(recording::format_table(towed[i].telemetry, 17),
              recording::format_table(turned[1 - i].telemetry, 17));
  RecordProperty("gain_s", std::to_string(single.lap_s[1] - towed[0].lap_s[1]));
  RecordProperty("gain_mps", std::to_string(towed[0].top_mps - single.top_mps));
}

TEST(Opponent, CarsOfOneRunAreRefusedThatCannotGoTogether) {
  const CarFiles files = test_car_files();
  const Car<double> car = make_car(files, default_parameters(), default_amplitudes());
  const crg::Surface surface(stadium());
  LapOptions other;
  other.step.step_s = 0.0005;
  const std::vector<Entrant> steps{{&car, {}}, {&car, other}};
  EXPECT_THAT([&] { drive_together(steps, Road(surface)); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("one step for all cars")));
  other = {};
  other.ahead_m = 400.0;
  EXPECT_THAT([&] { drive_laps(car, Road(surface), other); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("a quarter of the line")));
}

}  // namespace opponent_test
