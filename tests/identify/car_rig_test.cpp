// What the rig shows is what the free car does, and obeys Newton.
#include "identify/car_rig.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/places.h"
#include "vehicle/manoeuvre.h"
#include "vehicle/vehicle_file.h"

namespace car_rig_test {

using P = vehicle::Parameter;

struct Racer {
  vehicle::Vehicle vehicle =
      vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  vehicle::Car<double> car = make_car(vehicle.files, vehicle.parameters, vehicle.terms);
};

TEST(CarRig, TrimIsWhereTheFreeCarSettles) {
  const Racer racer;
  identify::RigRun run;
  run.speed_mps = 30.0;
  run.path = identify::RigPath::kTrimFront;
  run.front_rad = 0.05;
  run.neutral = true;
  const auto moments = identify::run_rig(racer.car, run);
  ASSERT_EQ(moments.size(), run.stairs);
  const identify::CarMoment& trim = moments[moments.size() / 2];
  // The free car with that steering, held at that speed by a push, tyres as on the rig.
  const vehicle::Car<double> car = identify::as_on_rig(racer.car, 1.0);
  const vehicle::Road road;
  vehicle::StartOptions begin;
  begin.speed_mps = run.speed_mps;
  begin.gear = 0;
  vehicle::Simulation<double> sim = vehicle::start(car, road, begin);
  vehicle::Detail<double> detail{};
  vehicle::Controls<double> controls;
  controls.steer_command_rad = trim.steer_rad;
  for (int k = 0; k < 6000; ++k) {
    controls.hold_n = 2000.0 * (run.speed_mps - sim.state[vehicle::kVx]) + 1000.0;
    ASSERT_TRUE(step(car, sim, controls, road, {}, detail).ok());
  }
  const double steered = detail.inputs.steer_rad;  // friction of the actuator keeps it a little off
  const double share = steered / trim.steer_rad;
  // Measured: 0.2 and 0.3 % apart.
  EXPECT_NEAR(sim.state[vehicle::kYawRate], share * trim.yaw_rate_radps,
              0.01 * trim.yaw_rate_radps);
  EXPECT_NEAR(sim.state[vehicle::kVx], run.speed_mps, 0.3);
}

TEST(CarRig, ForcesMakeTheAccelerationAndTheYawMoment) {
  const Racer racer;
  identify::RigRun run;
  run.speed_mps = 40.0;
  run.front_rad = 0.08;
  run.rear_rad = 0.04;
  run.braking = 0.5;
  run.stairs = 8;
  const double mass = racer.car.parameters[P::chassis_mass_kg] + run.fuel_kg;
  const auto moments = identify::run_rig(racer.car, run);
  ASSERT_EQ(moments.size(), 8u);
  for (const auto& m : moments) {
    double side = 0.0, along = 0.0, load = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double angle = i < 2 ? m.steer_rad : 0.0;
      side += m.wheel[i].fy_n * std::cos(angle) + m.wheel[i].fx_n * std::sin(angle);
      along += m.wheel[i].fx_n * std::cos(angle) - m.wheel[i].fy_n * std::sin(angle);
      load += m.wheel[i].fz_n;
    }
    // Left over: air in side slip, toe and Ackermann, the fuel beside the point that is measured
    // at.
    EXPECT_NEAR(side, mass * m.ay_mps2, 0.02 * mass * 9.81);
    EXPECT_LT(along - mass * m.ax_mps2, 0.15 * mass * 9.81);  // drag
    EXPECT_GT(along - mass * m.ax_mps2, 0.05 * mass * 9.81);
    EXPECT_GT(load, mass * 9.81);     // downforce
    EXPECT_GT(m.yaw_moment_nm, 0.0);  // the front slips more
  }
}

TEST(CarRig, PressingIsMeasured) {
  const Racer racer;
  identify::RigRun run;
  run.front_rad = run.rear_rad = 0.02;
  run.gravity = 1.5;
  run.stairs = 4;
  const auto moments = identify::run_rig(racer.car, run);
  ASSERT_FALSE(moments.empty());
  EXPECT_NEAR(moments.back().an_mps2, 1.5 * 9.80665, 0.02);
}

TEST(CarRig, TopSpeedIsThatOfTheEngine) {
  const Racer racer;
  const double top = identify::top_speed(racer.car);
  EXPECT_GT(top, 60.0);
  EXPECT_LT(top, 90.0);
  vehicle::Vehicle slow = racer.vehicle;
  vehicle::apply_setting(slow, "aero.drag_area_m2=3.8", "test");  // four times the drag
  const auto car = make_car(slow.files, slow.parameters, slow.terms);
  EXPECT_LT(identify::top_speed(car), 0.75 * top);
}

}  // namespace car_rig_test
