#include "cairo_png.h"

#include <cairo.h>

#include <cstdint>
#include <cstring>
#include <vector>

#include "report/picture.h"

namespace report {

std::string png_of(cairo_surface_t* picture) {
  cairo_surface_flush(picture);
  const auto width = static_cast<std::size_t>(cairo_image_surface_get_width(picture));
  const auto height = static_cast<std::size_t>(cairo_image_surface_get_height(picture));
  const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(picture));
  const unsigned char* data = cairo_image_surface_get_data(picture);
  std::vector<unsigned char> rgb(width * height * 3);
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      std::uint32_t pixel;
      std::memcpy(&pixel, data + y * stride + 4 * x, 4);
      unsigned char* out = &rgb[(y * width + x) * 3];
      out[0] = static_cast<unsigned char>(pixel >> 16);
      out[1] = static_cast<unsigned char>(pixel >> 8);
      out[2] = static_cast<unsigned char>(pixel);
    }
  return encode_png(static_cast<int>(width), static_cast<int>(height), rgb);
}

}  // namespace report
