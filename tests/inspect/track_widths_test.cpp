#include "inspect/track_widths.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <sstream>

#include "mesh/error.h"

namespace road {
namespace track_widths_test {

struct Bend {
  crg::ReferenceLine line;
  crg::Grid grid;
};

/// A left bend about (0, 100) of radius 100 m: road from 2 m right to 3 m left, NaN beyond.
Bend bend(int rows, double step_rad) {
  Bend b;
  b.line.u_step_m = b.grid.u_step_m = 100.0 * step_rad;
  for (int j = -8; j <= 8; ++j) b.grid.v_m.push_back(0.5 * j);
  for (int i = 0; i < rows; ++i) {
    b.line.x_m.push_back(100.0 * std::sin(step_rad * i));
    b.line.y_m.push_back(100.0 - 100.0 * std::cos(step_rad * i));
    b.line.heading_rad.push_back(step_rad * (i - 0.5));
    for (const double v_m : b.grid.v_m)
      b.grid.z_m.push_back(v_m < -2.0 || v_m > 3.0 ? std::nanf("") : 1.0F);
  }
  return b;
}

TEST(TrackWidths, AReaderOfTheCsvFindsTheEdgesWhereTheyAre) {
  const Bend b = bend(200, 0.005);
  std::istringstream csv(track_widths_csv(track_widths(b.line, b.grid)));
  std::string text;
  std::getline(csv, text);
  EXPECT_EQ(text, "# x_m,y_m,w_tr_right_m,w_tr_left_m");
  int rows = 0;
  for (; std::getline(csv, text); ++rows) {
    double x = 0, y = 0, right = 0, left = 0;
    ASSERT_EQ(std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf", &x, &y, &right, &left), 4) << text;
    EXPECT_NEAR(std::hypot(x, y - 100.0), 100.0, 2e-4);
    EXPECT_NEAR(right, 2.0, 2e-4);
    EXPECT_NEAR(left, 3.0, 2e-4);
  }
  EXPECT_EQ(rows, 200);
}

TEST(TrackWidths, AClosedLineDoesNotRepeatItsFirstPoint) {
  Bend b = bend(201, 2.0 * M_PI / 200.0);
  b.line.closed = true;
  EXPECT_EQ(track_widths(b.line, b.grid).size(), 200u);
}

TEST(TrackWidths, AHoleEndsTheRoadAndOneOnTheLineIsRefused) {
  Bend b = bend(20, 0.005);
  b.grid.at(7, 11) = std::nanf("");  // v = 1.5 m
  const auto widths = track_widths(b.line, b.grid);
  EXPECT_NEAR(widths[7].left_m, 1.0, 1e-4);
  EXPECT_NEAR(widths[8].left_m, 3.0, 1e-4);
  b.grid.at(7, 8) = std::nanf("");
  try {
    track_widths(b.line, b.grid);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("u = 3.500 m"));
  }
}

}  // namespace track_widths_test
}  // namespace road
