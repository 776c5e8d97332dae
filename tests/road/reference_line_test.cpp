#include "road/reference_line.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mesh/error.h"

namespace reference_line_test {

road::Centreline circle_stations(double radius_m, int stations, bool closed, double share = 1.0) {
  road::Centreline line;
  line.closed = closed;
  for (int i = 0; i < stations; ++i) {
    const double angle = share * 2 * M_PI * i / (closed ? stations : stations - 1);
    line.points_m.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), 0.0);
    line.half_width_m.push_back(5.0);
  }
  return line;
}

TEST(ReferenceLine, HasEqualStepsAndHeadingsThatIntegrateToItsNodes) {
  road::ReferenceLineReport report;
  const auto line = fit_reference_line(circle_stations(50.0, 60, true), {}, &report);
  double x = line.x_m[0], y = line.y_m[0];
  for (std::size_t i = 1; i < line.size(); ++i) {
    x += line.u_step_m * std::cos(line.heading_rad[i]);
    y += line.u_step_m * std::sin(line.heading_rad[i]);
    ASSERT_NEAR(x, line.x_m[i], 1e-8);
    ASSERT_NEAR(y, line.y_m[i], 1e-8);
    ASSERT_LT(std::abs(line.heading_rad[i] - line.heading_rad[i - 1]), 0.01)
        << "headings are unwrapped";
  }
}

TEST(ReferenceLine, ClosesWithAGapOfOneMillimetreAheadOfTheStart) {
  road::ReferenceLineReport report;
  const auto line = fit_reference_line(circle_stations(50.0, 60, true), {}, &report);
  EXPECT_TRUE(line.closed);
  const double gap_x = line.x_m[0] - line.x_m.back(), gap_y = line.y_m[0] - line.y_m.back();
  const double ahead =
      gap_x * std::cos(line.heading_rad[0]) + gap_y * std::sin(line.heading_rad[0]);
  EXPECT_NEAR(ahead, 1e-3, 1e-5) << "the standard wants a strictly positive gap";
  EXPECT_NEAR(report.length_m, 2 * M_PI * 50.0, 0.01);
  EXPECT_LT(report.heading_step_at_seam_rad, 5e-4);
  EXPECT_NEAR(line.u_step_m, 0.1, 1e-4);
  EXPECT_NEAR(report.min_radius_m, 50.0, 0.1);
}

TEST(ReferenceLine, StaysOnTheStations) {
  road::ReferenceLineReport report;
  const auto stations = circle_stations(20.0, 40, true);
  const auto line = fit_reference_line(stations, {}, &report);
  // 3 m between stations on a bend of 20 m radius: the smoothing moves the line by less than 5 mm.
  EXPECT_LT(report.fit_residual_max_m, 5e-3);
  for (std::size_t i = 0; i < line.size(); ++i)
    EXPECT_NEAR(std::hypot(line.x_m[i], line.y_m[i]), 20.0, 6e-3);
}

TEST(ReferenceLine, KeepsItsShapeAtUtmCoordinates) {
  const auto near = circle_stations(50.0, 60, true);
  auto far = near;
  const Eigen::Vector3d shift(691'000.0, 5'334'000.0, 500.0);
  for (auto& p : far.points_m) p += shift;
  const auto a = road::fit_reference_line(near), b = road::fit_reference_line(far);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_NEAR(a.x_m[i] + shift.x(), b.x_m[i], 1e-6);
    EXPECT_NEAR(a.y_m[i] + shift.y(), b.y_m[i], 1e-6);
  }
}

TEST(ReferenceLine, RunsFromEndToEndOfAnOpenRoad) {
  road::ReferenceLineReport report;
  const auto line = fit_reference_line(circle_stations(100.0, 40, false, 0.25), {}, &report);
  EXPECT_FALSE(line.closed);
  EXPECT_EQ(line.u_step_m, 0.1);
  EXPECT_NEAR(report.length_m, 0.25 * 2 * M_PI * 100.0, 0.11);
  EXPECT_NEAR(line.x_m[0], 100.0, 2e-3);
  EXPECT_NEAR(line.y_m[0], 0.0, 2e-3);
}

TEST(ReferenceLine, AveragesNoiseOfTheMeshAway) {
  auto stations = circle_stations(100.0, 314, true);  // 2 m apart
  for (std::size_t i = 0; i < stations.points_m.size(); ++i) {
    stations.points_m[i].head<2>() *= 1.0 + (i % 2 == 0 ? 1e-5 : -1e-5);  // 1 mm in and out
  }
  const auto line = road::fit_reference_line(stations);
  for (std::size_t i = 2; i < line.size(); ++i) {
    const double curvature = (line.heading_rad[i] - line.heading_rad[i - 1]) / line.u_step_m;
    EXPECT_NEAR(curvature, 0.01, 5e-4) << i;
  }
}

TEST(ReferenceLine, RefusesWhatIsNoLine) {
  EXPECT_THROW(road::fit_reference_line(circle_stations(50.0, 3, true)), road::Error);
  EXPECT_THROW(road::fit_reference_line(circle_stations(0.05, 10, true)), road::Error);
  EXPECT_THROW(road::fit_reference_line(circle_stations(50.0, 60, true), {.u_step_m = 0.0}),
               road::Error);
}

}  // namespace reference_line_test
