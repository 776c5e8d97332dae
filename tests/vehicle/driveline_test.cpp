#include "vehicle/laws/driveline.h"

#include <gtest/gtest.h>

#include "test_car.h"

namespace driveline_test {

using namespace vehicle;  // NOLINT: a test of this library
using P = Parameter;

// Odd, all of it far beyond the stick speed, its slope at zero slip capacity over stick speed.
TEST(Driveline, FrictionActsAgainstSlip) {
  EXPECT_NEAR(laws::slip_friction<double>(700, 60, 6).torque_nm, 700, 1e-5);
  EXPECT_EQ(laws::slip_friction<double>(700, -3, 6).torque_nm,
            -laws::slip_friction<double>(700, 3, 6).torque_nm);
  EXPECT_NEAR(laws::slip_friction<double>(700, 0, 6).stiffness_nms, 700.0 / 6, 1e-12);
  const double slope = (laws::slip_friction<double>(700, 4.001, 6).torque_nm -
                        laws::slip_friction<double>(700, 3.999, 6).torque_nm) /
                       0.002;
  EXPECT_NEAR(laws::slip_friction<double>(700, 4, 6).stiffness_nms, slope, 1e-4);
}

TEST(Driveline, CentrifugalClutchEngagesWithTheEngine) {
  Parameters<double> p = default_parameters();
  p[P::clutch_torque_nm] = 700;
  p[P::clutch_begin_radps] = 150;
  p[P::clutch_full_radps] = 190;
  EXPECT_EQ(laws::clutch_capacity<double>(p, 1, 140), 0);
  EXPECT_NEAR(laws::clutch_capacity<double>(p, 1, 170), 350, 1e-9);
  EXPECT_EQ(laws::clutch_capacity<double>(p, 1, 200), 700);
  EXPECT_NEAR(laws::clutch_capacity<double>(p, 0.5, 140), 350, 1e-9);
  EXPECT_EQ(laws::clutch_capacity<double>(p, 0, 140), 700);
}

// Power is lost whichever way it goes.
TEST(Driveline, GearsLosePowerEitherWay) {
  EXPECT_EQ(laws::gear_efficiency<double>(0.96, 100), 0.96);
  EXPECT_NEAR(laws::gear_efficiency<double>(0.96, -100), 1.0417, 1e-4);
}

// 40 N m of preload and a ramp of 0.3 under 500 N m: 95 N m at each wheel.
TEST(Driveline, LimitedSlipFollowsItsRamps) {
  Parameters<double> p = default_parameters();
  p[P::differential_preload_nm] = 40;
  p[P::differential_drive_ramp] = 0.3;
  p[P::differential_coast_ramp] = 0.1;
  EXPECT_NEAR(laws::limited_slip_torque<double>(p, 1, 500), 95, 1e-12);
  EXPECT_NEAR(laws::limited_slip_torque<double>(p, 1, -500), 45, 1e-12);
  EXPECT_NEAR(laws::limited_slip_torque<double>(p, 0.5, 500), 47.5, 1e-12);
}

// A standing car at full throttle in first gear: with the pedal down nothing gets to the wheels,
// half down half of the clutch's torque does while it slips.
TEST(Driveline, ThePedalTakesTheClutchsTorque) {
  const CarFiles files = test_car_files();
  Parameters<double> p = test_parameters();
  p[P::environment_wind_mps] = 0;
  const auto car = make_car(files, p, default_amplitudes());
  const auto after = [&](double pedal, Detail<double>& detail) {
    Simulation<double> sim = start(car, Road(), {.gear = 1});
    Controls<double> controls;
    controls.throttle_command = 1.0;
    controls.clutch_command = pedal;
    for (int i = 0; i < 300; ++i)
      EXPECT_TRUE(step(car, sim, controls, Road(), StepOptions{}, detail).ok());
    return sim.state;
  };
  Detail<double> open, slipping;
  const State<double> stands = after(1.0, open);
  EXPECT_EQ(open.clutch_nm, 0.0);
  EXPECT_LT(std::abs(stands[kVx]), 0.01);
  EXPECT_GT(stands[kEngine], 400.0);  // revs up
  const State<double> creeps = after(0.9, slipping);
  EXPECT_GT(creeps[kVx], 0.1);
  EXPECT_NEAR(slipping.clutch_nm, 0.1 * p[P::clutch_torque_nm], 0.1);
}

}  // namespace driveline_test
