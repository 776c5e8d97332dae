// Pictures as PNG files in memory. libpng and libjpeg stay behind this header.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace report {

/// Rows from top to bottom, four bytes a pixel: red, green, blue, opacity.
struct Picture {
  int width_px = 0, height_px = 0;
  std::vector<std::uint8_t> rgba;
};

constexpr std::size_t kMaxPicturePixels = 100'000'000;  ///< 400 MB

/// Any PNG, as 8 bits a channel. The size is looked at before memory is taken. Throws
/// std::invalid_argument.
Picture decode_png(std::string_view bytes, std::size_t most_pixels = kMaxPicturePixels);

/// Any JPEG of one or three channels, 8 by 8 pixels of it as one: the mean of the coded values.
/// Throws std::invalid_argument, also for data that are damaged in any way.
Picture decode_jpeg_eighth(std::string_view bytes, std::size_t most_pixels);

/// Three or four bytes a pixel. libpng's fast mode takes a quarter of the time of cairo's own
/// writer for 15 % more bytes. Throws std::invalid_argument.
std::string encode_png(int width_px, int height_px, std::span<const std::uint8_t> pixels);

/// 16 bits a pixel, shades of grey, without a gamma: numbers more than a picture. Throws
/// std::invalid_argument.
std::string encode_grey_png(int width_px, int height_px, std::span<const std::uint16_t> pixels);

}  // namespace report
