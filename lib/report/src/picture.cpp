#include "report/picture.h"

#include <png.h>

#include <stdexcept>

namespace report {

Picture decode_png(std::string_view bytes) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()))
    throw std::invalid_argument(std::string("no PNG: ") + image.message);
  if (static_cast<std::size_t>(image.width) * image.height > kMaxPicturePixels) {
    const std::string size = std::to_string(image.width) + " x " + std::to_string(image.height);
    png_image_free(&image);
    throw std::invalid_argument("a picture of " + size + " pixels; wanted at most " +
                                std::to_string(kMaxPicturePixels) + " in all");
  }
  image.format = PNG_FORMAT_RGBA;
  Picture picture{static_cast<int>(image.width), static_cast<int>(image.height),
                  std::vector<std::uint8_t>(PNG_IMAGE_SIZE(image))};
  if (!png_image_finish_read(&image, nullptr, picture.rgba.data(), 0, nullptr))
    throw std::invalid_argument(std::string("a damaged PNG: ") + image.message);
  return picture;
}

std::string encode_png(int width_px, int height_px, std::span<const std::uint8_t> pixels) {
  const std::size_t count =
      static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  if (width_px <= 0 || height_px <= 0 || (pixels.size() != 3 * count && pixels.size() != 4 * count))
    throw std::invalid_argument("a picture whose pixels do not fit its size");
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_px);
  image.height = static_cast<png_uint_32>(height_px);
  image.format = pixels.size() == 3 * count ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  image.flags = PNG_IMAGE_FLAG_FAST;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr))
    throw std::invalid_argument(std::string("the picture cannot be encoded: ") + image.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace report
