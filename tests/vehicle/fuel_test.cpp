#include "vehicle/laws/fuel.h"

#include <gtest/gtest.h>

namespace fuel_test {

using namespace vehicle;  // NOLINT: a test of this library

// 200 N m at 500 rad/s are 100 kW; at 32 % of 43 MJ/kg 7.267 g/s, and 0.4 g/s for idling. That is
// 276 g/kWh, as spark-ignition engines burn.
TEST(Fuel, BurnsByUsefulPower) {
  const Parameters<double> p = default_parameters();
  EXPECT_NEAR(laws::fuel_kgps<double>(p, 200, 500), 7.667e-3, 1e-6);
  EXPECT_NEAR(laws::fuel_kgps<double>(p, 200, 500) * 3.6e6 / 100, 276, 0.5);
  EXPECT_EQ(laws::fuel_kgps<double>(p, -30, 500), 4e-4);
}

}  // namespace fuel_test
