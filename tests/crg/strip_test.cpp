#include "crg/strip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include "crg/surface.h"
#include "roads.h"
#include "support/figure.h"

namespace crg {
namespace strip_test {

Point2 towards(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

Surface bumpy_circuit(const std::vector<double>& more_columns_v_m = {}) {
  // About 0.1 m between rows on a circuit with radii from 25 m.
  ReferenceLine line = test::circuit(4200, 60.0, 0.15, 3);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double t =
        2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(line.size() - 1);
    line.z_m.push_back(300.0 + 3.0 * std::sin(t));
    line.banking.push_back(0.05 * std::cos(2.0 * t));
  }
  Grid grid;
  grid.u_begin_m = line.u_begin_m;
  grid.u_step_m = line.u_step_m;
  grid.v_m = more_columns_v_m;
  for (int j = -50; j <= 50; ++j) grid.v_m.push_back(0.1 * j);
  std::sort(grid.v_m.begin(), grid.v_m.end());
  for (std::size_t i = 0; i < line.size(); ++i)
    for (const double v : grid.v_m)
      grid.z_m.push_back(
          static_cast<float>(0.02 * std::sin(3.0 * grid.u_of(i)) * std::cos(4.0 * v)));
  return Surface(make_crg(line, grid));
}

const Surface& even_circuit() {
  static const Surface surface = bumpy_circuit();
  return surface;
}

double worst_difference(const Surface& surface, const Strip& strip, const std::vector<float>& dz,
                        double base) {
  double worst = 0.0;
  Cursor cursor;
  for (std::size_t i = 0; i < strip.along; ++i) {
    for (std::size_t j = 0; j < strip.across; ++j) {
      const double a =
          (static_cast<double>(i) - 0.5 * static_cast<double>(strip.along - 1)) * strip.step_m;
      const double b =
          (static_cast<double>(j) - 0.5 * static_cast<double>(strip.across - 1)) * strip.step_m;
      const double c = strip.ahead.x_m, s = strip.ahead.y_m;
      const Sample sample =
          surface.at_xy(strip.x_m + a * c - b * s, strip.y_m + a * s + b * c, cursor);
      const double z = base + dz[i * strip.across + j];
      EXPECT_EQ(sample.valid, !std::isnan(z));
      if (sample.valid) worst = std::max(worst, std::abs(z - sample.z_m));
    }
  }
  return worst;
}

/// Of 400 strips on a road.
double worst_difference_on(const Surface& surface) {
  const ReferenceLine& line = surface.reference_line();
  std::mt19937 random(6);
  std::uniform_real_distribution<double> u_of(0.0,
                                              line.u_step_m * static_cast<double>(line.size() - 1)),
      v_of(-5.3, 5.3), turn(-4.0, 4.0);
  std::uniform_int_distribution<std::size_t> many(1, 60);
  Cursor cursor;
  double worst = 0.0;
  for (int k = 0; k < 400; ++k) {
    const Point2 p = surface.xy_of_uv(u_of(random), v_of(random));
    Strip strip{.x_m = p.x_m,
                .y_m = p.y_m,
                .ahead = towards(turn(random)),
                .along = many(random),
                .across = many(random)};
    std::vector<float> dz(strip.along * strip.across, -99.0F);
    const double base = surface.strip(strip, dz, cursor);
    worst = std::max(worst, worst_difference(surface, strip, dz, base));
  }
  return worst;
}

TEST(Strip, AgreesWithSingleQueriesAnywhereAndInAnyDirection) {
  const double worst = worst_difference_on(even_circuit());
  // Measured 6.5e-6 on radii from 25 m: the segments of the line are straight, the quadratic is
  // not.
  EXPECT_LT(worst, 1e-5);
  support::figure("worst_m", worst);
}

TEST(Strip, AgreesWithSingleQueriesWhereColumnsAreNotEven) {
  // As roads have them whose edges are columns of their own, and one between two others.
  EXPECT_LT(worst_difference_on(bumpy_circuit({-4.997, -4.994, -4.9875, 0.537, 4.96, 4.998})),
            1e-5);
}

TEST(Strip, RowsThatAreNotAskedForAreBoundedNotFilled) {
  const Surface surface = bumpy_circuit({-4.997, -4.994});
  std::mt19937 random(8);
  std::uniform_real_distribution<double> u_of(0.0, 400.0), v_of(-5.2, 5.2), turn(-4.0, 4.0);
  Cursor cursor;
  int left_out = 0;
  for (int k = 0; k < 400; ++k) {
    const Point2 p = surface.xy_of_uv(u_of(random), v_of(random));
    const Strip strip{.x_m = p.x_m,
                      .y_m = p.y_m,
                      .ahead = towards(turn(random)),
                      .along = 27,
                      .across = 15,
                      .step_m = 0.02};
    std::vector<float> all(strip.along * strip.across), some(all.size(), -99.0F);
    surface.strip(strip, all, cursor);
    float before = 0.0F, after = 0.0F;
    const auto more = [&](double, float before_m, float after_m) {
      before = before_m, after = after_m;
      return StripRows{9, 18};
    };
    surface.strip(strip, {10, 16}, more, some, cursor);
    const bool known = std::isfinite(before);
    EXPECT_EQ(known, std::isfinite(after));
    left_out += known;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const std::size_t row = i / strip.across;
      if (!known || (row >= 9 && row < 18)) {
        ASSERT_EQ(std::bit_cast<std::uint32_t>(all[i]), std::bit_cast<std::uint32_t>(some[i]));
      } else {
        ASSERT_EQ(some[i], -99.0F);
      }
      // To the rounding of a sum.
      ASSERT_FALSE(row < 10 && all[i] > before + 1e-6F);
      ASSERT_FALSE(row >= 16 && all[i] > after + 1e-6F);
    }
  }
  EXPECT_GT(left_out, 300);
}

TEST(Strip, WideStripsAreSplit) {
  const Surface& surface = even_circuit();
  const Point2 p = surface.xy_of_uv(50.0, 1.0);
  const Strip strip{.x_m = p.x_m,
                    .y_m = p.y_m,
                    .ahead = towards(0.3),
                    .along = 150,
                    .across = 200,
                    .step_m = 0.02};
  std::vector<float> dz(strip.along * strip.across);
  Cursor cursor;
  const double base = surface.strip(strip, dz, cursor);
  EXPECT_LT(worst_difference(surface, strip, dz, base), 1e-5);
}

TEST(Strip, KernelsGiveTheSameBits) {
  const Surface& surface = even_circuit();
  Cursor cursor;
  for (const StripKernel kernel : {StripKernel::Avx2, StripKernel::Avx512}) {
    if (!available(kernel)) continue;
    for (double u = 0.0; u < 300.0; u += 7.3) {
      const Point2 p = surface.xy_of_uv(u, -2.0);
      for (const std::size_t across : {43u, 15u, 8u, 3u}) {
        Strip strip{.x_m = p.x_m, .y_m = p.y_m, .ahead = towards(u), .along = 10, .across = across};
        std::vector<float> a(10 * across), b(10 * across);
        strip.kernel = StripKernel::Scalar;
        surface.strip(strip, a, cursor);
        strip.kernel = kernel;
        surface.strip(strip, b, cursor);
        ASSERT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0) << u << across;
      }
    }
  }
}

TEST(Strip, FillsOnlyWhatThereIsRoomFor) {
  const Surface& surface = even_circuit();
  const Point2 p = surface.xy_of_uv(20.0, 0.0);
  std::vector<float> dz(45, -99.0F);
  Cursor cursor;
  surface.strip({.x_m = p.x_m, .y_m = p.y_m, .along = 10, .across = 10}, dz, cursor);
  EXPECT_NE(dz[39], -99.0F);
  EXPECT_EQ(dz[40], -99.0F);
  surface.strip({.x_m = NAN, .along = 2, .across = 2}, dz, cursor);
  EXPECT_TRUE(std::isnan(dz[3]));
}

}  // namespace strip_test
}  // namespace crg
