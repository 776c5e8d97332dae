#include "report/class_map.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "report/picture.h"

namespace report {
namespace class_map_test {

/// Two triangles over [x, x2] x [y, y2].
void add_box(std::vector<ClassTriangle>& out, double x, double y, double x2, double y2, double z,
             std::uint8_t kind) {
  out.push_back({{x, x2, x2}, {y, y, y2}, z, kind});
  out.push_back({{x, x2, x}, {y, y2, y2}, z, kind});
}

/// The pixel of a place in the map, by the world file.
std::array<int, 4> colour_at(const ClassMap& map, const Picture& picture, double x_m, double y_m) {
  std::istringstream lines(map.world_file);
  double a, d, b, e, c, f;
  lines >> a >> d >> b >> e >> c >> f;
  EXPECT_EQ(d, 0.0);
  EXPECT_EQ(b, 0.0);
  const auto column = std::lround((x_m - c) / a), row = std::lround((y_m - f) / e);
  EXPECT_TRUE(column >= 0 && column < picture.width_px && row >= 0 && row < picture.height_px);
  const std::uint8_t* p =
      &picture.rgba[4 * static_cast<std::size_t>(row * picture.width_px + column)];
  return {p[0], p[1], p[2], p[3]};
}

std::array<int, 4> colour_of(int kind) {
  const auto& c = kClassColours[static_cast<std::size_t>(kind)];
  return {c[0], c[1], c[2], 255};
}

TEST(ClassMap, EveryPlaceHasTheColourOfItsClassAndItsPlaceInTheMap) {
  std::vector<ClassTriangle> mesh;
  const double x0 = 500000.0, y0 = 4.2e6;                               // as a survey has it
  add_box(mesh, x0 - 5000, y0 - 5000, x0 + 5000, y0 + 5000, 300.0, 4);  // a sky
  add_box(mesh, x0, y0, x0 + 200, y0 + 10, 0.0, 0);
  add_box(mesh, x0, y0 - 5, x0 + 200, y0, 0.0, 2);
  add_box(mesh, x0 + 50, y0 + 10, x0 + 80, y0 + 11, 0.05, 1);
  mesh.push_back(
      {{x0, x0 + 200, x0 + 200}, {y0 - 5, y0 - 5, y0 - 5}, 1.0, 3});  // a wall, seen from above
  const ClassMap map = class_map(mesh, 1300);
  const Picture picture = decode_png(map.png);
  EXPECT_EQ(picture.width_px, 1300);
  EXPECT_EQ(colour_at(map, picture, x0 + 100, y0 + 5), colour_of(0));
  EXPECT_EQ(colour_at(map, picture, x0 + 60, y0 + 10.5), colour_of(1));
  EXPECT_EQ(colour_at(map, picture, x0 + 100, y0 + 10.5), colour_of(4));
  EXPECT_EQ(colour_at(map, picture, x0 + 100, y0 - 2.5), colour_of(2));
  EXPECT_EQ(colour_at(map, picture, x0 + 100, y0 - 5), colour_of(3));
  EXPECT_EQ(colour_at(map, picture, x0 - 20, y0 + 30), colour_of(4));
}

TEST(ClassMap, NothingIsTransparent) {
  std::vector<ClassTriangle> mesh;
  add_box(mesh, 0, 0, 100, 10, 0.0, 0);
  const ClassMap map = class_map(mesh, 160);
  EXPECT_EQ(colour_at(map, decode_png(map.png), 50, 30)[3], 0);
}

TEST(ClassMap, RefusesWhatHasNoRoad) {
  std::vector<ClassTriangle> mesh;
  EXPECT_THROW(class_map(mesh), std::invalid_argument);
  add_box(mesh, 0, 0, 1, 1, 0.0, 4);
  EXPECT_THROW(class_map(mesh), std::invalid_argument);
  add_box(mesh, 0, 0, NAN, 1, 0.0, 0);
  add_box(mesh, 0, 0, INFINITY, 1, 0.0, 0);
  EXPECT_THROW(class_map(mesh), std::invalid_argument);
}

TEST(Picture, ReadsBackWhatItWroteAndRefusesDamage) {
  const std::vector<std::uint8_t> pixels{1,  2,  3,  255, 40, 50, 60, 255,
                                         70, 80, 90, 0,   7,  7,  7,  255};
  const std::string png = encode_png(2, 2, pixels);
  EXPECT_EQ(decode_png(png).rgba, pixels);
  EXPECT_THROW(decode_png("no picture at all"), std::invalid_argument);
  EXPECT_THROW(decode_png(""), std::invalid_argument);
  for (std::size_t cut = 0; cut + 20 < png.size(); ++cut)
    EXPECT_THROW(decode_png(png.substr(0, cut)), std::invalid_argument) << cut;
  // A header that announces a picture of 10^10 pixels; its checksum is the header's weakest point,
  // so it may fail earlier.
  std::string huge = png;
  huge[16] = huge[20] = 0;
  huge[17] = huge[21] = 1;
  huge[18] = huge[22] = '\x86';
  EXPECT_THROW(decode_png(huge), std::invalid_argument);
  EXPECT_THROW(encode_png(2, 2, std::vector<std::uint8_t>(5)), std::invalid_argument);
}

}  // namespace class_map_test
}  // namespace report
