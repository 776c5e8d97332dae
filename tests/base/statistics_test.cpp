#include "base/statistics.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace statistics_test {

TEST(Statistics, MedianIsTheUpperOfTheTwoInTheMiddle) {
  EXPECT_EQ(base::median(std::vector<double>{5.0}), 5.0);
  EXPECT_EQ(base::median(std::vector<double>{9.0, 1.0, 4.0}), 4.0);
  EXPECT_EQ(base::median(std::vector<int>{7, 1, 5, 3}), 5);
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(base::median(std::vector<double>{infinity, -infinity, 2.0}), 2.0);
}

TEST(Statistics, QuantilesAreValuesOfTheSample) {
  const std::vector<double> values = {30.0, 10.0, 50.0, 20.0, 40.0};
  EXPECT_EQ(base::quantile(values, 0.0), 10.0);
  EXPECT_EQ(base::quantile(values, 0.5), 30.0);
  EXPECT_EQ(base::quantile(values, 0.74), 30.0);
  EXPECT_EQ(base::quantile(values, 0.75), 40.0);
  EXPECT_EQ(base::quantile(values, 1.0), 50.0);
  EXPECT_EQ(values[0], 30.0);
}

TEST(Statistics, NoValuesHaveTheMedianThatIsGiven) {
  EXPECT_EQ(base::median_or(-1.0, {}), -1.0);
  EXPECT_EQ(base::median_or(-1.0, {3.0}), 3.0);
}

}  // namespace statistics_test
