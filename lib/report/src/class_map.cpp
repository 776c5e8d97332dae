#include "report/class_map.h"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <stdexcept>
#include <vector>

#include "report/picture.h"

namespace report {

namespace {

constexpr double kMargin_m = 30.0;
constexpr double kBarrierLine_px = 2.0;  // walls have no area from above
constexpr std::array<std::uint8_t, 5> kOrder{
    2, 3, 1, 4, 0};  // of road, kerb, run-off, barrier, scenery: later covers earlier

struct Window {
  double x_low_m, y_high_m, px_per_m;
  int width_px, height_px;
};

Window window_of(std::span<const ClassTriangle> triangles, int size_px) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  double x_low = kInf, x_high = -kInf, y_low = kInf, y_high = -kInf;
  for (const ClassTriangle& t : triangles) {
    if (t.kind > 2) continue;
    for (int k = 0; k < 3; ++k) {
      x_low = std::min(x_low, t.x_m[k]);
      x_high = std::max(x_high, t.x_m[k]);
      y_low = std::min(y_low, t.y_m[k]);
      y_high = std::max(y_high, t.y_m[k]);
    }
  }
  const double width_m = x_high - x_low + 2.0 * kMargin_m,
               height_m = y_high - y_low + 2.0 * kMargin_m;
  if (!std::isfinite(width_m + height_m) || size_px < 1)
    throw std::invalid_argument("class map: nothing drivable to show");
  const double px_per_m = size_px / std::max(width_m, height_m);
  return {x_low - kMargin_m, y_high + kMargin_m, px_per_m,
          std::max(1, static_cast<int>(std::ceil(width_m * px_per_m))),
          std::max(1, static_cast<int>(std::ceil(height_m * px_per_m)))};
}

}  // namespace

ClassMap class_map(std::span<const ClassTriangle> triangles, int size_px) {
  const Window frame = window_of(triangles, size_px);
  const std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> picture(
      cairo_image_surface_create(CAIRO_FORMAT_ARGB32, frame.width_px, frame.height_px),
      &cairo_surface_destroy);
  if (cairo_surface_status(picture.get()) != CAIRO_STATUS_SUCCESS)
    throw std::invalid_argument("class map: the picture is too large for memory");
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (triangles[i].kind >= kOrder.size())
      throw std::invalid_argument("class map: a kind that does not exist");
    order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const ClassTriangle &p = triangles[a], &q = triangles[b];
    if (p.kind != q.kind) return kOrder[p.kind] < kOrder[q.kind];
    return p.z_m != q.z_m ? p.z_m < q.z_m : a < b;
  });
  {
    const std::unique_ptr<cairo_t, decltype(&cairo_destroy)> pen(cairo_create(picture.get()),
                                                                 &cairo_destroy);
    cairo_set_antialias(pen.get(), CAIRO_ANTIALIAS_NONE);
    cairo_set_line_width(pen.get(), kBarrierLine_px);
    const double limit_px =
        4.0 * std::max(frame.width_px, frame.height_px);  // cairo's numbers end at 8 million
    for (const std::uint32_t i : order) {
      const ClassTriangle& t = triangles[i];
      const auto& colour = kClassColours[t.kind];
      cairo_set_source_rgb(pen.get(), colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0);
      for (int k = 0; k < 3; ++k) {
        const double x =
            std::clamp((t.x_m[k] - frame.x_low_m) * frame.px_per_m, -limit_px, limit_px);
        const double y =
            std::clamp((frame.y_high_m - t.y_m[k]) * frame.px_per_m, -limit_px, limit_px);
        k == 0 ? cairo_move_to(pen.get(), x, y) : cairo_line_to(pen.get(), x, y);
      }
      cairo_close_path(pen.get());
      if (t.kind == 3) cairo_stroke_preserve(pen.get());
      cairo_fill(pen.get());
    }
  }
  cairo_surface_flush(picture.get());
  // From cairo's words to bytes in place: the picture is large and lives only once. Rows of 4 bytes
  // a pixel have no gaps.
  unsigned char* data = cairo_image_surface_get_data(picture.get());
  const std::size_t bytes =
      4 * static_cast<std::size_t>(frame.width_px) * static_cast<std::size_t>(frame.height_px);
  for (unsigned char* at = data; at < data + bytes; at += 4) {
    std::uint32_t pixel;
    std::memcpy(&pixel, at, 4);
    const std::array<unsigned char, 4> rgba{
        static_cast<unsigned char>(pixel >> 16), static_cast<unsigned char>(pixel >> 8),
        static_cast<unsigned char>(pixel), static_cast<unsigned char>(pixel >> 24)};
    std::memcpy(at, rgba.data(), 4);
  }
  // A world file gives the middle of the first pixel.
  const double pixel_m = 1.0 / frame.px_per_m;
  char world[256];
  std::snprintf(world, sizeof world, "%.12g\n0\n0\n%.12g\n%.12g\n%.12g\n", pixel_m, -pixel_m,
                frame.x_low_m + 0.5 * pixel_m, frame.y_high_m - 0.5 * pixel_m);
  return {encode_png(frame.width_px, frame.height_px, {data, bytes}), world};
}

}  // namespace report
