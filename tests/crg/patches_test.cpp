#include "crg/patches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "crg/error.h"
#include "roads.h"

namespace crg {
namespace patches_test {

Crg base_road() {
  const ReferenceLine line = test::line_along(101, 1.0, [](double) { return 0.0; });
  return make_crg(line,
                  test::grid_of(line, -5.0, 5.0, 11, [](double u, double) { return 0.01 * u; }));
}

// A kerb of 10 cm on x from 40 to 44, y from 2 to 4, drawn in another direction.
Crg kerb() {
  const ReferenceLine line = test::line_along(
      41, 0.1, [](double) { return 0.0; }, 44.0, 3.0, std::numbers::pi);
  return make_crg(line, test::grid_of(line, -1.0, 1.0, 21,
                                      [](double u, double) { return 0.01 * (44.0 - u) + 0.1; }));
}

PatchedSurface stack() {
  std::vector<PatchedSurface::Patch> patches;
  patches.push_back({Surface(kerb()), 0.5});
  return PatchedSurface(Surface(base_road()), std::move(patches));
}

TEST(Patches, ReplaceTheBaseInsideAndLeaveItOutside) {
  const PatchedSurface surface = stack();
  Cursor cursor;
  EXPECT_NEAR(surface.z_at_xy(42.0, 3.0, cursor), 0.42 + 0.1, 1e-6);
  EXPECT_NEAR(surface.z_at_xy(42.0, 0.0, cursor), 0.42, 1e-6);
  EXPECT_NEAR(surface.z_at_xy(39.9, 3.0, cursor), 0.399, 1e-6);
  EXPECT_NEAR(surface.z_at_xy(40.25, 3.0, cursor), 0.4025 + 0.05, 1e-6)
      << "half way through the blended border";
  EXPECT_NEAR(surface.z_at_xy(40.0, 3.0, cursor), 0.4, 1e-6);
  EXPECT_NEAR(surface.at_xy(42.0, 3.0, cursor).u_m, 42.0, 1e-9) << "u is the base's";
}

TEST(Patches, GradientFollowsTheBlend) {
  const PatchedSurface surface = stack();
  Cursor cursor;
  const double h = 1e-5;
  for (double x = 39.53; x < 44.5; x += 0.137) {
    for (double y = 1.72; y < 4.4; y += 0.113) {
      const Sample sample = surface.at_xy(x, y, cursor);
      const auto z = [&](double px, double py) { return surface.z_at_xy(px, py, cursor); };
      // Where the nearest border changes from one to another there is a kink.
      const double to_u = std::min(x - 40.0, 44.0 - x), to_v = std::min(y - 2.0, 4.0 - y);
      if (std::abs(to_u - to_v) < 1e-3) continue;
      ASSERT_NEAR(sample.dzdx, (z(x + h, y) - z(x - h, y)) / (2.0 * h), 1e-6) << x << " " << y;
      ASSERT_NEAR(sample.dzdy, (z(x, y + h) - z(x, y - h)) / (2.0 * h), 1e-6) << x << " " << y;
      ASSERT_NEAR(sample.normal_x + sample.dzdx * sample.normal_z, 0.0, 1e-12);
    }
  }
}

TEST(Patches, HolesInThePatchShowTheBaseAndHolesInTheBaseThePatch) {
  Crg holed_patch = kerb(), holed_base = base_road();
  for (std::size_t i = 15; i < 25; ++i) {
    for (std::size_t j = 0; j < 21; ++j) holed_patch.grid.at(i, j) = NAN;
  }
  for (std::size_t j = 0; j < 11; ++j) holed_base.grid.at(42, j) = NAN;
  std::vector<PatchedSurface::Patch> patches;
  patches.push_back({Surface(holed_patch), 0.1});
  const PatchedSurface over_good(Surface(base_road()), std::move(patches));
  Cursor cursor;
  EXPECT_NEAR(over_good.z_at_xy(42.0, 3.0, cursor), 0.42, 1e-6);
  patches.clear();
  patches.push_back({Surface(kerb()), 0.1});
  const PatchedSurface over_hole(Surface(holed_base), std::move(patches));
  EXPECT_NEAR(over_hole.z_at_xy(42.0, 3.0, cursor), 0.52, 1e-6);
  EXPECT_TRUE(std::isnan(over_hole.z_at_xy(42.0, 0.0, cursor)));
}

TEST(Patches, AnIndexFileNamesThem) {
  const test::Folder folder;
  write(base_road(), folder.file("base.crg"), Format::KRBI);
  write(kerb(), folder.file("kerb.crg"), Format::KRBI);
  std::ofstream(folder.file("road.patches"))
      << "# a road with a kerb\nbase base.crg\n\npatch kerb.crg blend_m=0.5  # inside of turn 1\n";
  const PatchedSurface surface(read_patch_index(folder.file("road.patches")));
  Cursor cursor;
  EXPECT_NEAR(surface.z_at_xy(42.0, 3.0, cursor), 0.52, 1e-6);
  const auto refused = [&](const std::string& text) {
    std::ofstream(folder.file("bad")) << text;
    try {
      read_patch_index(folder.file("bad"));
    } catch (const Error& error) {
      return std::string(error.what()).substr(folder.file("bad").size());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refused("base a\npatch b blend_m=-1\n").substr(0, 4), ":2: ");
  EXPECT_EQ(refused("road a\n").substr(0, 4), ":1: ");
  EXPECT_EQ(refused("base a\nbase b\n").substr(0, 4), ":2: ");
  EXPECT_EQ(refused("patch a\n"), ": no line \"base FILE\"");
}

}  // namespace patches_test
}  // namespace crg
