// What is not known of rolling wheels counts in slip ratios.
#include "rolling_doubt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/places.h"
#include "vehicle/vehicle_file.h"

namespace rolling_doubt_test {

TEST(RollingDoubt, CountsByRadiusAndRollingResistance) {
  const vehicle::Vehicle v =
      vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
  const auto car = make_car(v.files, v.parameters, v.terms, v.contact);
  const auto begin = [] {
    identify::Forces f;
    for (auto& w : f.wheel) {
      w.fz_n.value = {2000.0, 4000.0, 3000.0};
      w.kappa = {{0.0, 0.0, 0.0}, {0.0, 0.0, 1e-4}};
      w.alpha_rad.value = {0.0, 0.0, 0.0};
      w.vx_mps = {40.0, 40.0, 40.0};
    }
    return f;
  };
  const double none = std::numeric_limits<double>::quiet_NaN();
  std::array<std::vector<double>, vehicle::kWheels> radius;
  radius.fill({0.301, 0.299, none});
  identify::Forces f = begin();
  identify::add_rolling_doubt(car, 1.0, radius, f);
  // A hundredth of the load resists, a slip stiffness of some 20 to 40 loads meets it.
  const double front = f.wheel[0].kappa.sd[1];
  EXPECT_GT(front, 1.0 / 300.0);
  EXPECT_LT(front, 1.0 / 300.0 + 1e-3);
  // The rows' own radius is 1/300 from the mean, either way.
  EXPECT_GT(f.wheel[0].kappa.sd[0], 1.0 / 300.0);
  EXPECT_EQ(f.wheel[0].kappa.sd[2], 1e-4);  // no forces in that row
  identify::Forces half = begin();
  identify::add_rolling_doubt(car, 0.5, radius, half);
  EXPECT_NEAR(half.wheel[0].kappa.sd[1], 0.5 * front, 1e-12);
  // Where radii stay, rolling resistance is left.
  radius.fill({0.3, 0.3, 0.3});
  identify::Forces steady = begin();
  identify::add_rolling_doubt(car, 1.0, radius, steady);
  EXPECT_GT(steady.wheel[2].kappa.sd[0], 1e-4);
  EXPECT_LT(steady.wheel[2].kappa.sd[0], 1e-3);
  // A tyre that drives in a turn yields more to it; one at its peak, no more than tenfold.
  identify::Forces drives = begin();
  drives.wheel[2].kappa.value = {0.03, 0.5, 0.0};
  drives.wheel[2].alpha_rad.value = {0.03, 0.0, 0.0};
  identify::add_rolling_doubt(car, 1.0, radius, drives);
  EXPECT_GT(drives.wheel[2].kappa.sd[0], steady.wheel[2].kappa.sd[0]);
  EXPECT_LT(drives.wheel[2].kappa.sd[1], 10.0 * steady.wheel[2].kappa.sd[1] + 1e-9);
}

}  // namespace rolling_doubt_test
