#include "vehicle/steady_engine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/places.h"
#include "test_car.h"
#include "test_roads.h"
#include "vehicle/lap.h"
#include "vehicle/vehicle_file.h"

namespace steady_engine_test {

using namespace vehicle;  // NOLINT: a test of this library

CarFiles turbo_files() {
  CarFiles files = test_car_files();
  files.turbo = Turbo::kFull;
  return files;
}

// The whole car on a bench that holds its engine's speed, pedal still for 15 s: what the torque
// comes to is what the driver takes it for.
TEST(SteadyEngine, IsWhatTheSimulatedEngineComesTo) {
  const CarFiles files = turbo_files();
  Amplitudes<double> terms = default_amplitudes();
  terms[Term::throttle_actuator] = 0.0;
  const Car<double> car = make_car(files, default_parameters(), terms);
  const Map2 map = steady_engine(car);
  ASSERT_EQ(map.z.size(), map.x.size() * map.y.size());
  for (const std::size_t i : {4u, 8u, 14u})
    for (const std::size_t j : {0u, 2u, 4u, 6u}) {
      Simulation<double> sim = start(car, Road(), {});
      Controls<double> c;
      c.gear_command = 0;
      c.throttle_command = map.y[j];
      Detail<double> detail;
      for (int k = 0; k < 15000; ++k) {
        sim.state[kEngine] = map.x[i];
        for (const std::size_t s : {kX, kY, kVx, kVy}) sim.state[s] = 0.0;
        ASSERT_TRUE(step(car, sim, c, Road(), {}, detail).ok());
      }
      sim.state[kEngine] = map.x[i];
      const double limited = map.x[i] > car.parameters[Parameter::engine_limit_radps];
      if (limited != 0.0) continue;
      EXPECT_NEAR(map.z[i * map.y.size() + j], detail.turbo.engine_nm,
                  0.5 + 0.002 * std::abs(detail.turbo.engine_nm))
          << map.x[i] << ' ' << map.y[j];
    }
}

TEST(SteadyEngine, ThrottleIsTheWayBack) {
  const Map2 map{{100, 200}, {0.0, 0.5, 1.0}, {-10, 50, 90, -20, 100, 200}};
  EXPECT_DOUBLE_EQ(throttle_for(map, 100, 20), 0.25);
  EXPECT_DOUBLE_EQ(throttle_for(map, 200, 150), 0.75);
  EXPECT_DOUBLE_EQ(throttle_for(map, 150, 75.0), 0.5);
  EXPECT_EQ(throttle_for(map, 100, -50), 0.0);
  EXPECT_EQ(throttle_for(map, 100, 500), 1.0);
}

TEST(SteadyEngine, IsEmptyForACarThatFollowsItsMap) {
  const CarFiles files = test_car_files();
  EXPECT_TRUE(steady_engine(make_car(files, default_parameters(), default_amplitudes())).empty());
}

// With the full engine the engine map has no part in a lap: another map, the same bytes. The plan
// knows the engine's power, so the car is never far from the planned speed.
TEST(SteadyEngine, DriverJudgesByTheEngineThatDrives) {
  Vehicle v = read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  v.files.turbo = Turbo::kFull;
  const crg::Surface surface(stadium());
  const auto drive = [&] {
    return drive_laps(make_car(v.files, v.parameters, v.terms), Road(surface));
  };
  const LapResult stated = drive();
  ASSERT_TRUE(stated.complete) << stated.problem;
  for (double& torque_nm : v.files.engine_torque_nm.z) torque_nm *= 2.0;
  EXPECT_EQ(recording::format_table(drive().telemetry, 17),
            recording::format_table(stated.telemetry, 17));
  RacingLine line = plan_line(surface);
  const Car<double> car = make_car(v.files, v.parameters, v.terms);
  plan_speed(line, car, {});
  const double planned_mps = *std::max_element(line.speed_mps.begin(), line.speed_mps.end());
  EXPECT_NEAR(stated.top_mps / planned_mps, 1.0, 0.05);
}

}  // namespace steady_engine_test
