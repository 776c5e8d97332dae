#include "vehicle/trend.h"

#include <gtest/gtest.h>

#include <cmath>

namespace trend_test {

// Least squares through (-0.2, 1), (-0.1, 2), (0, 2) by hand: mean 5/3 at -0.1, slope 5.
TEST(Trend, IsTheLineThroughTheLastFifthOfASecond) {
  const std::vector<double> time{0.0, 0.1, 0.2, 0.3, 0.4, 0.5}, values{90, 80, 1, 2, 2, 70};
  const auto [value, slope] = vehicle::trend(time, values, 4, 0);
  EXPECT_NEAR(slope, 5.0, 1e-12);
  EXPECT_NEAR(value, 5.0 / 3 + 0.5, 1e-12);
}

TEST(Trend, SaysNothingOfWhatWasNotLogged) {
  const std::vector<double> time{0.0, 0.1, 0.2}, values{NAN, 3.0, NAN};
  EXPECT_EQ(vehicle::trend(time, values, 2, 0), (std::pair{3.0, 0.0}));
  EXPECT_TRUE(std::isnan(vehicle::trend(time, values, 2, 2).first));
  EXPECT_EQ(vehicle::trend(time, values, 1, 1), (std::pair{3.0, 0.0}));
}

}  // namespace trend_test
