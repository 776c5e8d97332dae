#include "crg/surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "roads.h"
#include "support/figure.h"

namespace crg {
namespace surface_test {

Crg hilly_circuit() {
  ReferenceLine line = test::circuit(3001, 60.0, 0.2, 3);
  const double length = line.u_step_m * static_cast<double>(line.size() - 1);
  const auto wave = [&](double u, int times) {
    return std::sin(2.0 * std::numbers::pi * times * u / length);
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double u = line.u_step_m * static_cast<double>(i);
    line.z_m.push_back(250.0 + 6.0 * wave(u, 2));
    line.banking.push_back(0.06 * wave(u, 3));
  }
  return make_crg(line, test::grid_of(line, -6.0, 5.0, 23, [&](double u, double v) {
                    return 0.05 * wave(u, 80) * std::cos(2.0 * v) + 0.01 * v * v;
                  }));
}

TEST(Surface, RoundTripInsideTheRoad) {
  const Surface surface(hilly_circuit());
  const ReferenceLine& line = surface.reference_line();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u_of(0.0,
                                              line.u_step_m * static_cast<double>(line.size() - 1)),
      v_of(-6.0, 5.0);
  Cursor cursor;
  double worst_m = 0.0;
  for (int k = 0; k < 20000; ++k) {
    const double u = u_of(random), v = v_of(random);
    const Point2 p = surface.xy_of_uv(u, v);
    const UV uv = surface.uv_of_xy(p.x_m, p.y_m, cursor);
    ASSERT_NEAR(uv.u_m, u, 1e-9);
    ASSERT_NEAR(uv.v_m, v, 1e-9);
    worst_m = std::max({worst_m, std::abs(uv.u_m - u), std::abs(uv.v_m - v)});
  }
  support::figure("worst_m", worst_m);
}

TEST(Surface, OneCallAgreesWithTheSingleQueries) {
  const Surface surface(hilly_circuit());
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-80.0, 80.0);
  Cursor a, b;
  for (int k = 0; k < 5000; ++k) {
    const double x = place(random), y = place(random);
    const Sample sample = surface.at_xy(x, y, a);
    const UV uv = surface.uv_of_xy(x, y, b);
    ASSERT_EQ(sample.u_m, uv.u_m);
    ASSERT_EQ(sample.v_m, uv.v_m);
    ASSERT_NEAR(sample.z_m, surface.z_at_uv(uv.u_m, uv.v_m), 1e-11);  // rounding of u
    ASSERT_EQ(sample.z_m, surface.z_at_xy(x, y, b));
    ASSERT_EQ(sample.x_m, x);
    const Sample by_uv = surface.at_uv(uv.u_m, uv.v_m);
    ASSERT_NEAR(by_uv.z_m, sample.z_m, 1e-9);
    ASSERT_EQ(sample.inside, sample.v_m >= -6.0 && sample.v_m <= 5.0);
  }
}

TEST(Surface, GradientIsTheSlopeOfTheHeights) {
  const Surface surface(hilly_circuit());
  const ReferenceLine& line = surface.reference_line();
  std::mt19937 random(4);
  std::uniform_real_distribution<double> row_of(0.0, static_cast<double>(line.size() - 2)),
      column_of(0.0, 21.9);
  Cursor cursor;
  double slope = 0.0, normal = 0.0;  // worst
  for (int k = 0; k < 5000; ++k) {
    // Keep the points of the difference quotient within one cell: at its edges there are kinks.
    double row = row_of(random), column = column_of(random);
    row = std::floor(row) + 0.2 + 0.6 * (row - std::floor(row));
    column = std::floor(column) + 0.2 + 0.6 * (column - std::floor(column));
    const Point2 p = surface.xy_of_uv(row * line.u_step_m, -6.0 + 0.5 * column);
    const Sample sample = surface.at_xy(p.x_m, p.y_m, cursor);
    const double h = 1e-4;
    const auto z = [&](double x, double y) { return surface.at_xy(x, y, cursor).z_m; };
    const double dzdx = (z(p.x_m + h, p.y_m) - z(p.x_m - h, p.y_m)) / (2.0 * h);
    ASSERT_NEAR(sample.dzdx, dzdx, 1e-6);
    slope = std::max(slope, std::abs(sample.dzdx - dzdx));
    ASSERT_NEAR(sample.dzdy, (z(p.x_m, p.y_m + h) - z(p.x_m, p.y_m - h)) / (2.0 * h), 1e-6);
    const double length =
        std::sqrt(sample.normal_x * sample.normal_x + sample.normal_y * sample.normal_y +
                  sample.normal_z * sample.normal_z);
    ASSERT_NEAR(length, 1.0, 1e-12);
    normal = std::max(normal, std::abs(length - 1.0));
    ASSERT_NEAR(sample.normal_x + sample.dzdx * sample.normal_z, 0.0, 1e-12);
    ASSERT_GT(sample.normal_z, 0.0);
  }
  support::figure("slope", slope);
  support::figure("normal", normal);
}

TEST(Surface, ClosedTrackHasNoStepAtTheSeam) {
  const Surface surface(hilly_circuit());
  const ReferenceLine& line = surface.reference_line();
  ASSERT_TRUE(line.closed);
  const double end = line.u_step_m * static_cast<double>(line.size() - 1);
  Cursor cursor;
  for (const double v : {-5.9, -2.0, 0.0, 3.0, 4.9}) {
    double last = surface.z_at_uv(end - 0.05, v);
    for (double u = end - 0.05; u < end + 0.05; u += 0.001) {
      const Point2 p = surface.xy_of_uv(u, v);
      const Sample sample = surface.at_xy(p.x_m, p.y_m, cursor);
      ASSERT_TRUE(sample.valid);
      ASSERT_NEAR(sample.z_m, last, 1e-3) << "u " << u << " v " << v;
      last = sample.z_m;
    }
    ASSERT_NEAR(surface.z_at_uv(end + 1.0, v), surface.z_at_uv(1.0, v), 1e-3);
  }
}

// A circle of 50 m radius given by x and y channels alone. Heights and banking run on over the
// seam, in a file whose last row repeats the first and in one that stops a step short of it.
TEST(Surface, HeightRunsOnOverTheSeamOfATrackGivenByNodes) {
  constexpr double kRadius_m = 50.0;
  for (const bool repeats : {true, false}) {
    const std::size_t steps = 3000;
    Crg crg;
    crg.format = Format::KDBI;
    const double turn = 2.0 * std::numbers::pi / static_cast<double>(steps);
    crg.grid.u_step_m = 2.0 * kRadius_m * std::sin(0.5 * turn);  // the chord
    for (int j = 0; j <= 8; ++j) crg.grid.v_m.push_back(-4.0 + j);
    for (std::size_t i = 0; i < (repeats ? steps + 1 : steps); ++i) {
      const double t = turn * static_cast<double>(i);
      crg.x_m.push_back(300.0 + kRadius_m * std::cos(t));
      crg.y_m.push_back(-200.0 + kRadius_m * std::sin(t));
      crg.banking.push_back(0.05 + 0.02 * std::cos(t));
      for (int j = 0; j <= 8; ++j)
        crg.grid.z_m.push_back(static_cast<float>(0.5 * std::sin(t + 1.0)));
    }
    set_value(crg.road, "REFERENCE_LINE_INCREMENT", crg.grid.u_step_m);
    set_value(crg.road, "REFERENCE_LINE_START_U", 0.0);
    set_value(crg.road, "REFERENCE_LINE_END_U", crg.grid.u_of(crg.grid.rows() - 1));
    set_value(crg.options, "REFLINE_CONTINUATION", 1.0);
    crg.has_option_section = true;
    const Surface surface(read_bytes(to_bytes(crg, Format::KDBI), "nodes.crg"));
    ASSERT_TRUE(surface.closed());
    Cursor cursor;
    for (const double v : {-3.7, -0.3, 2.0, 3.9}) {
      for (double u = -0.5; u < 0.5; u += 0.007) {
        const double t = u / kRadius_m, r = kRadius_m - v;
        const Sample sample =
            surface.at_xy(300.0 + r * std::cos(t), -200.0 + r * std::sin(t), cursor);
        ASSERT_TRUE(sample.valid);
        // A chord lies up to step^2 / (8 R) = 2.7e-5 m beside its arc, 1.9e-6 m of height where the
        // banking is 0.07; linear interpolation adds step^2 / 8 times the second derivative, 3e-7
        // m. Over a gap of one step the file has no rows, so that each half of it keeps the height
        // of its end: at most half a step times the slope.
        const double tolerance =
            repeats ? 2.3e-6 : 0.5 * crg.grid.u_step_m * (0.5 + 0.02 * std::abs(v)) / kRadius_m;
        ASSERT_NEAR(sample.z_m, 0.5 * std::sin(t + 1.0) + (0.05 + 0.02 * std::cos(t)) * v,
                    tolerance)
            << "u " << u << " v " << v;
        ASSERT_NEAR(sample.v_m, v, 1e-4);
      }
    }
  }
}

TEST(Surface, ArcHasTheHeadingAndCurvatureOfItsCircle) {
  const double radius = 40.0;
  const ReferenceLine line = test::line_along(1001, 0.1, [&](double) { return 1.0 / radius; });
  const Surface surface(
      make_crg(line, test::grid_of(line, -5.0, 5.0, 3, [](double, double) { return 0.0; })));
  for (double u = 1.0; u < 99.0; u += 0.37) {
    for (const double v : {-5.0, 0.0, 5.0}) {
      const Sample sample = surface.at_uv(u, v);
      // Chords of 0.5 m on a radius of 40 m: (0.5 / 40)^2 / 6 of relative error at most, by 2.
      ASSERT_NEAR(sample.curvature_1pm, 1.0 / (radius - v), 1e-4 / radius);
      ASSERT_NEAR(sample.heading_rad, u / radius,
                  0.1 / radius + 1e-6);  // of the segment that holds u
    }
  }
}

TEST(Surface, ExplicitEmptyModifierSectionAppliesNothingUnderAnyDefault) {
  const ReferenceLine line = test::line_along(
      50, 0.5, [](double) { return 0.01; }, 100.0, 200.0, 1.0);
  Crg crg = make_crg(line, test::grid_of(line, -2.0, 2.0, 5, [](double, double) { return 3.0; }));
  for (const ModifierUse use :
       {ModifierUse::AsInFile, ModifierUse::None, ModifierUse::ReferenceDefaults}) {
    const Surface surface(crg, {.modifiers = use});
    EXPECT_EQ(surface.reference_line().x_m[0], 100.0);
    EXPECT_EQ(surface.z_at_uv(3.0, 0.5), 3.0);
  }
  crg.has_modifier_section = false;
  EXPECT_EQ(Surface(crg).reference_line().x_m[0], 100.0);
  const Surface moved(crg, {.modifiers = ModifierUse::ReferenceDefaults});
  const Point2 corner = moved.xy_of_uv(0.0, -2.0);
  EXPECT_NEAR(corner.x_m, 0.0, 1e-12);
  EXPECT_NEAR(corner.y_m, 0.0, 1e-12);
  EXPECT_NEAR(moved.z_at_uv(0.0, -2.0), 0.0, 1e-12);
  EXPECT_NEAR(moved.at_uv(0.0, 0.0).heading_rad, 0.0, 1e-7);
}

TEST(Surface, ABatchAnswersAsSingleCallsDoWhereverThePointsLie) {
  const ReferenceLine line = test::circuit(1501, 30.0, 0.1, 3);
  Crg crg = make_crg(line, test::grid_of(line, -4.0, 4.0, 17, [](double u, double v) {
                       return 0.1 * std::sin(u) + 0.02 * v;
                     }));
  for (std::size_t i = 300; i < 330; ++i) crg.grid.at(i, 8) = NAN;
  for (const double smooth_m : {0.0, 5.0}) {
    set_value(crg.options, "BORDER_SMOOTH_UBEG", smooth_m);
    const Surface surface(crg);
    std::vector<Point2> points = {{NAN, 0.0}, {1e300, -1e300}, {1e5, 0.0}};
    for (int k = 0; k < 3000; ++k) {  // stretches of driving between jumps
      const double u = std::fmod((k % 100 < 50 ? 0.05 : 37.7) * k, 150.0);
      points.push_back(surface.xy_of_uv(u, -6.0 + 12.0 * std::fmod(0.618 * k, 1.0)));
      if (k % 97 == 0) points.push_back(points[static_cast<std::size_t>(k) % 3]);
    }
    std::vector<double> z_m(points.size());
    std::vector<Sample> samples(points.size());
    Cursor cursor, other;
    surface.z_at_xy(points, z_m, cursor);
    surface.at_xy(points, samples, other);
    std::vector<double> x_m, y_m, z_apart_m(points.size());
    for (const Point2& p : points) x_m.push_back(p.x_m), y_m.push_back(p.y_m);
    std::vector<Sample> samples_apart(points.size() - 1);  // the shortest counts
    cursor = other = {};
    surface.z_at_xy(x_m, y_m, z_apart_m, cursor);
    surface.at_xy(x_m, y_m, samples_apart, other);
    for (std::size_t k = 0; k < points.size(); ++k) {
      Cursor fresh;
      const Sample want = surface.at_xy(points[k].x_m, points[k].y_m, fresh);
      const auto same = [](double a, double b) {
        return a == b || (std::isnan(a) && std::isnan(b));
      };
      ASSERT_TRUE(same(z_m[k], want.z_m) && same(z_apart_m[k], want.z_m)) << k;
      ASSERT_TRUE(k == samples_apart.size() ||
                  (same(samples_apart[k].z_m, want.z_m) && same(samples_apart[k].u_m, want.u_m) &&
                   same(samples_apart[k].normal_x, want.normal_x)))
          << k;
      ASSERT_TRUE(same(samples[k].z_m, want.z_m) && same(samples[k].dzdx, want.dzdx) &&
                  same(samples[k].u_m, want.u_m) && same(samples[k].v_m, want.v_m))
          << k;
    }
  }
}

}  // namespace surface_test
}  // namespace crg
