// The built-in driver at one moment: what he does with his feet and hands.
#include "vehicle/driver.h"

#include <gtest/gtest.h>

#include "test_car.h"
#include "test_roads.h"

namespace driver_test {

using namespace vehicle;  // NOLINT: a test of this library

/// A driver on the line of a road, where it begins to bend to the left.
struct AtTheBend {
  crg::Surface surface{stadium()};
  RacingLine line;
  Driver driver;
  State<double> state{};

  AtTheBend(const Car<double>& car, double vx_mps) {
    line = plan_line(surface);
    plan_speed(line, car, {});
    while (line.curvature_1pm[driver.station] < 0.01) ++driver.station;
    driver.s_m = line.s_m[driver.station];
    state[kX] = line.x_m[driver.station];
    state[kY] = line.y_m[driver.station];
    state[kYaw] = line.heading_rad[driver.station];
    state[kVx] = vx_mps;
    state[kYawRate] = vx_mps * line.curvature_1pm[driver.station];
  }
  double steering(const Car<double>& car, const Detail<double>& detail) const {
    Driver now = driver;
    return drive(now, line, car, state, detail).steer_command_rad;
  }
};

Detail<double> loads(double front_n, double rear_n) {
  Detail<double> out{};
  for (std::size_t i = 0; i < kWheels; ++i) out.wheel[i].fz_n = i < 2 ? front_n : rear_n;
  return out;
}

// Braking or a bump lifts the rear wheels: by their loads of that moment the car would oversteer,
// and he would turn the wheels out of the bend.
TEST(Driver, SteersIntoABendWhateverABumpDoesToTheLoads) {
  const CarFiles files = test_car_files();
  const Car<double> car = make_car(files, default_parameters(), default_amplitudes());
  const AtTheBend at(car, 45.0);
  const double steady = at.steering(car, loads(2000.0, 2400.0));
  EXPECT_GT(steady, 0.0);
  EXPECT_DOUBLE_EQ(at.steering(car, loads(4200.0, 200.0)), steady);
  EXPECT_DOUBLE_EQ(at.steering(car, loads(0.0, 4400.0)), steady);
}

// A car that is heavy behind: he still steers to the left for a bend to the left, though at a high
// speed it would turn by itself.
TEST(Driver, SteersIntoABendACarThatOversteers) {
  const CarFiles files = test_car_files();
  Parameters<double> p = default_parameters();
  p[Parameter::chassis_cog_behind_front_m] = 0.75 * p[Parameter::chassis_wheelbase_m];
  p[Parameter::front_lift_area_m2] = p[Parameter::rear_lift_area_m2] = 0.0;
  const Car<double> car = make_car(files, p, default_amplitudes());
  for (const double vx_mps : {20.0, 35.0, 50.0})
    EXPECT_GT(AtTheBend(car, vx_mps).steering(car, loads(2200.0, 2200.0)), 0.0) << vx_mps;
}

// The tyres of a locked axle push straight on: the driver turns the wheels further.
TEST(Driver, TurnsALockedAxleByMoreSteering) {
  const CarFiles files = test_car_files();
  Amplitudes<double> terms = default_amplitudes();
  const Car<double> open = make_car(files, default_parameters(), terms);
  terms[Term::locked_differential] = 1.0;
  const Car<double> locked = make_car(files, default_parameters(), terms);
  const AtTheBend at(open, 20.0);
  const Detail<double> detail = loads(2000.0, 2400.0);
  EXPECT_GT(at.steering(locked, detail), 1.1 * at.steering(open, detail));
}

}  // namespace driver_test
