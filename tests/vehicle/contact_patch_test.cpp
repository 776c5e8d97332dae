#include "vehicle/laws/contact_patch.h"

#include <gtest/gtest.h>

#include <cmath>

namespace contact_patch_test {

using namespace vehicle;  // NOLINT: a test of this library

// A string of relaxation length 0.4 m that starts to slide builds up its deflection over the
// distance travelled: 63.2 % of the end after 0.4 m, whatever the speed; the end is slip times
// sigma, with and without damping.
TEST(ContactPatch, RelaxesOverItsLength) {
  for (const double speed : {10.0, 40.0}) {
    const auto run = [&](double damping_s, double metres) {
      const auto lag = laws::patch_lag<double>(laws::patch_transport<double>(speed, 0.02 * speed),
                                               0.4, damping_s);
      double u = 0;
      const double step = metres / speed / 20000;
      for (int i = 0; i < 20000; ++i) u += step * (lag.yield * 0.02 * speed - lag.decay_1ps * u);
      return u;
    };
    EXPECT_NEAR(run(0, 0.4), 0.02 * 0.4 * (1 - std::exp(-1.0)), 1e-6);
    EXPECT_NEAR(run(0, 20), 0.02 * 0.4, 1e-6);
    EXPECT_NEAR(run(0.005, 20), 0.02 * 0.4, 1e-6);
    // Damping in series lengthens the time constant by itself: 0.4 m / v + tau.
    EXPECT_NEAR(run(0.005, speed * (0.4 / speed + 0.005)), 0.02 * 0.4 * (1 - std::exp(-1.0)), 1e-6);
  }
}

// A wheel that spins on the spot renews its patch by sliding: its slip ends at 1.5.
TEST(ContactPatch, SpinningOnTheSpotEndsAtTheLargestSlip) {
  const double sliding = 9, transport = laws::patch_transport<double>(0, sliding);
  EXPECT_NEAR(sliding / transport, 1.5, 1e-12);
  EXPECT_EQ(laws::patch_transport<double>(20, sliding), 20);
}

// A carcass that holds a slip of 0.1 over 0.4 m keeps 40 mm once it stands, and all of a sliding
// wheel's while it slides fast.
TEST(ContactPatch, UnwindsWhatTheCarcassCannotHold) {
  EXPECT_EQ(laws::patch_unwinding<double>(0, 0.1, 0.4, 0.039), 0);
  EXPECT_NEAR(laws::patch_unwinding<double>(0, 0.1, 0.4, -0.080), 0.5 / 0.005, 1e-9);
  EXPECT_EQ(laws::patch_unwinding<double>(3.0, 0.1, 0.4, 0.59), 0);
  EXPECT_GT(laws::patch_unwinding<double>(1.0, 0.1, 0.4, 0.59), 0);
}

}  // namespace contact_patch_test
