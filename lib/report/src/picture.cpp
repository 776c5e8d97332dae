#include "report/picture.h"

#include <png.h>

#include <csetjmp>
#include <stdexcept>

namespace report {

Picture decode_png(std::string_view bytes, std::size_t most_pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()))
    throw std::invalid_argument(std::string("no PNG: ") + image.message);
  if (static_cast<std::size_t>(image.width) * image.height > most_pixels) {
    const std::string size = std::to_string(image.width) + " x " + std::to_string(image.height);
    png_image_free(&image);
    throw std::invalid_argument("a picture of " + size + " pixels; wanted at most " +
                                std::to_string(most_pixels) + " in all");
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

namespace {

// libpng leaves by longjmp, so nothing here may need a destructor.
bool write_grey(png_structp png, png_infop info, png_uint_32 width, png_uint_32 height,
                const std::uint16_t* const pixels, png_bytep row_bytes) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_IHDR(png, info, width, height, 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (png_uint_32 row = 0; row < height; ++row) {
    const std::uint16_t* const line = pixels + std::size_t{width} * row;
    for (std::size_t k = 0; k < width; ++k) {
      row_bytes[2 * k] = static_cast<png_byte>(line[k] >> 8U);
      row_bytes[2 * k + 1] = static_cast<png_byte>(line[k] & 0xffU);
    }
    png_write_row(png, row_bytes);
  }
  png_write_end(png, info);
  return true;
}

}  // namespace

std::string encode_grey_png(int width_px, int height_px, std::span<const std::uint16_t> pixels) {
  if (width_px <= 0 || height_px <= 0 ||
      pixels.size() != static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px))
    throw std::invalid_argument("a picture whose pixels do not fit its size");
  std::string bytes;
  std::vector<png_byte> row(2 * static_cast<std::size_t>(width_px));
  png_structp png = png_create_write_struct(
      PNG_LIBPNG_VER_STRING, nullptr, [](png_structp p, png_const_charp) { png_longjmp(p, 1); },
      [](png_structp, png_const_charp) {});
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const auto append = [](png_structp p, png_bytep data, std::size_t size) {
    static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(data), size);
  };
  bool written = false;
  if (info != nullptr) {
    png_set_write_fn(png, &bytes, append, nullptr);
    png_set_user_limits(png, 0x7fffffff, 0x7fffffff);
    written = write_grey(png, info, static_cast<png_uint_32>(width_px),
                         static_cast<png_uint_32>(height_px), pixels.data(), row.data());
  }
  png_destroy_write_struct(&png, &info);
  if (!written) throw std::invalid_argument("the picture cannot be encoded");
  return bytes;
}

}  // namespace report
