// Quantiles against tables.
#include "base/interval90.h"

#include <gtest/gtest.h>

namespace interval90_test {

TEST(Interval90, QuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(base::t90(3.0), 2.353363, 0.003 * 2.353363);
  EXPECT_NEAR(base::t90(10.0), 1.812461, 2e-4);
  EXPECT_NEAR(base::t90(30.0), 1.697261, 1e-5);
  EXPECT_NEAR(base::t90(1e9), 1.644854, 1e-6);
}

}  // namespace interval90_test
