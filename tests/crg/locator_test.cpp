// uv_of_xy against a search of every cell, on lines made to confuse it.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "crg/surface.h"
#include "roads.h"

namespace crg {
namespace locator_test {

struct Truth {
  double u_m = NAN, v_m = NAN, outside_m = INFINITY, distance_m = INFINITY;
};

// By definition: of all cells whose corners at +-|v| enclose the point, the one where v is least
// outside the grid, then the smallest |v|. Written from node positions alone.
Truth search_all(const ReferenceLine& line, double v_right, double v_left, Point2 p) {
  Truth best;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double dx = line.x_m[i + 1] - line.x_m[i], dy = line.y_m[i + 1] - line.y_m[i];
    const double length = std::hypot(dx, dy);
    const double v = ((p.y_m - line.y_m[i]) * dx - (p.x_m - line.x_m[i]) * dy) / length;
    const Point2 a = node_position(line, i, v), b = node_position(line, i + 1, v);
    const double width = ((b.x_m - a.x_m) * dx + (b.y_m - a.y_m) * dy) / length;
    const double past = ((p.x_m - a.x_m) * dx + (p.y_m - a.y_m) * dy) / length;
    if (!(past >= 0.0 && past < width)) continue;
    const double outside = std::max({0.0, v - v_left, v_right - v});
    if (outside < best.outside_m || (outside == best.outside_m && std::abs(v) < best.distance_m)) {
      best = {line.u_begin_m + (static_cast<double>(i) + past / width) * line.u_step_m, v, outside,
              std::abs(v)};
    }
  }
  return best;
}

// Points on the grid of the line, and some beside it; compares with all cells and with cursors
// that come from anywhere.
void expect_true_places(const ReferenceLine& line, double v_right, double v_left, int points) {
  const Surface surface(
      make_crg(line, test::grid_of(line, v_right, v_left, 3, [](double, double) { return 0.0; })));
  const ReferenceLine& used = surface.reference_line();
  std::mt19937 random(11);
  const double u_end = used.u_begin_m + used.u_step_m * static_cast<double>(used.size() - 1);
  std::uniform_real_distribution<double> u_of(used.u_begin_m, u_end);
  std::uniform_real_distribution<double> v_of(1.3 * v_right, 1.3 * v_left);
  std::uniform_int_distribution<std::size_t> any_segment(0, used.size() + 5);
  Cursor follows;
  for (int k = 0; k < points; ++k) {
    const Point2 p = position(used, u_of(random), v_of(random));
    const Truth truth = search_all(used, v_right, v_left, p);
    if (!std::isfinite(truth.u_m)) continue;
    const UV followed = surface.uv_of_xy(p.x_m, p.y_m, follows);
    for (int history = 0; history < 3; ++history) {
      Cursor cursor{static_cast<double>(any_segment(random)) + 0.5, 0.0};
      const UV uv = surface.uv_of_xy(p.x_m, p.y_m, cursor);
      ASSERT_EQ(uv.u_m, followed.u_m) << "history changes the answer at " << p.x_m << ", " << p.y_m;
      ASSERT_EQ(uv.v_m, followed.v_m);
    }
    // Beyond an open end the extension may be nearer than any cell.
    if (followed.u_m < used.u_begin_m || followed.u_m > u_end) continue;
    ASSERT_NEAR(followed.v_m, truth.v_m, 1e-9)
        << "at " << p.x_m << ", " << p.y_m << " u " << followed.u_m << " want " << truth.u_m;
    ASSERT_NEAR(followed.u_m, truth.u_m, 1e-8);
  }
}

TEST(Locator, StraightAndGentleCurves) {
  expect_true_places(test::line_along(400, 0.5, [](double) { return 0.0; }), -4.0, 4.0, 2000);
  expect_true_places(
      test::line_along(2000, 0.1, [](double u) { return 0.02 * std::sin(0.05 * u); }), -6.0, 6.0,
      2000);
}

TEST(Locator, Hairpin) {
  // Two legs 16 m apart, joined by half a circle of 8 m radius that the road nearly fills.
  const auto curvature = [](double u) {
    return u > 60.0 && u < 60.0 + 8.0 * std::numbers::pi ? 1.0 / 8.0 : 0.0;
  };
  expect_true_places(test::line_along(1500, 0.1, curvature), -7.5, 7.5, 4000);
}

TEST(Locator, LegsSideBySideWithUnequalSides) {
  // 20 m apart and 12 m wide on the inner side: the nearer line is not always the right leg.
  const auto curvature = [](double u) {
    return u > 100.0 && u < 100.0 + 10.0 * std::numbers::pi ? 0.1 : 0.0;
  };
  expect_true_places(test::line_along(2300, 0.1, curvature), -3.0, 9.5, 4000);
}

TEST(Locator, Circuit) { expect_true_places(test::circuit(3001, 60.0, 0.25, 4), -6.0, 6.0, 4000); }

TEST(Locator, FigureOfEightCrossesItself) {
  const auto curvature = [](double u) { return std::fmod(u, 120.0) < 60.0 ? 0.1 : -0.1; };
  expect_true_places(test::line_along(1300, 0.1, curvature), -3.0, 3.0, 3000);
}

TEST(Locator, SpiralTighterThanTheRoadIsWide) {
  expect_true_places(test::line_along(1200, 0.1, [](double u) { return 0.02 + 0.003 * u; }), -5.0,
                     5.0, 3000);
}

TEST(Locator, KinksAndNoise) {
  std::mt19937 random(3);
  std::vector<double> kink(700);
  for (double& value : kink) value = std::uniform_real_distribution<double>(-0.6, 0.6)(random);
  expect_true_places(
      test::line_along(600, 0.2, [&](double u) { return kink[static_cast<std::size_t>(u / 0.2)]; }),
      -2.0, 2.0, 3000);
}

TEST(Locator, CoarseRows) {
  expect_true_places(test::line_along(24, 10.0, [](double) { return 0.025; }), -1.5, 1.5, 2000);
}

TEST(Locator, EveryFinitePointHasAPlaceAndOthersHaveNone) {
  const ReferenceLine line = test::circuit(1001, 50.0, 0.2, 3);
  const Surface surface(
      make_crg(line, test::grid_of(line, -4.0, 4.0, 3, [](double, double) { return 1.0; })));
  Cursor cursor;
  std::mt19937 random(5);
  for (int k = 0; k < 2000; ++k) {
    std::uniform_real_distribution<double> exponent(-3.0, 9.0);
    const double x = std::pow(10.0, exponent(random)) * (k % 2 == 0 ? 1.0 : -1.0);
    const double y = std::pow(10.0, exponent(random)) * (k % 3 == 0 ? 1.0 : -1.0);
    const UV uv = surface.uv_of_xy(x, y, cursor);
    ASSERT_TRUE(std::isfinite(uv.u_m) && std::isfinite(uv.v_m)) << x << ", " << y;
  }
  EXPECT_TRUE(std::isnan(surface.uv_of_xy(NAN, 0.0, cursor).u_m));
  EXPECT_TRUE(std::isnan(surface.uv_of_xy(0.0, INFINITY, cursor).v_m));
}

}  // namespace locator_test
}  // namespace crg
