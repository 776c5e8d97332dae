#include "support/coloured_ring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>

// After the C headers that it needs.
#include <jpeglib.h>

#include "report/picture.h"
#include "support/mesh_files.h"
#include "support/ring_strips.h"

namespace support {
namespace {

std::vector<std::uint8_t> pixels_about(const Rgb& rgb, int noise, int side) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> off(-noise, noise);
  std::vector<std::uint8_t> pixels;
  for (int k = 0; k < side * side; ++k)
    for (const int value : rgb)
      pixels.push_back(static_cast<std::uint8_t>(std::clamp(value + off(random), 0, 255)));
  return pixels;
}

}  // namespace

std::string png_of(const Rgb& rgb, int noise, int side) {
  return report::encode_png(side, side, pixels_about(rgb, noise, side));
}

std::string jpeg_of(const Rgb& rgb, int noise, int side) {
  std::vector<std::uint8_t> pixels = pixels_about(rgb, noise, side);
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = jpeg.image_height = static_cast<JDIMENSION>(side);
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  while (jpeg.next_scanline < jpeg.image_height) {
    JSAMPROW row = pixels.data() + std::size_t{3} * jpeg.image_width * jpeg.next_scanline;
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  std::string out(reinterpret_cast<char*>(bytes), size);
  jpeg_destroy_compress(&jpeg);
  std::free(bytes);
  return out;
}

road::Mesh coloured_ring(const std::vector<ColouredStrip>& strips) {
  road::Mesh mesh;
  for (std::size_t k = 0; k < strips.size(); ++k) {
    const ColouredStrip& strip = strips[k];
    add_ring_strip(mesh, fmt::format("Plane.{:03d}", k), strip.right_m, strip.left_m, 0.0, 0.0,
                   strip.begin * kRingLength_m, strip.end * kRingLength_m);
    mesh.objects.back().material = fmt::format("Material.{:03d}", k);
    mesh.objects.back().texture = fmt::format("p{}.png", k);
  }
  return mesh;
}

std::string coloured_obj(const TemporaryFolder& folder, const std::vector<ColouredStrip>& strips,
                         const std::string& ending) {
  std::string materials;
  for (std::size_t k = 0; k < strips.size(); ++k) {
    materials +=
        fmt::format("newmtl Material.{:03d}\nKd 0.8 0.8 0.8\nmap_Kd p{}.{}\n", k, k, ending);
    folder.file(fmt::format("p{}.{}", k, ending),
                ending == "png" ? png_of(strips[k].rgb) : jpeg_of(strips[k].rgb));
  }
  folder.file("ring.mtl", materials);
  return folder.file("ring.obj", "mtllib ring.mtl\n" + as_obj(coloured_ring(strips)));
}

}  // namespace support
