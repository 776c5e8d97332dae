// What colour a picture has from far away.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace report {

/// The most pixels that mean_colour() takes of one picture: 64 MB.
constexpr std::size_t kMostPixels = std::size_t{4096} * 4096;

/// Of a coded value of 0 to 255 (sRGB): linear light, 0 to 1.
double linear_light(double coded_255);

/// Mean of the pixels of a PNG or JPEG in linear light, red, green and blue, 0 to 1. Each pixel of
/// a PNG counts by its opacity; of a JPEG, 8 by 8 pixels are one. `pixels_left` falls by the
/// picture's pixels before they take memory or time, whatever becomes of them. Throws
/// std::invalid_argument: no such picture, damaged, nothing opaque, more pixels than are left or
/// than kMostPixels.
std::array<double, 3> mean_colour(std::string_view bytes, std::size_t& pixels_left);

}  // namespace report
