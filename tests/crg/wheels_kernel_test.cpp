// Several points, each with its own cursor, in one call: the same bits as one by one.
#include "wheels_kernel.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <random>
#include <vector>

#include "crg/surface.h"
#include "locators.h"
#include "roads.h"

namespace crg {
namespace wheels_kernel_test {

std::uint64_t bits(double value) {
  return std::isnan(value) ? 0 : std::bit_cast<std::uint64_t>(value);
}

const Crg& circuit_with_holes() {
  static const Crg road = [] {
    ReferenceLine line = test::circuit(2001, 30.0, 0.1, 3);
    for (std::size_t i = 0; i < line.size(); ++i)
      line.banking.push_back(0.03 * std::sin(0.01 * static_cast<double>(i)));
    Crg crg = make_crg(line, test::grid_of(line, -4.0, 4.0, 41, [](double u, double v) {
                         return 0.1 * std::sin(u) + 0.02 * v * v;
                       }));
    for (std::size_t i = 300; i < 340; ++i) crg.grid.at(i, 12) = NAN;
    return crg;
  }();
  return road;
}

// The wheels of a car that goes along by `step_m` a set; NaN: anywhere.
std::array<Point2, 4> wheels_of(const Surface& surface, int k, double step_m,
                                std::mt19937& random) {
  const double length = surface.grid().u_step_m * 2000.0;
  std::uniform_real_distribution<double> u_of(0.0, length), v_of(-4.4, 4.4);
  std::array<Point2, 4> points;
  for (std::size_t w = 0; w < 4; ++w) {
    const double u =
        std::fmod(length + 2.0 + std::fmod(step_m * k, length) + (w < 2 ? 1.4 : -1.4), length);
    const double v = 3.5 * std::sin(0.01 * k) + (w % 2 == 0 ? 0.8 : -0.8);
    points[w] =
        std::isnan(step_m) ? surface.xy_of_uv(u_of(random), v_of(random)) : surface.xy_of_uv(u, v);
  }
  return points;
}

// Forwards, backwards, standing and at random, over holes, the seam and the borders.
TEST(Wheels, AnswerAsOneByOne) {
  for (const Interpolation interpolation : {Interpolation::Bilinear, Interpolation::Smooth}) {
    const Surface surface(circuit_with_holes(), {.interpolation = interpolation});
    std::mt19937 random(3);
    for (const double step_m : {0.06, -0.06, 0.0, Sample::kNaN}) {
      std::array<Cursor, 4> together, alone;
      for (int k = 0; k < 3000; ++k) {
        const std::array<Point2, 4> points = wheels_of(surface, k, step_m, random);
        std::array<double, 4> z{};
        surface.z_at_xy(points, together, z);
        for (std::size_t w = 0; w < 4; ++w) {
          const double expected = surface.z_at_xy(points[w].x_m, points[w].y_m, alone[w]);
          ASSERT_EQ(bits(z[w]), bits(expected))
              << "step " << step_m << ", set " << k << ", wheel " << w;
          ASSERT_EQ(bits(expected),
                    bits(surface.at_xy(points[w].x_m, points[w].y_m, alone[w]).z_m));
        }
      }
    }
  }
}

std::array<std::uint64_t, 8> bits(const Ground& g) {
  return {g.valid,     g.inside,     bits(g.u_m),  bits(g.v_m),
          bits(g.z_m), bits(g.dzdx), bits(g.dzdy), bits(g.friction)};
}

TEST(Wheels, HaveTheGroundOfTheWholeSample) {
  for (const Interpolation interpolation : {Interpolation::Bilinear, Interpolation::Smooth}) {
    const Surface surface(circuit_with_holes(), {.interpolation = interpolation, .friction = 0.7});
    std::mt19937 random(3);
    for (const double step_m : {0.06, -0.06, 0.0, Sample::kNaN}) {
      std::array<Cursor, 4> whole, alone, together;
      int at_once = 0;
      for (int k = 0; k < 3000; ++k) {
        const std::array<Point2, 4> points = wheels_of(surface, k, step_m, random);
        FourGrounds four;
        const bool known = surface.ground_of_four(
            points, {&together[0], &together[1], &together[2], &together[3]}, four);
        if (known) ++at_once;
        for (std::size_t w = 0; w < 4; ++w) {
          const auto [x, y] = points[w];
          const auto wanted = bits(Ground(surface.at_xy(x, y, whole[w])));
          ASSERT_EQ(bits(surface.ground_at_xy(x, y, alone[w])), wanted) << step_m << " " << k;
          Ground one;
          one.valid = one.inside = true;
          one.u_m = four.u_m[w], one.v_m = four.v_m[w], one.z_m = four.z_m[w];
          one.dzdx = four.dzdx[w], one.dzdy = four.dzdy[w], one.friction = four.friction;
          if (!known) one = surface.ground_at_xy(x, y, together[w]);
          ASSERT_EQ(bits(one), wanted) << step_m << " " << k;
        }
      }
      if (four_wheels_available() && interpolation == Interpolation::Bilinear &&
          !std::isnan(step_m)) {
        EXPECT_GT(at_once, 2000) << step_m;
      }
    }
  }
}

// On a road like this the kernel itself answers nearly always; the test above would not notice if
// it never did.
TEST(Wheels, FourAtOnceIsTheCommonCase) {
  if (!four_wheels_available()) GTEST_SKIP() << "this processor lacks AVX2";
  const Crg crg =
      make_crg(test::line_along(2000, 0.1, [](double u) { return 0.01 * std::sin(0.1 * u); }),
               test::grid_of(test::line_along(2000, 0.1, [](double) { return 0.0; }), -4.0, 4.0, 41,
                             [](double u, double v) { return 0.1 * std::sin(u) * v; }));
  const ReferenceLine line = integrate_reference_line(crg);
  const HeightField heights(crg.grid, line, options_of(crg));
  const Locator locator = test::locator_of(line, -4.0, 4.0);
  std::array<Cursor, 4> cursors;
  int answered = 0;
  for (int k = 0; k < 3000; ++k) {
    std::array<Point2, 4> points;
    std::array<double, 4> z{};
    for (std::size_t w = 0; w < 4; ++w)
      points[w] = position(line, 2.0 + 0.0617 * k + (w < 2 ? 1.4 : -1.4), w % 2 == 0 ? 0.8 : -0.8);
    if (z_of_four_wheels(locator, heights, points.data(), cursors.data(), z.data())) {
      ++answered;
    } else {
      for (std::size_t w = 0; w < 4; ++w) locator.locate(points[w].x_m, points[w].y_m, cursors[w]);
    }
  }
  EXPECT_GT(answered, 2700);
}

TEST(Wheels, AnyNumberOfPoints) {
  const Surface surface(circuit_with_holes());
  std::vector<Point2> points;
  for (int k = 0; k < 7; ++k) points.push_back(surface.xy_of_uv(10.0 + 0.3 * k, 0.5));
  std::vector<Cursor> cursors(9);
  std::vector<double> z(7, -1.0);
  surface.z_at_xy(points, cursors, std::span(z).first(6));
  for (std::size_t k = 0; k < 6; ++k) {
    Cursor fresh;
    EXPECT_EQ(z[k], surface.z_at_xy(points[k].x_m, points[k].y_m, fresh));
  }
  EXPECT_EQ(z[6], -1.0);
}

}  // namespace wheels_kernel_test
}  // namespace crg
