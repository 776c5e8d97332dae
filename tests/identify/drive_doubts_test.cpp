// What the channels of a drive say against its vehicle file.
#include "drive_doubts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "support/places.h"
#include "vehicle/vehicle_file.h"

namespace drive_doubts_test {

using identify::DriveWindow, identify::DriveWindows;

TEST(DriveDoubts, SteeringSaysAWrongWheelbase) {
  vehicle::Vehicle v =
      vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  const auto car_of = [&](double wheelbase_m) {
    v.parameters[vehicle::Parameter::chassis_wheelbase_m] = wheelbase_m;
    return make_car(v.files, v.parameters, v.terms, v.contact);
  };
  base::Random dice = base::random_of(1, "steering");
  DriveWindows drive;
  recording::Recording recording;
  std::vector<double> steer;
  for (int k = 0; k < 120; ++k) {  // a slow drive through bends, 2.8 m between the axles
    DriveWindow w;
    w.vx_mps = 8.0 + 0.1 * k;
    w.yaw_rate_radps = 4.0 * std::sin(0.7 * k) / w.vx_mps;
    w.block = static_cast<std::size_t>(k / 6);
    w.begin_row = steer.size();
    for (int row = 0; row < 10; ++row)
      steer.push_back(2.8 * w.yaw_rate_radps / w.vx_mps + 0.0004 * w.yaw_rate_radps * w.vx_mps +
                      0.01 + 0.001 * dice.normal());
    w.end_row = steer.size();
    drive.windows.push_back(w);
  }
  EXPECT_TRUE(std::isnan(with_wheelbase(drive, recording).wheelbase_m)) << "no steering";
  recording.table.add("steer_rad", steer);
  drive = with_wheelbase(drive, recording);
  EXPECT_NEAR(drive.wheelbase_m, 2.8, 0.05);
  EXPECT_EQ(identify::wheelbase_off(car_of(2.8), drive), 0.0);
  EXPECT_EQ(identify::wheelbase_off(car_of(2.9), drive), 0.0) << "within what toe may add";
  EXPECT_NEAR(identify::wheelbase_off(car_of(3.2), drive), 2.8 / 3.2 - 1.0, 0.02);
}

}  // namespace drive_doubts_test
