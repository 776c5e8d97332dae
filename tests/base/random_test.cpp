#include "base/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace random_test {

// The first numbers of the generator from state 1234567, as published with it (S. Vigna,
// splitmix64.c, and the tests of other implementations).
TEST(Random, GivesThePublishedNumbers) {
  base::Random random(1234567);
  EXPECT_EQ(random.next(), 6457827717110365317ULL);
  EXPECT_EQ(random.next(), 3203168211198807973ULL);
  EXPECT_EQ(random.next(), 9817491932198370423ULL);
  EXPECT_EQ(random.next(), 4593380528125082431ULL);
  EXPECT_EQ(random.next(), 16408922859458223821ULL);
}

TEST(Random, MomentsAreThoseOfTheDistributions) {
  base::Random random(1);
  const int n = 100000;
  double uniform = 0.0, normal = 0.0, normal2 = 0.0, normal4 = 0.0;
  for (int i = 0; i < n; ++i) {
    const double u = random.uniform(-2.0, 4.0), x = random.normal();
    EXPECT_GE(u, -2.0);
    EXPECT_LT(u, 4.0);
    uniform += u / n, normal += x / n, normal2 += x * x / n, normal4 += x * x * x * x / n;
  }
  // Five standard errors: sqrt(3 / n), sqrt(1 / n), sqrt(2 / n), sqrt(96 / n).
  EXPECT_NEAR(uniform, 1.0, 5.0 * std::sqrt(3.0 / n));
  EXPECT_NEAR(normal, 0.0, 5.0 * std::sqrt(1.0 / n));
  EXPECT_NEAR(normal2, 1.0, 5.0 * std::sqrt(2.0 / n));
  EXPECT_NEAR(normal4, 3.0, 5.0 * std::sqrt(96.0 / n));
}

}  // namespace random_test
