#include "report/relief.h"

#include <cairo.h>

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include "cairo_png.h"
#include "relief_frame.h"
#include "relief_surface.h"
#include "relief_words.h"

namespace report {
namespace {

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

using Pen = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

void check(const ReliefInput& road, const ReliefOptions& options) {
  const std::size_t nodes = road.x_m.size() * road.v_m.size();
  if (road.x_m.size() < 2 || road.v_m.size() < 2)
    throw std::invalid_argument("relief: at least 2 rows and 2 columns wanted");
  if (road.y_m.size() != road.x_m.size() || road.z_m.size() != nodes ||
      (!road.kind.empty() && road.kind.size() != nodes))
    throw std::invalid_argument("relief: x, y, z and kind must have the shape of the grid");
  if (!(road.u_step_m > 0.0)) throw std::invalid_argument("relief: u_step_m must be positive");
  if (options.size_px < 400 || options.size_px > 20000)
    throw std::invalid_argument("relief: size_px from 400 to 20000 wanted");
}

}  // namespace

std::string relief_png(const ReliefInput& road, const ReliefOptions& options) {
  check(road, options);
  const Bounds bounds = bounds_of(road, 1);
  if (!(bounds.z_low <= bounds.z_high) || !(bounds.x_low <= bounds.x_high))
    throw std::invalid_argument("relief: no node has a height");
  const Frame frame = frame_of(bounds, options.size_px);
  const Surface picture(cairo_image_surface_create(CAIRO_FORMAT_RGB24, frame.width, frame.height),
                        &cairo_surface_destroy);
  if (cairo_surface_status(picture.get()) != CAIRO_STATUS_SUCCESS)
    throw std::invalid_argument("relief: the picture is too large for memory");
  cairo_surface_flush(picture.get());
  paint_surface(road, options, bounds, frame,
                reinterpret_cast<std::uint32_t*>(cairo_image_surface_get_data(picture.get())),
                static_cast<std::size_t>(cairo_image_surface_get_stride(picture.get())) / 4);
  cairo_surface_mark_dirty(picture.get());

  const Pen pen(cairo_create(picture.get()), &cairo_destroy);
  draw_words(road, bounds, frame, pen.get());
  return png_of(picture.get());
}

}  // namespace report
