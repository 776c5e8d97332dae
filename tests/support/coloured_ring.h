// A ring of road whose objects are told apart by their pictures alone, as files of a mesh.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "mesh/mesh.h"
#include "support/temporary_folder.h"

namespace support {

using Rgb = std::array<int, 3>;  ///< as pictures code it, 0 to 255
constexpr Rgb kAsphalt{98, 96, 92}, kGrass{84, 118, 58}, kEarth{122, 96, 66};

/// A picture of `side` by `side` pixels about one colour, each up to `noise` off it.
std::string png_of(const Rgb& rgb, int noise = 12, int side = 32);
std::string jpeg_of(const Rgb& rgb, int noise = 12, int side = 32);

/// Level ground between two offsets from a circle of 100 m (left is inwards), with one picture.
struct ColouredStrip {
  double right_m, left_m;
  Rgb rgb;
  double begin = 0.0, end = 1.0;  ///< of the way round
};

/// Objects called Plane.000 on, materials called Material.000 on, pictures p0.png on; every strip
/// has its own.
road::Mesh coloured_ring(const std::vector<ColouredStrip>& strips);

/// The mesh as ring.obj with ring.mtl and its pictures in the folder (PNG or JPEG by `ending`);
/// gives the mesh's path.
std::string coloured_obj(const TemporaryFolder& folder, const std::vector<ColouredStrip>& strips,
                         const std::string& ending = "png");

}  // namespace support
