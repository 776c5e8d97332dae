// A plan of everything a mesh holds, in the colours of its classes, with its place.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace report {

/// One triangle seen from above. kind: 0 road, 1 kerb, 2 run-off, 3 barrier, 4 scenery.
struct ClassTriangle {
  std::array<double, 3> x_m, y_m;  ///< map coordinates
  double z_m = 0.0;                ///< of its middle: higher ones cover lower ones of their kind
  std::uint8_t kind = 4;
};

struct ClassMap {
  std::string png;  ///< transparent where there is nothing
  std::string
      world_file;  ///< six lines that give the pixels their map coordinates (ESRI world file)
};

constexpr std::array<std::array<std::uint8_t, 3>, 5> kClassColours{
    {{58, 74, 107}, {206, 32, 41}, {118, 158, 84}, {240, 150, 30}, {206, 190, 150}}};

/// Shows what lies within 30 m of the drivable kinds, the longer side `size_px` pixels: scenery
/// below run-off, road, kerbs and barriers, so that no roof or sky hides the road. Colours are not
/// blended: every pixel is one class. Throws std::invalid_argument when no triangle is drivable or
/// coordinates are not finite.
ClassMap class_map(std::span<const ClassTriangle> triangles, int size_px = 3000);

}  // namespace report
