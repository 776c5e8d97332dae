// What a log of a tyre shows beside slip.
#include "tyre_varied.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "identify/tyre_fit.h"

namespace tyre_varied_test {

using identify::Needs;

vehicle::TyreCoefficients nominal() {
  vehicle::TyreCoefficients out;
  out.nominal_load_n = 3000.0;
  out.lfzo = 1.0;
  return out;
}

/// Both wheels of a car that rolls by 0.02 rad at its limit; `free_rad` of camber come from
/// elsewhere.
identify::TyreSamples driven(double free_rad) {
  base::Random dice = base::random_of(3, "camber");
  identify::TyreSamples out;
  for (int k = 0; k < 500; ++k)
    for (const double side : {1.0, -1.0}) {
      const double turn = std::sin(0.05 * k), force = std::tanh(2.0 * turn);
      const double roll = 0.02 * force;
      out.conditions.push_back({3000.0 + side * 1200.0 * force, 0.0, side * 0.1 * turn,
                                side * roll + free_rad * dice.normal(), 40.0, 0.0});
      out.fx_n.push_back(0.0);
      out.fy_n.push_back(0.0);
    }
  return out;
}

bool camber(const identify::Varied& v) {
  return v.by_need[static_cast<std::size_t>(Needs::kCamber)];
}

TEST(TyreVaried, CamberThatIsRollIsNotToldFromSideSlip) {
  const identify::Varied roll = identify::varied(driven(0.001), nominal());
  EXPECT_FALSE(camber(roll));
  EXPECT_TRUE(roll.camber_follows);
  const identify::Varied banked = identify::varied(driven(0.02), nominal());
  EXPECT_TRUE(camber(banked));
  EXPECT_FALSE(banked.camber_follows);
}

TEST(TyreVaried, UprightWheelsHaveNoCamberToFollow) {
  identify::TyreSamples rows = driven(0.0);
  for (auto& c : rows.conditions) c.gamma_rad *= 0.1;
  const identify::Varied v = identify::varied(rows, nominal());
  EXPECT_FALSE(camber(v));
  EXPECT_FALSE(v.camber_follows);
  EXPECT_TRUE(v.by_need[static_cast<std::size_t>(Needs::kLoad)]);
  EXPECT_FALSE(v.by_need[static_cast<std::size_t>(Needs::kPressure)]);
}

}  // namespace tyre_varied_test
