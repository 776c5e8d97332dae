// The built-in road is what its header says.
#include "identify/proving_road.h"

#include <gtest/gtest.h>

#include <cmath>

#include "crg/surface.h"

namespace proving_road_test {

TEST(ProvingRoad, HasItsTurnsBanksDipAndCrestAndDoesNotCrossItself) {
  const crg::Surface road(identify::proving_road());
  const auto& line = road.reference_line();
  ASSERT_FALSE(line.closed);
  double left = 0.0, right = 0.0, turned = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double k = (line.heading_rad[i] - line.heading_rad[i - 1]) / line.u_step_m;
    if (i > 1) {
      left = std::max(left, k);
      right = std::min(right, k);
    }
  }
  turned = line.heading_rad.back() - line.heading_rad.front();
  EXPECT_NEAR(1.0 / left, 45.0, 0.5);
  EXPECT_NEAR(1.0 / right, -28.0, 0.5);
  EXPECT_LT(std::abs(turned), 6.3);
  double bank = 0.0, low = 0.0, high = 0.0;
  const double length = line.u_step_m * static_cast<double>(line.size() - 1);
  for (double u = 1.0; u < length; u += 5.0) {
    bank = std::max(bank, std::abs(road.z_at_uv(u, 3.0) - road.z_at_uv(u, -3.0)) / 6.0);
    low = std::min(low, road.z_at_uv(u, 0.0));
    high = std::max(high, road.z_at_uv(u, 0.0));
  }
  EXPECT_NEAR(bank, 0.1, 0.001);
  EXPECT_NEAR(low, -10.0, 0.05);
  EXPECT_NEAR(high, 10.0, 0.05);
  // Places 60 m of road apart stay further apart than the road is wide.
  for (std::size_t i = 0; i < line.size(); i += 40)
    for (std::size_t j = i + 240; j < line.size(); j += 40)
      EXPECT_GT(std::hypot(line.x_m[i] - line.x_m[j], line.y_m[i] - line.y_m[j]), 40.0)
          << i << " " << j;
}

}  // namespace proving_road_test
