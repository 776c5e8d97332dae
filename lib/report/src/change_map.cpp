#include "report/change_map.h"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "cairo_png.h"

namespace report {
namespace {

constexpr double kMapMargin = 60.0, kMapHeader = 70.0, kMapFooter = 120.0;  // px
constexpr double kLongest = 2800.0, kLeastWidth = 900.0;                    // px

/// -1 blue, 0 grey, 1 red.
std::array<double, 3> colour_of(double share) {
  constexpr std::array<double, 3> kDown{0.10, 0.30, 0.75}, kSame{0.88, 0.88, 0.86},
      kUp{0.80, 0.12, 0.10};
  share = std::clamp(share, -1.0, 1.0);
  const std::array<double, 3>& end = share < 0.0 ? kDown : kUp;
  std::array<double, 3> out{};
  for (std::size_t k = 0; k < 3; ++k) out[k] = kSame[k] + std::abs(share) * (end[k] - kSame[k]);
  return out;
}

void write(cairo_t* pen, double x, double y, double size, const std::string& text) {
  cairo_set_source_rgb(pen, 0.1, 0.1, 0.1);
  cairo_set_font_size(pen, size);
  cairo_move_to(pen, x, y);
  cairo_show_text(pen, text.c_str());
}

std::string formatted(double value, const char* format) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// 1, 2 or 5 times a power of ten, at most `longest`.
double round_length(double longest) {
  const double power = std::pow(10.0, std::floor(std::log10(longest)));
  for (const double factor : {5.0, 2.0})
    if (factor * power <= longest) return factor * power;
  return power;
}

}  // namespace

std::string change_map_png(std::span<const ChangeSquare> squares, double cell_m,
                           std::span<const ChangeMark> marks, double full_m,
                           const std::string& title) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  double x0 = kInf, x1 = -kInf, y0 = kInf, y1 = -kInf;
  for (const ChangeSquare& s : squares) {
    if (!std::isfinite(s.x_m) || !std::isfinite(s.y_m) || !std::isfinite(s.change_m))
      throw std::invalid_argument("change_map_png: a square is not finite");
    x0 = std::min(x0, s.x_m), x1 = std::max(x1, s.x_m);
    y0 = std::min(y0, s.y_m), y1 = std::max(y1, s.y_m);
  }
  if (squares.empty() || !(cell_m > 0.0) || !(full_m > 0.0))
    throw std::invalid_argument("change_map_png: nothing to show");
  x0 -= cell_m, x1 += cell_m, y0 -= cell_m, y1 += cell_m;
  const double px_per_m = std::min(kLongest / std::max(x1 - x0, y1 - y0), 24.0 / cell_m);
  const double width = std::max(kLeastWidth, (x1 - x0) * px_per_m), height = (y1 - y0) * px_per_m;
  const int w = static_cast<int>(width + 2.0 * kMapMargin),
            h = static_cast<int>(height + kMapHeader + kMapFooter);
  const std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> picture(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, w, h), &cairo_surface_destroy);
  if (cairo_surface_status(picture.get()) != CAIRO_STATUS_SUCCESS)
    throw std::invalid_argument("change_map_png: no room for the picture");
  const std::unique_ptr<cairo_t, decltype(&cairo_destroy)> holder(cairo_create(picture.get()),
                                                                  &cairo_destroy);
  cairo_t* const pen = holder.get();
  cairo_set_source_rgb(pen, 1.0, 1.0, 1.0);
  cairo_paint(pen);
  cairo_select_font_face(pen, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  const auto px = [&](double x) { return kMapMargin + (x - x0) * px_per_m; };
  const auto py = [&](double y) { return kMapHeader + (y1 - y) * px_per_m; };
  cairo_set_antialias(pen, CAIRO_ANTIALIAS_NONE);
  // Where several squares share a pixel the most changed one is seen: it comes last.
  std::vector<const ChangeSquare*> order;
  for (const ChangeSquare& s : squares) order.push_back(&s);
  std::stable_sort(order.begin(), order.end(), [](const ChangeSquare* a, const ChangeSquare* b) {
    return std::abs(a->change_m) < std::abs(b->change_m);
  });
  const double side = std::max(1.0, cell_m * px_per_m);
  for (const ChangeSquare* s : order) {
    const auto c = colour_of(s->change_m / full_m);
    cairo_set_source_rgb(pen, c[0], c[1], c[2]);
    cairo_rectangle(pen, std::floor(px(s->x_m) - 0.5 * side), std::floor(py(s->y_m) - 0.5 * side),
                    std::ceil(side), std::ceil(side));
    cairo_fill(pen);
  }
  cairo_set_antialias(pen, CAIRO_ANTIALIAS_DEFAULT);
  for (std::size_t k = 0; k < marks.size(); ++k) {
    const double radius = std::max(12.0, marks[k].radius_m * px_per_m + 6.0);
    cairo_set_source_rgb(pen, 0.05, 0.05, 0.05);
    cairo_set_line_width(pen, 2.0);
    cairo_new_path(pen);
    cairo_arc(pen, px(marks[k].x_m), py(marks[k].y_m), radius, 0.0, 2.0 * std::numbers::pi);
    cairo_stroke(pen);
    write(pen, px(marks[k].x_m) + 0.75 * radius + 2.0, py(marks[k].y_m) - 0.75 * radius, 20.0,
          std::to_string(k + 1));
  }
  write(pen, kMapMargin, 42.0, 26.0, title);
  const double bar_y = kMapHeader + height + 30.0, bar = 360.0;
  for (int k = 0; k < 180; ++k) {
    const auto c = colour_of(2.0 * (k + 0.5) / 180.0 - 1.0);
    cairo_set_source_rgb(pen, c[0], c[1], c[2]);
    cairo_rectangle(pen, kMapMargin + 2.0 * k, bar_y, 2.0, 18.0);
    cairo_fill(pen);
  }
  write(pen, kMapMargin, bar_y + 42.0, 18.0, formatted(-1e3 * full_m, "%.0f mm: lower"));
  write(pen, kMapMargin + bar - 110.0, bar_y + 42.0, 18.0,
        formatted(1e3 * full_m, "higher: %.0f mm"));
  const double length = round_length(260.0 / px_per_m), from = kMapMargin + bar + 90.0;
  cairo_set_source_rgb(pen, 0.1, 0.1, 0.1);
  cairo_rectangle(pen, from, bar_y + 8.0, length * px_per_m, 4.0);
  cairo_fill(pen);
  write(pen, from, bar_y + 42.0, 18.0, formatted(length, "%g m; up is +y"));
  return png_of(picture.get());
}

}  // namespace report
