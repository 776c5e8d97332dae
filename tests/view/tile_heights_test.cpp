#include "tile_heights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "crg/file.h"
#include "support/temporary_folder.h"
#include "wish.h"

namespace tile_heights_test {

/// A road of 100 m along x at y = 50,000, 4 m wide to each side, that rises by 2 % and leans by 1
/// %; its own borders would go on for ever.
std::string road(const support::TemporaryFolder& folder) {
  crg::ReferenceLine line;
  crg::Grid grid;
  for (int j = -4; j <= 4; ++j) grid.v_m.push_back(j);
  grid.u_step_m = line.u_step_m = 0.5;
  for (int i = 0; i <= 200; ++i) {
    line.x_m.push_back(0.5 * i);
    line.y_m.push_back(50'000.0);
    line.heading_rad.push_back(0.0);
    for (const double v : grid.v_m)
      grid.z_m.push_back(static_cast<float>(0.02 * line.x_m.back() + 0.01 * v));
  }
  crg::Crg file = crg::make_crg(line, std::move(grid));
  for (const char* const border : {"BORDER_MODE_U", "BORDER_MODE_V"})
    crg::set_value(file.options, border, 2.0);
  crg::write(file, folder.path("road.crg"), crg::Format::KRBI);
  return folder.path("road.crg");
}

TEST(TileHeights, AreThoseOverTheRoadAndNoneBesideIt) {
  const support::TemporaryFolder folder;
  // Places relative to (10, 50000, 1); seven bytes of something else in front of them.
  const std::vector<float> xyz_m = {20.0F, 2.0F,  0.0F, 60.25F, -3.9F, 5.0F,
                                    20.0F, 4.25F, 0.0F, 95.0F,  0.0F,  0.0F};
  std::string bytes = "before.";
  bytes.append(reinterpret_cast<const char*>(xyz_m.data()), xyz_m.size() * sizeof(float));
  const std::string path = folder.file("points.tiles", bytes);
  const crg::Surface surface(crg::read(road(folder)));
  const std::string told = view::heights_over(surface, path, {"7", "4", {10.0, 50'000.0, 1.0}});
  ASSERT_EQ(told.size(), 4 * sizeof(float));
  std::vector<float> above_m(4);
  std::memcpy(above_m.data(), told.data(), told.size());
  EXPECT_NEAR(above_m[0], 1.0 - (0.02 * 30.0 + 0.01 * 2.0), 1e-5);
  EXPECT_NEAR(above_m[1], 6.0 - (0.02 * 70.25 - 0.01 * 3.9), 1e-5);
  EXPECT_TRUE(std::isnan(above_m[2])) << "beside the road";
  EXPECT_TRUE(std::isnan(above_m[3])) << "behind its end";
}

TEST(TileHeights, OfPointsThatAreNotThereAreRefused) {
  const support::TemporaryFolder folder;
  const std::string path = folder.file("points.tiles", std::string(24, '\0'));
  const crg::Surface surface(crg::read(road(folder)));
  const auto status = [&](const std::string& begin, const std::string& points) {
    try {
      view::heights_over(surface, path, {begin, points, {}});
    } catch (const view::Refusal& refusal) {
      return refusal.status;
    }
    return 200;
  };
  EXPECT_EQ(status("0", "2"), 200);
  EXPECT_EQ(status("0", "3"), 416);
  EXPECT_EQ(status("12", "2"), 416);
  for (const char* const wrong : {"", "-1", "1.5", "x", "1000001", "18446744073709551615"}) {
    EXPECT_EQ(status("0", wrong), 400) << wrong;
  }
}

}  // namespace tile_heights_test
