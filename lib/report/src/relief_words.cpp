#include "relief_words.h"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace report {
namespace {

/// Lines, marks and words on top of the painted surface.
class Annotations {
 public:
  Annotations(const ReliefInput& road, const Bounds& bounds, const Frame& frame, cairo_t* pen)
      : road_(road), bounds_(bounds), frame_(frame), pen_(pen) {
    cairo_select_font_face(pen_, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_line_join(pen_, CAIRO_LINE_JOIN_ROUND);
    const std::size_t stride =
        std::max<std::size_t>(1, static_cast<std::size_t>(1.5 / frame.px_per_m / road.u_step_m));
    for (const std::size_t i : every(road.x_m.size(), stride)) {
      const Extent extent = extent_of(road, i);
      if (extent.empty()) {
        edges_.push_back({});
        continue;
      }
      edges_.push_back({true, frame(position_at(road, i, road.v_m[extent.first])),
                        frame(position_at(road, i, road.v_m[extent.last]))});
    }
  }

  void outline() {
    cairo_set_source_rgb(pen_, 0.25, 0.25, 0.27);
    cairo_set_line_width(pen_, 1.1);
    for (const bool left : {false, true}) {
      bool drawing = false;
      XY last{};
      for (const Edge& edge : edges_) {
        const XY p = left ? edge.left : edge.right;
        // A long jump is where the width changes abruptly or a leg was cut: still one border.
        if (edge.present && drawing && std::hypot(p.x - last.x, p.y - last.y) < 60.0)
          cairo_line_to(pen_, p.x, p.y);
        else if (edge.present)
          cairo_move_to(pen_, p.x, p.y);
        drawing = edge.present;
        last = p;
      }
      cairo_stroke(pen_);
    }
  }

  void start() {
    std::size_t row = 0;
    while (row + 1 < road_.x_m.size() && extent_of(road_, row).empty()) ++row;
    const auto [right, left] = sides(row);
    const XY d = direction_at(road_, row);
    const XY forward{d.x, -d.y};  // picture
    const double across = std::hypot(left.x - right.x, left.y - right.y);
    // A chequered strip, 2 rows of squares.
    const int squares = std::max(4, static_cast<int>(across / 5.0) / 2 * 2);
    const double side = across / squares;
    const XY step{(left.x - right.x) / squares, (left.y - right.y) / squares};
    for (int r = 0; r < 2; ++r)
      for (int s = 0; s < squares; ++s) {
        const double grey = (r + s) % 2 ? 1.0 : 0.0;
        cairo_set_source_rgb(pen_, grey, grey, grey);
        const XY o{right.x + step.x * s + forward.x * side * r,
                   right.y + step.y * s + forward.y * side * r};
        cairo_move_to(pen_, o.x, o.y);
        cairo_line_to(pen_, o.x + step.x, o.y + step.y);
        cairo_line_to(pen_, o.x + step.x + forward.x * side, o.y + step.y + forward.y * side);
        cairo_line_to(pen_, o.x + forward.x * side, o.y + forward.y * side);
        cairo_close_path(pen_);
        cairo_fill(pen_);
      }
    // The arrow beside the road on the side that has room.
    const double length = 90.0;
    for (const double out_sign : {-1.0, 1.0}) {
      const XY edge = out_sign < 0.0 ? right : left;
      const XY out{(left.x - right.x) / across * out_sign, (left.y - right.y) / across * out_sign};
      const XY a{edge.x + out.x * 26.0, edge.y + out.y * 26.0};
      const XY b{a.x + forward.x * length, a.y + forward.y * length};
      const bool last_chance = out_sign > 0.0;
      if (!last_chance && (covered(a, 12.0) || covered(b, 12.0))) continue;
      arrow(a, b);
      taken_.push_back({std::min(a.x, b.x) - 14, std::min(a.y, b.y) - 14, std::max(a.x, b.x) + 14,
                        std::max(a.y, b.y) + 14});
      break;
    }
    label("start", row, 24.0, true, 60.0);
  }

  void marks() {
    const double length_px =
        static_cast<double>(road_.x_m.size()) * road_.u_step_m * frame_.px_per_m;
    const double length_m = static_cast<double>(road_.x_m.size() - 1) * road_.u_step_m;
    double step_m = 500.0;
    for (const double candidate : {10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0}) {
      step_m = candidate;
      if (candidate >= 100.0 && candidate / length_m * length_px >= 170.0) break;
      if (candidate < 100.0 && length_m < 300.0 && candidate / length_m * length_px >= 170.0) break;
    }
    const double minor_m = step_m / 5.0;
    const double end_m = road_.u_begin_m + length_m - (road_.closed ? minor_m * 0.5 : 0.0);
    const double begin = std::ceil((road_.u_begin_m + 1e-6) / minor_m);
    for (double n = begin; n * minor_m <= end_m; n += 1.0) {
      const double u = n * minor_m;
      const auto row =
          static_cast<std::size_t>(std::clamp((u - road_.u_begin_m) / road_.u_step_m + 0.5, 0.0,
                                              static_cast<double>(road_.x_m.size() - 1)));
      if (extent_of(road_, row).empty()) continue;
      const auto [right, left] = sides(row);
      const bool major = std::abs(std::remainder(n, 5.0)) < 0.5;
      cairo_set_source_rgba(pen_, 0.0, 0.0, 0.0, major ? 0.9 : 0.45);
      cairo_set_line_width(pen_, major ? 2.2 : 1.2);
      cairo_move_to(pen_, right.x, right.y);
      cairo_line_to(pen_, left.x, left.y);
      cairo_stroke(pen_);
      char text[32];
      std::snprintf(text, sizeof text, "%.0f m", u);
      if (major) label(text, row, 22.0, false, 14.0);
    }
  }

  void header() {
    std::string title = road_.title.empty() ? "road" : road_.title;
    if (title.size() > 60) title = title.substr(0, 57) + "...";
    for (char& c : title)
      if (static_cast<unsigned char>(c) < 32) c = ' ';
    words(title, kMargin, 62.0, 40.0, true);
    double low = std::numeric_limits<double>::infinity(), high = 0.0;
    for (const Edge& edge : edges_) {
      if (!edge.present) continue;
      const double w =
          std::hypot(edge.left.x - edge.right.x, edge.left.y - edge.right.y) / frame_.px_per_m;
      low = std::min(low, w);
      high = std::max(high, w);
    }
    char text[200];
    std::snprintf(text, sizeof text,
                  "%.1f m long, %s, surface %.1f to %.1f m wide, height %.2f to %.2f m",
                  static_cast<double>(road_.x_m.size() - 1) * road_.u_step_m,
                  road_.closed ? "closed" : "open", low, high, bounds_.z_low + road_.z_offset_m,
                  bounds_.z_high + road_.z_offset_m);
    words(text, kMargin, 98.0, 24.0, false);
  }

  void footer() {
    const double y = frame_.height - kFooter + 55.0, bar = 30.0;
    // Colour legend.
    const double width = 480.0;
    cairo_pattern_t* ramp = cairo_pattern_create_linear(kMargin, 0, kMargin + width, 0);
    for (int i = 0; i <= 20; ++i) {
      const Rgb c = height_colour(i / 20.0);
      cairo_pattern_add_color_stop_rgb(ramp, i / 20.0, c.r, c.g, c.b);
    }
    cairo_rectangle(pen_, kMargin, y, width, bar);
    cairo_set_source(pen_, ramp);
    cairo_fill_preserve(pen_);
    cairo_pattern_destroy(ramp);
    cairo_set_source_rgb(pen_, 0.25, 0.25, 0.27);
    cairo_set_line_width(pen_, 1.0);
    cairo_stroke(pen_);
    const double span = bounds_.z_high - bounds_.z_low;
    for (int i = 0; i <= 4; ++i) {
      char text[32];
      std::snprintf(text, sizeof text, span < 4.0 ? "%.2f" : "%.1f",
                    road_.z_offset_m + bounds_.z_low + span * i / 4.0);
      if (std::strtod(text, nullptr) == 0.0 && text[0] == '-')  // no "-0.0"
        std::memmove(text, text + 1, std::strlen(text));
      const double x = kMargin + width * i / 4.0;
      cairo_move_to(pen_, x, y + bar);
      cairo_line_to(pen_, x, y + bar + 7.0);
      cairo_stroke(pen_);
      words(text, x - width_of(text, 20.0) / 2.0, y + bar + 28.0, 20.0, false);
    }
    words("height z (m)", kMargin, y - 12.0, 20.0, false);
    // Classes.
    double x = kMargin + width + 70.0;
    if (!road_.kind.empty()) {
      const Rgb middle = height_colour(0.5);
      swatch(x, y, bar, middle, middle);
      words("road", x + 56.0, y + 23.0, 20.0, false);
      x += 56.0 + width_of("road", 20.0) + 32.0;
      swatch(x, y, bar, kKerbRed, kKerbWhite);
      words("kerb", x + 56.0, y + 23.0, 20.0, false);
      x += 56.0 + width_of("kerb", 20.0) + 32.0;
      const Rgb pale = mix(middle, kRunoff, kRunoffShare);
      swatch(x, y, bar, pale, pale);
      words("run-off", x + 56.0, y + 23.0, 20.0, false);
    }
    // Scale: the longest round length within 300 px.
    double metres = 1.0;
    for (const double candidate :
         {2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0})
      if (candidate * frame_.px_per_m <= 300.0) metres = candidate;
    const double length = metres * frame_.px_per_m, x1 = frame_.width - kMargin, x0 = x1 - length;
    cairo_set_source_rgb(pen_, 0.1, 0.1, 0.1);
    cairo_set_line_width(pen_, 4.0);
    cairo_move_to(pen_, x0, y + 25.0);
    cairo_line_to(pen_, x1, y + 25.0);
    cairo_stroke(pen_);
    cairo_set_line_width(pen_, 2.0);
    for (const double end : {x0, x1}) {
      cairo_move_to(pen_, end, y + 12.0);
      cairo_line_to(pen_, end, y + 27.0);
      cairo_stroke(pen_);
    }
    char text[32];
    std::snprintf(text, sizeof text, "%.0f m", metres);
    words(text, (x0 + x1 - width_of(text, 20.0)) / 2.0, y + 4.0, 20.0, false);
    axes(frame_.width - kMargin - 40.0, 88.0);
  }

 private:
  struct Edge {
    bool present = false;
    XY right{}, left{};
  };
  struct Box {
    double x0, y0, x1, y1;
    bool hits(const Box& o) const { return x0 < o.x1 && o.x0 < x1 && y0 < o.y1 && o.y0 < y1; }
  };

  std::pair<XY, XY> sides(std::size_t row) const {
    const Extent e = extent_of(road_, row);
    if (e.empty())
      return {frame_(position_at(road_, row, -1.0)), frame_(position_at(road_, row, 1.0))};
    return {frame_(position_at(road_, row, road_.v_m[e.first])),
            frame_(position_at(road_, row, road_.v_m[e.last]))};
  }

  double width_of(const std::string& text, double size) {
    cairo_set_font_size(pen_, size);
    cairo_text_extents_t extents;
    cairo_text_extents(pen_, text.c_str(), &extents);
    return extents.x_advance;
  }

  void words(const std::string& text, double x, double y, double size, bool bold) {
    cairo_select_font_face(pen_, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(pen_, size);
    cairo_set_source_rgb(pen_, 0.1, 0.1, 0.1);
    cairo_move_to(pen_, x, y);
    cairo_show_text(pen_, text.c_str());
  }

  /// Whether road lies within `reach` px of a point of the picture.
  bool covered(const XY& p, double reach) const {
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const Edge& e = edges_[i];
      if (!e.present) continue;
      const XY d{e.left.x - e.right.x, e.left.y - e.right.y};
      const double length2 = std::max(d.x * d.x + d.y * d.y, 1e-9);
      const double t =
          std::clamp(((p.x - e.right.x) * d.x + (p.y - e.right.y) * d.y) / length2, 0.0, 1.0);
      if (std::hypot(p.x - e.right.x - d.x * t, p.y - e.right.y - d.y * t) < reach) return true;
    }
    return false;
  }

  /// Words beside the road at a row, on the side and at the distance where nothing else is;
  /// left out when there is no such place, unless it must be there.
  void label(const std::string& text, std::size_t row, double size, bool must, double away) {
    const double w = width_of(text, size), h = size * 0.75;
    const auto [right, left] = sides(row);
    const double across = std::max(std::hypot(left.x - right.x, left.y - right.y), 1e-9);
    for (const double more : {0.0, 14.0, 30.0, 50.0})
      for (const bool at_right : {true, false}) {
        const double sign = at_right ? -1.0 : 1.0;
        const XY out{(left.x - right.x) / across * sign, (left.y - right.y) / across * sign};
        const XY edge = at_right ? right : left;
        const double gap = away + more + std::abs(out.x) * w / 2 + std::abs(out.y) * h / 2;
        const XY c{edge.x + out.x * gap, edge.y + out.y * gap};
        const Box box{c.x - w / 2 - 4, c.y - h / 2 - 4, c.x + w / 2 + 4, c.y + h / 2 + 4};
        bool free = box.x0 > 4 && box.x1 < frame_.width - 4 && box.y0 > kHeader * 0.9 &&
                    box.y1 < frame_.height - kFooter * 0.75;
        for (const Box& other : taken_) free = free && !box.hits(other);
        for (double s = 0.0; free && s <= 1.0; s += 0.25)
          free = !covered({box.x0 + (box.x1 - box.x0) * s, c.y}, h / 2 + 5.0);
        if (!free) continue;
        taken_.push_back(box);
        words(text, c.x - w / 2, c.y + h / 2, size, must);
        return;
      }
  }

  void arrow(const XY& a, const XY& b) {
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    const XY d{(b.x - a.x) / length, (b.y - a.y) / length};
    cairo_set_source_rgb(pen_, 0.75, 0.1, 0.1);
    cairo_set_line_width(pen_, 5.0);
    cairo_move_to(pen_, a.x, a.y);
    cairo_line_to(pen_, b.x - d.x * 16.0, b.y - d.y * 16.0);
    cairo_stroke(pen_);
    cairo_move_to(pen_, b.x, b.y);
    cairo_line_to(pen_, b.x - d.x * 24.0 - d.y * 11.0, b.y - d.y * 24.0 + d.x * 11.0);
    cairo_line_to(pen_, b.x - d.x * 24.0 + d.y * 11.0, b.y - d.y * 24.0 - d.x * 11.0);
    cairo_close_path(pen_);
    cairo_fill(pen_);
  }

  void swatch(double x, double y, double height, const Rgb& a, const Rgb& b) {
    for (int i = 0; i < 4; ++i) {
      const Rgb& c = i % 2 ? b : a;
      cairo_set_source_rgb(pen_, c.r, c.g, c.b);
      cairo_rectangle(pen_, x + i * 11.5, y, 11.7, height);
      cairo_fill(pen_);
    }
    cairo_set_source_rgb(pen_, 0.25, 0.25, 0.27);
    cairo_set_line_width(pen_, 1.0);
    cairo_rectangle(pen_, x, y, 46.0, height);
    cairo_stroke(pen_);
  }

  void axes(double x, double y) {
    cairo_set_source_rgb(pen_, 0.1, 0.1, 0.1);
    cairo_set_line_width(pen_, 2.0);
    cairo_move_to(pen_, x - 20.0, y - 44.0);
    cairo_line_to(pen_, x - 20.0, y);
    cairo_line_to(pen_, x + 24.0, y);
    cairo_stroke(pen_);
    words("y", x - 26.0, y - 50.0, 20.0, false);
    words("x", x + 30.0, y + 6.0, 20.0, false);
  }

  const ReliefInput& road_;
  const Bounds& bounds_;
  const Frame& frame_;
  cairo_t* pen_;
  std::vector<Edge> edges_;
  std::vector<Box> taken_;
};

}  // namespace

void draw_words(const ReliefInput& road, const Bounds& bounds, const Frame& frame, cairo_t* pen) {
  Annotations draw(road, bounds, frame, pen);
  draw.outline();
  draw.start();
  draw.marks();
  draw.header();
  draw.footer();
}

}  // namespace report
