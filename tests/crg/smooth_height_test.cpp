#include <gtest/gtest.h>

#include <cmath>

#include "crg/surface.h"
#include "roads.h"

namespace crg {
namespace smooth_height_test {

double waves(double u, double v) { return 0.05 * std::sin(0.9 * u) * std::cos(1.7 * v); }

Crg road() {
  ReferenceLine line =
      test::line_along(200, 0.25, [](double u) { return 0.01 * std::sin(0.2 * u); });
  for (std::size_t i = 0; i < line.size(); ++i) {
    line.z_m.push_back(20.0 + std::sin(0.05 * static_cast<double>(i)));
    line.banking.push_back(0.04 * std::sin(0.03 * static_cast<double>(i)));
  }
  return make_crg(line, test::grid_of(line, -3.0, 3.0, 25, waves));
}

TEST(SmoothHeight, AgreesWithBilinearAtTheNodes) {
  const Crg crg = road();
  const Surface bilinear(crg), smooth(crg, {.interpolation = Interpolation::Smooth});
  for (std::size_t i = 0; i < crg.grid.rows(); ++i) {
    for (const double v : crg.grid.v_m)
      ASSERT_NEAR(smooth.z_at_uv(crg.grid.u_of(i), v), bilinear.z_at_uv(crg.grid.u_of(i), v),
                  1e-12);
  }
}

TEST(SmoothHeight, DerivativesHaveNoStepsWhereBilinearHas) {
  const Crg crg = road();
  const auto largest_step = [&](Interpolation interpolation, bool along_u) {
    const Surface surface(crg, {.interpolation = interpolation});
    double worst = 0.0, last = NAN;
    const double h = 1e-5;
    for (double s = 0.51; s < 2.3; s += 1e-3) {
      const double u = along_u ? 10.0 + s : 12.3, v = along_u ? 0.77 : s - 1.0;
      const double slope =
          along_u ? (surface.z_at_uv(u + h, v) - surface.z_at_uv(u - h, v)) / (2.0 * h)
                  : (surface.z_at_uv(u, v + h) - surface.z_at_uv(u, v - h)) / (2.0 * h);
      if (!std::isnan(last)) worst = std::max(worst, std::abs(slope - last));
      last = slope;
    }
    return worst;
  };
  for (const bool along_u : {true, false}) {
    // A millimetre of travel changes a smooth slope by at most 1e-3 times its curvature (0.15).
    EXPECT_LT(largest_step(Interpolation::Smooth, along_u), 4e-4);
    EXPECT_GT(largest_step(Interpolation::Bilinear, along_u), 3e-3);
  }
}

TEST(SmoothHeight, GradientIsItsDerivative) {
  const Surface surface(road(), {.interpolation = Interpolation::Smooth});
  Cursor cursor;
  for (double u = 1.0; u < 48.0; u += 0.713) {
    const Point2 p = surface.xy_of_uv(u, std::sin(u) * 2.5);
    const Sample sample = surface.at_xy(p.x_m, p.y_m, cursor);
    if (std::abs(std::fmod(u / 0.25, 1.0) - 0.5) > 0.45)
      continue;  // the map (x, y) -> (u, v) has kinks at the rows
    const double h = 1e-5;
    const auto z = [&](double x, double y) { return surface.z_at_xy(x, y, cursor); };
    EXPECT_NEAR(sample.dzdx, (z(p.x_m + h, p.y_m) - z(p.x_m - h, p.y_m)) / (2.0 * h), 1e-6);
    EXPECT_NEAR(sample.dzdy, (z(p.x_m, p.y_m + h) - z(p.x_m, p.y_m - h)) / (2.0 * h), 1e-6);
  }
}

TEST(SmoothHeight, IsNearerToASmoothRoad) {
  const Crg crg = road();
  const Surface bilinear(crg), smooth(crg, {.interpolation = Interpolation::Smooth});
  const ReferenceLine line = integrate_reference_line(crg);
  double worst_bilinear = 0.0, worst_smooth = 0.0;
  for (std::size_t i = 4; i < 190; i += 7) {
    for (double v = -2.4; v < 2.4; v += 0.07) {
      const double u = crg.grid.u_of(i), truth = line.z_m[i] + line.banking[i] * v + waves(u, v);
      worst_bilinear = std::max(worst_bilinear, std::abs(bilinear.z_at_uv(u, v) - truth));
      worst_smooth = std::max(worst_smooth, std::abs(smooth.z_at_uv(u, v) - truth));
    }
  }
  EXPECT_LT(worst_smooth, 0.3 * worst_bilinear);
}

TEST(SmoothHeight, HolesAndEdgesStayWhatTheyAre) {
  Crg crg = road();
  crg.grid.at(50, 10) = NAN;
  const Surface smooth(crg, {.interpolation = Interpolation::Smooth}), bilinear(crg);
  for (double u = 11.0; u < 14.0; u += 0.031) {
    for (double v = -3.2; v < 3.2; v += 0.043)
      ASSERT_EQ(std::isnan(smooth.z_at_uv(u, v)), std::isnan(bilinear.z_at_uv(u, v)))
          << u << " " << v;
  }
}

}  // namespace smooth_height_test
}  // namespace crg
