#include "report/relief.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace report {
namespace relief_test {

/// A circle of radius 100 m, 12 m of road with 1 m kerbs and 3 m of run-off on both sides.
struct Ring {
  std::vector<double> x, y, v;
  std::vector<float> z;
  std::vector<std::uint8_t> kind;
  double step;

  explicit Ring(double step_m = 0.5) : step(step_m) {
    const auto rows = static_cast<std::size_t>(2.0 * std::numbers::pi * 100.0 / step_m);
    for (double at = -10.0; at <= 10.0 + 1e-9; at += step_m) v.push_back(at);
    for (std::size_t i = 0; i < rows; ++i) {
      const double a = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(rows);
      x.push_back(100.0 * std::cos(a));
      y.push_back(100.0 * std::sin(a));
      for (const double at : v) {
        z.push_back(static_cast<float>(3.0 * std::sin(a) + 0.05 * at));
        kind.push_back(std::abs(at) > 7.0 ? 2 : std::abs(at) > 6.0 ? 1 : 0);
      }
    }
  }
  ReliefInput input() const {
    ReliefInput in;
    in.title = "ring";
    in.u_step_m = step;
    in.x_m = x;
    in.y_m = y;
    in.v_m = v;
    in.z_m = z;
    in.kind = kind;
    in.closed = true;
    return in;
  }
};

std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

TEST(Relief, IsAPngOfTheWantedSize) {
  const Ring ring;
  const std::string png = relief_png(ring.input());
  ASSERT_GT(png.size(), 10000u);
  EXPECT_EQ(png.substr(1, 3), "PNG");
  EXPECT_LE(big_endian(png, 16), 2000u);
  EXPECT_GE(big_endian(png, 16), 1500u);
  EXPECT_EQ(big_endian(png, 20), 2000u);
}

TEST(Relief, AnyNumberOfThreadsDrawsTheSame) {
  const Ring ring;
  ReliefOptions one, three;
  one.threads = 1;
  three.threads = 3;
  EXPECT_EQ(relief_png(ring.input(), one), relief_png(ring.input(), three));
}

TEST(Relief, SurvivesHolesAndOddShapes) {
  Ring ring;
  const std::size_t columns = ring.v.size();
  for (std::size_t i = 100; i < 300; ++i)
    for (std::size_t j = 0; j < columns; ++j)
      if (i < 200 || j % 3 == 0) ring.z[i * columns + j] = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t j = 0; j < columns; ++j) ring.z[j] = std::numeric_limits<float>::quiet_NaN();
  ReliefInput in = ring.input();
  in.title = std::string(500, 'x') + "\n\t";
  EXPECT_FALSE(relief_png(in).empty());
  in.kind = {};
  in.closed = false;
  EXPECT_FALSE(relief_png(in).empty());
}

TEST(Relief, LargeCoordinatesAndLongNarrowRoads) {
  Ring ring;
  for (double& x : ring.x) x += 500000.0;
  for (double& y : ring.y) y += 5500000.0;
  EXPECT_FALSE(relief_png(ring.input()).empty());
  for (std::size_t i = 0; i < ring.x.size(); ++i) {
    ring.x[i] = 0.0;
    ring.y[i] = 0.5 * static_cast<double>(i);
  }
  EXPECT_FALSE(relief_png(ring.input()).empty());
}

TEST(Relief, RefusesWhatIsNoRoad) {
  Ring ring;
  ReliefInput in = ring.input();
  in.z_m = in.z_m.subspan(1);
  EXPECT_THROW(relief_png(in), std::invalid_argument);
  for (float& z : ring.z) z = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(relief_png(ring.input()), std::invalid_argument);
  EXPECT_THROW(relief_png(ReliefInput{}), std::invalid_argument);
}

}  // namespace relief_test
}  // namespace report
