// A picture that cairo has drawn, as PNG. Private to lib/report.
#pragma once

#include <string>

typedef struct _cairo_surface cairo_surface_t;

namespace report {

/// The bytes of a PNG file, without alpha; `picture` is an image of 4 bytes a pixel.
std::string png_of(cairo_surface_t* picture);

}  // namespace report
