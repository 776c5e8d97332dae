#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "crg.h"
#include "crg/surface.h"
#include "roads.h"

namespace crg {
namespace c_api_test {

TEST(CApi, AnswersWhatTheCppInterfaceAnswers) {
  const ReferenceLine line = test::circuit(2001, 40.0, 0.1, 3);
  const Crg crg = make_crg(line, test::grid_of(line, -4.0, 4.0, 17, [](double u, double v) {
                             return 0.1 * std::sin(u) + 0.02 * v;
                           }));
  const test::Folder folder;
  write(crg, folder.file("road.crg"), Format::KRBI);
  const Surface surface(crg);
  char why[100] = "";
  crg_open_options options = {};
  options.struct_size = sizeof options;
  options.friction = 0.8;
  crg_surface* c = crg_open(folder.file("road.crg").c_str(), &options, why, sizeof why);
  ASSERT_NE(c, nullptr) << why;
  EXPECT_EQ(crg_is_closed(c), 1);
  double u0, u1, v0, v1;
  crg_range(c, &u0, &u1, &v0, &v1);
  EXPECT_EQ(u0, 0.0);
  EXPECT_EQ(v0, -4.0);
  EXPECT_EQ(v1, 4.0);
  crg_cursor cursor = {};
  Cursor own;
  for (double u = 0.5; u < u1; u += 3.1) {
    double x, y, back_u, back_v;
    crg_xy_of_uv(c, u, 1.5, &x, &y);
    const Sample want = surface.at_xy(x, y, own);
    crg_sample sample;
    ASSERT_EQ(crg_at_xy(c, x, y, &cursor, &sample), 1);
    EXPECT_EQ(sample.z_m, want.z_m);
    EXPECT_EQ(sample.dzdy, want.dzdy);
    EXPECT_EQ(sample.normal_z, want.normal_z);
    EXPECT_EQ(sample.curvature_1pm, want.curvature_1pm);
    EXPECT_EQ(sample.friction, 0.8);
    EXPECT_EQ(crg_z_at_xy(c, x, y, nullptr), want.z_m) << "without a cursor";
    EXPECT_EQ(crg_z_at_uv(c, u, 1.5), surface.z_at_uv(u, 1.5));
    crg_uv_of_xy(c, x, y, &cursor, &back_u, &back_v);
    EXPECT_NEAR(back_u, u, 1e-9);
    float dz[12];
    const double base = crg_strip(c, x, y, 0.3, 3, 4, 0.01, dz, &cursor);
    EXPECT_NEAR(base + 0.25 * (dz[5] + dz[6] + dz[1] + dz[2]), want.z_m, 0.02);
  }
  crg_close(c);
  crg_close(nullptr);
}

TEST(CApi, GivesPlaceAndHeadingWithoutAHeight) {
  const ReferenceLine line = test::line_along(41, 0.5, [](double) { return 0.02; });
  Crg crg = make_crg(line, test::grid_of(line, -2.0, 2.0, 5, [](double, double) { return 1.0; }));
  for (std::size_t i = 10; i < 20; ++i) crg.grid.at(i, 2) = crg.grid.at(i, 3) = NAN;
  set_value(crg.options, "BORDER_MODE_U", 0.0);
  set_value(crg.options, "BORDER_MODE_V", 0.0);
  const test::Folder folder;
  write(crg, folder.file("road.crg"), Format::KRBI);
  crg_surface* road = crg_open(folder.file("road.crg").c_str(), nullptr, nullptr, 0);
  ASSERT_NE(road, nullptr);
  // In a hole, beside the road, before its begin and behind its end.
  for (const auto& [u, v] : {std::pair{7.3, 0.4}, {7.3, 3.0}, {-1.0, 0.5}, {25.0, -0.5}}) {
    crg_sample by_uv, by_xy;
    double x, y;
    crg_cursor cursor = {};
    EXPECT_EQ(crg_at_uv(road, u, v, &by_uv), 0) << u;
    crg_xy_of_uv(road, u, v, &x, &y);
    EXPECT_EQ(crg_at_xy(road, x, y, &cursor, &by_xy), 0) << u;
    for (const crg_sample& sample : {by_uv, by_xy}) {
      EXPECT_NEAR(sample.u_m, u, 1e-9);
      EXPECT_NEAR(sample.v_m, v, 1e-9);
      EXPECT_NEAR(sample.x_m, x, 1e-9);
      EXPECT_NEAR(sample.y_m, y, 1e-9);
      EXPECT_TRUE(std::isfinite(sample.heading_rad)) << u;
      EXPECT_TRUE(std::isfinite(sample.curvature_1pm)) << u;
      EXPECT_TRUE(std::isnan(sample.z_m)) << u;
    }
  }
  crg_close(road);
}

TEST(CApi, RefusalsSayWhyAndOldCallersMayKnowLess) {
  char why[30];
  std::memset(why, 'x', sizeof why);
  EXPECT_EQ(crg_open("/nowhere/road.crg", nullptr, why, sizeof why), nullptr);
  EXPECT_EQ(std::string(why), std::string("/nowhere/road.crg: cannot open: ").substr(0, 29));
  EXPECT_EQ(crg_open("/nowhere/road.crg", nullptr, nullptr, 0), nullptr);
  EXPECT_EQ(crg_api_version(), CRG_API_VERSION);
  const ReferenceLine line = test::line_along(5, 1.0, [](double) { return 0.0; });
  const test::Folder folder;
  write(make_crg(line, test::grid_of(line, -1.0, 1.0, 2, [](double, double) { return 1.0; })),
        folder.file("r.crg"), Format::LRFI);
  crg_open_options options = {};
  options.struct_size = sizeof options.struct_size;  // knows of no other field
  options.friction_path = "/nowhere/mu.crg";
  crg_surface* surface = crg_open(folder.file("r.crg").c_str(), &options, why, sizeof why);
  EXPECT_NE(surface, nullptr);
  crg_close(surface);
}

}  // namespace c_api_test
}  // namespace crg
