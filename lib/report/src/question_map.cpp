#include "report/question_map.h"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "cairo_png.h"

namespace report {
namespace {

constexpr int kSize_px = 1600;
constexpr double kMargin_px = 40.0, kHeader_px = 50.0, kRow_px = 30.0, kFooter_px = 50.0;
constexpr double kAround = 0.12;  // of the extent of the lines: what is shown around them
/// Told apart by people who see colours differently (Okabe and Ito 2008).
constexpr std::array<std::array<double, 3>, 6> kColours{{{0.00, 0.45, 0.70},
                                                         {0.84, 0.37, 0.00},
                                                         {0.00, 0.62, 0.45},
                                                         {0.80, 0.47, 0.65},
                                                         {0.34, 0.71, 0.91},
                                                         {0.90, 0.62, 0.00}}};

struct QuestionBounds {
  double x_low = std::numeric_limits<double>::infinity(), x_high = -x_low, y_low = x_low,
         y_high = -x_low;

  void extend(const std::array<double, 2>& p) {
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]))
      throw std::invalid_argument("question: a coordinate is not finite");
    x_low = std::min(x_low, p[0]), x_high = std::max(x_high, p[0]);
    y_low = std::min(y_low, p[1]), y_high = std::max(y_high, p[1]);
  }
};

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Pen = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

struct QuestionFrame {
  QuestionBounds shown;
  double px_per_m = 1.0, top_px = 0.0;
  int width_px = 0, height_px = 0;

  std::array<double, 2> operator()(const std::array<double, 2>& p) const {
    return {kMargin_px + (p[0] - shown.x_low) * px_per_m,
            top_px + (shown.y_high - p[1]) * px_per_m};
  }
};

QuestionFrame question_frame(std::span<const std::array<std::array<double, 2>, 3>> triangles,
                             std::span<const QuestionLine> lines) {
  QuestionFrame frame;
  for (const QuestionLine& line : lines)
    for (const auto& p : line.points_m) frame.shown.extend(p);
  if (lines.empty())
    for (const auto& triangle : triangles)
      for (const auto& p : triangle) frame.shown.extend(p);
  QuestionBounds& b = frame.shown;
  if (!(b.x_high >= b.x_low)) throw std::invalid_argument("question: there is nothing to show");
  const double extent = std::max({b.x_high - b.x_low, b.y_high - b.y_low, 1e-6});
  b.x_low -= kAround * extent, b.x_high += kAround * extent, b.y_low -= kAround * extent,
      b.y_high += kAround * extent;
  frame.px_per_m = (kSize_px - 2.0 * kMargin_px) / std::max(b.x_high - b.x_low, b.y_high - b.y_low);
  frame.top_px = kHeader_px + kRow_px * static_cast<double>(lines.size());
  frame.width_px =
      std::max(900, static_cast<int>(2.0 * kMargin_px + (b.x_high - b.x_low) * frame.px_per_m));
  frame.height_px =
      static_cast<int>(frame.top_px + kFooter_px + (b.y_high - b.y_low) * frame.px_per_m);
  return frame;
}

void draw_ground(cairo_t* pen, const QuestionFrame& frame,
                 std::span<const std::array<std::array<double, 2>, 3>> triangles) {
  const QuestionBounds& b = frame.shown;
  const auto low = frame({b.x_low, b.y_high});
  cairo_save(pen);
  cairo_rectangle(pen, low[0], low[1], (b.x_high - b.x_low) * frame.px_per_m,
                  (b.y_high - b.y_low) * frame.px_per_m);
  cairo_clip(pen);
  cairo_set_line_width(pen, 0.5);
  for (const auto& t : triangles) {
    const auto [x_low, x_high] = std::minmax({t[0][0], t[1][0], t[2][0]});
    const auto [y_low, y_high] = std::minmax({t[0][1], t[1][1], t[2][1]});
    if (x_high < b.x_low || x_low > b.x_high || y_high < b.y_low || y_low > b.y_high) continue;
    const auto p = frame(t[0]), q = frame(t[1]), r = frame(t[2]);
    cairo_set_source_rgb(pen, 0.90, 0.90, 0.89);
    if (std::max(x_high - x_low, y_high - y_low) * frame.px_per_m < 1.5) {
      cairo_rectangle(pen, std::floor(p[0]), std::floor(p[1]), 1.0, 1.0);
      cairo_fill(pen);
      continue;
    }
    cairo_move_to(pen, p[0], p[1]);
    cairo_line_to(pen, q[0], q[1]);
    cairo_line_to(pen, r[0], r[1]);
    cairo_close_path(pen);
    cairo_fill_preserve(pen);
    cairo_set_source_rgba(pen, 0.55, 0.55, 0.54, 0.5);
    cairo_stroke(pen);
  }
  cairo_restore(pen);
}

void set_colour(cairo_t* pen, std::size_t k) {
  const auto& c = kColours[k % kColours.size()];
  cairo_set_source_rgb(pen, c[0], c[1], c[2]);
}

void draw_line(cairo_t* pen, const QuestionFrame& frame, const QuestionLine& line, std::size_t k) {
  if (line.points_m.size() < 2) return;
  set_colour(pen, k);
  // Lines that share a road lie beside each other.
  cairo_set_line_width(
      pen, 3.0 + 1.2 * static_cast<double>(kColours.size() - std::min(k, kColours.size())));
  cairo_set_line_join(pen, CAIRO_LINE_JOIN_ROUND);
  for (std::size_t i = 0; i < line.points_m.size(); ++i) {
    const auto p = frame(line.points_m[i]);
    (i == 0 ? cairo_move_to : cairo_line_to)(pen, p[0], p[1]);
  }
  if (line.closed) cairo_close_path(pen);
  cairo_stroke(pen);
}

void draw_number(cairo_t* pen, const QuestionFrame& frame, const QuestionLine& line,
                 std::size_t k) {
  if (line.points_m.size() < 2) return;
  // Numbers of lines with one beginning stand apart.
  const std::size_t n = line.points_m.size(), at = std::min(n - 2, n * k / 12);
  const auto p = frame(line.points_m[at]), q = frame(line.points_m[at + 1]);
  const double heading = std::atan2(q[1] - p[1], q[0] - p[0]);
  set_colour(pen, k);
  cairo_arc(pen, p[0], p[1], 15.0, 0.0, 2.0 * std::numbers::pi);
  cairo_fill(pen);
  cairo_move_to(pen, p[0] + 30.0 * std::cos(heading), p[1] + 30.0 * std::sin(heading));
  for (const double turn : {2.6, -2.6})
    cairo_line_to(pen, p[0] + 17.0 * std::cos(heading) + 12.0 * std::cos(heading + turn),
                  p[1] + 17.0 * std::sin(heading) + 12.0 * std::sin(heading + turn));
  cairo_close_path(pen);
  cairo_fill(pen);
  cairo_set_source_rgb(pen, 1.0, 1.0, 1.0);
  const std::string number = std::to_string(k + 1);
  cairo_text_extents_t size;
  cairo_text_extents(pen, number.c_str(), &size);
  cairo_move_to(pen, p[0] - size.width / 2.0 - size.x_bearing,
                p[1] - size.height / 2.0 - size.y_bearing);
  cairo_show_text(pen, number.c_str());
}

void draw_words(cairo_t* pen, const QuestionFrame& frame, const std::string& title,
                std::span<const QuestionLine> lines) {
  cairo_set_source_rgb(pen, 0.1, 0.1, 0.1);
  cairo_move_to(pen, kMargin_px, 34.0);
  cairo_show_text(pen, title.c_str());
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const double y = kHeader_px + kRow_px * (static_cast<double>(k) + 0.7);
    set_colour(pen, k);
    cairo_rectangle(pen, kMargin_px, y - 14.0, 30.0, 14.0);
    cairo_fill(pen);
    cairo_set_source_rgb(pen, 0.1, 0.1, 0.1);
    cairo_move_to(pen, kMargin_px + 42.0, y);
    cairo_show_text(pen, (std::to_string(k + 1) + ": " + lines[k].text).c_str());
  }
  // A length of 1, 2 or 5 times a power of ten.
  const double wanted_m = 200.0 / frame.px_per_m,
               power = std::pow(10.0, std::floor(std::log10(wanted_m)));
  const double length_m = (wanted_m / power >= 5.0   ? 5.0
                           : wanted_m / power >= 2.0 ? 2.0
                                                     : 1.0) *
                          power;
  const double y = frame.height_px - 20.0;
  cairo_rectangle(pen, kMargin_px, y - 4.0, length_m * frame.px_per_m, 4.0);
  cairo_fill(pen);
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%g m; x to the right, y up", length_m);
  cairo_move_to(pen, kMargin_px + length_m * frame.px_per_m + 12.0, y + 2.0);
  cairo_show_text(pen, text.data());
}

}  // namespace

std::string question_map(const std::string& title,
                         std::span<const std::array<std::array<double, 2>, 3>> triangles,
                         std::span<const QuestionLine> lines) {
  const QuestionFrame frame = question_frame(triangles, lines);
  const Surface picture(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, frame.width_px, frame.height_px),
      &cairo_surface_destroy);
  if (cairo_surface_status(picture.get()) != CAIRO_STATUS_SUCCESS)
    throw std::invalid_argument("question: the picture is too large for memory");
  const Pen pen(cairo_create(picture.get()), &cairo_destroy);
  cairo_set_source_rgb(pen.get(), 1.0, 1.0, 1.0);
  cairo_paint(pen.get());
  cairo_select_font_face(pen.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                         CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(pen.get(), 20.0);
  draw_ground(pen.get(), frame, triangles);
  for (std::size_t k = 0; k < lines.size(); ++k) draw_line(pen.get(), frame, lines[k], k);
  for (std::size_t k = 0; k < lines.size(); ++k) draw_number(pen.get(), frame, lines[k], k);
  draw_words(pen.get(), frame, title, lines);
  return png_of(picture.get());
}

}  // namespace report
