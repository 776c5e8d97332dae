#include "report/mean_colour.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "report/picture.h"

namespace report {
namespace {

constexpr std::string_view kPng = "\x89PNG\r\n\x1a\n", kJpeg = "\xff\xd8\xff";

std::size_t big_endian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::size_t value = 0;
  for (std::size_t k = 0; k < count; ++k)
    value = value << 8U | static_cast<unsigned char>(bytes[at + k]);
  return value;
}

/// As its first chunk says.
std::size_t pixels_of_png(std::string_view bytes) {
  if (bytes.size() < 24 || bytes.substr(12, 4) != "IHDR")
    throw std::invalid_argument("a damaged PNG: no size");
  return big_endian(bytes, 16, 4) * big_endian(bytes, 20, 4);
}

/// As its frame header says: the first that comes before the data.
std::size_t pixels_of_jpeg(std::string_view bytes) {
  for (std::size_t at = 2; at + 9 < bytes.size();) {
    if (static_cast<unsigned char>(bytes[at]) != 0xff) break;
    const auto marker = static_cast<unsigned char>(bytes[at + 1]);
    if (marker == 0xff) {  // filling
      ++at;
      continue;
    }
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame) return big_endian(bytes, at + 5, 2) * big_endian(bytes, at + 7, 2);
    if (marker == 0xda || marker == 0xd9) break;
    at += 2 + big_endian(bytes, at + 2, 2);
  }
  throw std::invalid_argument("a damaged JPEG: no size");
}

}  // namespace

std::array<double, 3> mean_colour(std::string_view bytes, std::size_t& pixels_left) {
  const bool is_png = bytes.starts_with(kPng);
  if (!is_png && !bytes.starts_with(kJpeg)) throw std::invalid_argument("no PNG or JPEG");
  const std::size_t pixels = is_png ? pixels_of_png(bytes) : pixels_of_jpeg(bytes);
  const std::size_t most = std::min(pixels_left, kMostPixels);
  if (pixels > most)
    throw std::invalid_argument("a picture of " + std::to_string(pixels) +
                                " pixels; wanted at most " + std::to_string(most));
  pixels_left -= pixels;
  const Picture picture = is_png ? decode_png(bytes, most) : decode_jpeg_eighth(bytes, most);
  std::array<double, 256> light{};
  for (std::size_t k = 0; k < light.size(); ++k) light[k] = linear_light(static_cast<double>(k));
  std::array<double, 3> sum{};
  double opacity = 0.0;
  for (std::size_t at = 0; at < picture.rgba.size(); at += 4) {
    const double weight = picture.rgba[at + 3];
    for (std::size_t k = 0; k < 3; ++k) sum[k] += weight * light[picture.rgba[at + k]];
    opacity += weight;
  }
  if (!(opacity > 0.0)) throw std::invalid_argument("a picture without anything to see");
  for (double& channel : sum) channel /= opacity;
  return sum;
}

}  // namespace report
