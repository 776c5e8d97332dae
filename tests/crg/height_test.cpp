// Border modes, offsets, smoothing zones and friction on a plane whose heights are known by hand:
// z = 1 + 0.5 u + 0.25 v on u in [0, 10], v in [-2, 2].
#include <gtest/gtest.h>

#include <cmath>

#include "crg/error.h"
#include "crg/surface.h"
#include "roads.h"

namespace crg {
namespace height_test {

double plane(double u, double v) { return 1.0 + 0.5 * u + 0.25 * v; }

Crg flat_road(std::initializer_list<std::pair<const char*, double>> options) {
  const ReferenceLine line = test::line_along(11, 1.0, [](double) { return 0.0; });
  Crg crg = make_crg(line, test::grid_of(line, -2.0, 2.0, 5, plane));
  for (const auto& [key, value] : options) set_value(crg.options, key, value);
  return crg;
}

double z(std::initializer_list<std::pair<const char*, double>> options, double u, double v) {
  return Surface(flat_road(options)).z_at_uv(u, v);
}

TEST(Height, BorderModesAlongU) {
  EXPECT_TRUE(std::isnan(z({{"BORDER_MODE_U", 0}}, -1.0, 0.0)));
  EXPECT_TRUE(std::isnan(z({{"BORDER_MODE_U", 0}}, 10.5, 0.0)));
  EXPECT_EQ(z({{"BORDER_MODE_U", 0}}, 10.0, 0.0), plane(10.0, 0.0));
  EXPECT_EQ(z({{"BORDER_MODE_U", 1}}, -1.0, 1.0), 0.0);
  EXPECT_EQ(z({}, -1.0, 1.0), plane(0.0, 1.0)) << "keep is the default";
  EXPECT_EQ(z({{"BORDER_MODE_U", 3}}, 12.5, 1.0), plane(2.5, 1.0));
  EXPECT_EQ(z({{"BORDER_MODE_U", 3}}, -27.5, 1.0), plane(2.5, 1.0));
  EXPECT_EQ(z({{"BORDER_MODE_U", 4}}, 12.5, 1.0), plane(7.5, 1.0));
  EXPECT_EQ(z({{"BORDER_MODE_U", 4}}, -2.5, 1.0), plane(2.5, 1.0));
}

TEST(Height, BorderModesAlongV) {
  EXPECT_TRUE(std::isnan(z({{"BORDER_MODE_V", 0}}, 5.0, 2.5)));
  EXPECT_EQ(z({{"BORDER_MODE_V", 0}}, 5.0, -2.0), plane(5.0, -2.0));
  EXPECT_EQ(z({{"BORDER_MODE_V", 1}}, 5.0, 2.5), 0.0);
  EXPECT_EQ(z({}, 5.0, 2.5), plane(5.0, 2.0));
  EXPECT_EQ(z({{"BORDER_MODE_V", 3}}, 5.0, 2.5), plane(5.0, -1.5));
  EXPECT_EQ(z({{"BORDER_MODE_V", 4}}, 5.0, 2.5), plane(5.0, 1.5));
}

TEST(Height, OffsetsCountBeyondTheBorderTheyBelongToAndAddUpAtCorners) {
  const std::initializer_list<std::pair<const char*, double>> offsets = {
      {"BORDER_OFFSET_U", 0.5}, {"BORDER_OFFSET_V", 0.125}};
  EXPECT_EQ(z(offsets, 5.0, 1.0), plane(5.0, 1.0));
  EXPECT_EQ(z(offsets, 11.0, 1.0), plane(10.0, 1.0) + 0.5);
  EXPECT_EQ(z(offsets, 5.0, 3.0), plane(5.0, 2.0) + 0.125);
  EXPECT_EQ(z(offsets, 11.0, 3.0), plane(10.0, 2.0) + 0.625);
}

TEST(Height, ZeroWinsOverKeepAtCorners) {
  EXPECT_EQ(z({{"BORDER_MODE_V", 1}}, 11.0, 3.0), 0.0);
  EXPECT_EQ(z({{"BORDER_MODE_V", 1}, {"BORDER_OFFSET_V", 0.25}}, 11.0, 3.0), 0.25);
}

TEST(Height, SmoothingZonesRiseFromTheLineAndOverlapWithoutAJump) {
  EXPECT_EQ(z({{"BORDER_SMOOTH_UBEG", 4.0}}, 1.0, 0.0), 0.25 * plane(1.0, 0.0));
  EXPECT_EQ(z({{"BORDER_SMOOTH_UBEG", 4.0}}, 4.0, 0.0), plane(4.0, 0.0));
  EXPECT_EQ(z({{"BORDER_SMOOTH_UEND", 4.0}}, 9.0, 0.0), 0.25 * plane(9.0, 0.0));
  EXPECT_EQ(z({{"BORDER_SMOOTH_UEND", 4.0}}, 10.0, 0.0), 0.0);
  const Surface overlapping(flat_road({{"BORDER_SMOOTH_UBEG", 8.0}, {"BORDER_SMOOTH_UEND", 8.0}}));
  EXPECT_EQ(overlapping.z_at_uv(5.0, 0.0), plane(5.0, 0.0) * 0.625 * 0.625);
  double last = overlapping.z_at_uv(0.0, 0.0);
  for (double u = 0.0; u <= 10.0; u += 0.01) {
    EXPECT_NEAR(overlapping.z_at_uv(u, 0.0), last, 0.02);
    last = overlapping.z_at_uv(u, 0.0);
  }
  Crg high = flat_road({{"BORDER_SMOOTH_UBEG", 4.0}});
  set_value(high.road, "REFERENCE_LINE_START_Z", 100.0);
  EXPECT_EQ(Surface(high).z_at_uv(1.0, 0.0), 100.0 + 0.25 * plane(1.0, 0.0));
}

TEST(Height, GradientFollowsBordersAndZones) {
  for (const double mode : {2.0, 3.0, 4.0}) {
    Crg crg =
        flat_road({{"BORDER_MODE_U", mode}, {"BORDER_MODE_V", mode}, {"BORDER_SMOOTH_UBEG", 3.0}});
    crg.banking.assign(11, 0.0625);
    const Surface surface(crg);
    for (const double u : {-3.4, 1.3, 5.6, 11.7, 23.3}) {
      for (const double v : {-3.3, -1.2, 0.3, 2.8}) {
        const double h = 1e-5;
        const Sample sample = surface.at_uv(u, v);
        EXPECT_NEAR(sample.dzdx,
                    (surface.z_at_uv(u + h, v) - surface.z_at_uv(u - h, v)) / (2.0 * h), 1e-8)
            << mode << " " << u << " " << v;
        EXPECT_NEAR(sample.dzdy,
                    (surface.z_at_uv(u, v + h) - surface.z_at_uv(u, v - h)) / (2.0 * h), 1e-8)
            << mode << " " << u << " " << v;
      }
    }
  }
}

TEST(Height, NanBesideTheRoadDoesNotReachOntoItsEdge) {
  Crg crg = flat_road({});
  for (std::size_t i = 0; i < 11; ++i) crg.grid.at(i, 4) = NAN;
  const Surface surface(crg);
  EXPECT_EQ(surface.z_at_uv(4.5, 1.0), plane(4.5, 1.0));
  EXPECT_TRUE(std::isnan(surface.z_at_uv(4.5, 1.001)));
  EXPECT_TRUE(std::isnan(surface.z_at_uv(4.5, 5.0)));
}

TEST(Height, UnevenColumnsInterpolateBetweenTheirOwnNeighbours) {
  Crg crg = flat_road({});
  crg.grid.v_m = {-2.0, -1.9, 0.7, 1.0, 2.0};
  for (std::size_t i = 0; i < 11; ++i) {
    for (std::size_t j = 0; j < 5; ++j)
      crg.grid.at(i, j) = static_cast<float>(plane(static_cast<double>(i), crg.grid.v_m[j]));
  }
  const Surface surface(crg);
  for (double v = -2.0; v <= 2.0; v += 0.037)
    ASSERT_NEAR(surface.z_at_uv(3.3, v), plane(3.3, v), 1e-6);  // float nodes
}

TEST(Height, FrictionComesFromTheMapOrTheConstant) {
  Crg map = flat_road({});
  for (std::size_t i = 0; i < 11; ++i) {
    for (std::size_t j = 0; j < 5; ++j) map.grid.at(i, j) = j < 2 ? 0.5F : 0.75F;
  }
  map.grid.at(5, 4) = NAN;
  Cursor cursor;
  EXPECT_EQ(Surface(flat_road({})).at_xy(3.0, 0.0, cursor).friction, 1.0);
  const Surface surface(flat_road({}), {.friction = 0.9, .friction_map = map});
  EXPECT_EQ(surface.at_xy(3.0, -1.5, cursor).friction, 0.5);
  EXPECT_EQ(surface.at_xy(3.0, 1.5, cursor).friction, 0.75);
  EXPECT_EQ(surface.at_xy(3.0, -0.5, cursor).friction, 0.625);
  EXPECT_EQ(surface.at_xy(5.2, 1.8, cursor).friction, 0.9) << "a hole in the map";
  EXPECT_EQ(surface.at_xy(3.0, 3.0, cursor).friction, 0.75) << "beyond the edge";
  map.grid.z_m.resize(50);
  EXPECT_THROW(Surface(flat_road({}), {.friction_map = map}), Error);
}

// A smoothing zone, however short, sends every query the long way round.
TEST(Height, TheShortWayOnTheGridGivesTheSameBits) {
  for (const bool closed : {false, true}) {
    ReferenceLine line = test::circuit(601, 20.0, 0.1, 3);
    for (std::size_t i = 0; i < line.size(); ++i) {
      line.z_m.push_back(5.0 + 0.01 * static_cast<double>(i % 300));
      line.banking.push_back(0.0003 * static_cast<double>(i % 150));
    }
    Crg crg = make_crg(line, test::grid_of(line, -3.0, 3.3, 22, [](double u, double v) {
                         return 0.1 * std::sin(3.0 * u) + 0.07 * std::cos(5.0 * v);
                       }));
    crg.grid.at(100, 7) = NAN;
    set_value(crg.options, "REFLINE_CONTINUATION", closed ? 1.0 : 0.0);
    const Surface direct(crg);
    set_value(crg.options, "BORDER_SMOOTH_UBEG", 1e-12);
    const Surface around(crg);
    const double end = line.u_begin_m + 600.0 * line.u_step_m;
    std::size_t holes = 0;
    for (int k = 0; k < 20000; ++k) {
      const double u = 1e-3 + (end + 1.0) * std::fmod(0.6180339887 * k, 1.0);
      const double v = -3.2 + 6.8 * std::fmod(0.7548776662 * k, 1.0);
      const double z = direct.z_at_uv(u, v), want = around.z_at_uv(u, v);
      if (std::isnan(want)) {
        ++holes;
        ASSERT_TRUE(std::isnan(z)) << u << " " << v;
      } else {
        ASSERT_EQ(z, want) << u << " " << v;
      }
    }
    EXPECT_GT(holes, 0U);
    for (const double u : {end, line.u_begin_m + 10.0 * line.u_step_m})
      for (const double v : {-3.0, 3.3, 0.0}) EXPECT_EQ(direct.z_at_uv(u, v), around.z_at_uv(u, v));
  }
}

TEST(Height, AnyNumberIsAPlace) {
  const Surface keep(flat_road({}));
  for (const double far : {1e12, 1e19, 1e299}) {
    EXPECT_EQ(keep.z_at_uv(5.0, far), plane(5.0, 2.0));
    EXPECT_EQ(keep.z_at_uv(5.0, -far), plane(5.0, -2.0));
    EXPECT_EQ(keep.z_at_uv(far, -far), plane(10.0, -2.0));
  }
}

}  // namespace height_test
}  // namespace crg
