#include "report/relief.h"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <thread>
#include <vector>

#include "report/picture.h"

namespace report {
namespace {

constexpr double kMargin = 70.0, kHeader = 120.0, kFooter = 150.0;  // px
constexpr int kMinWidth = 1300, kMinHeight = 900;                   // px: header and footer fit
constexpr int kBandRows = 32;                                       // px, one unit of parallel work
constexpr int kSub = 2;                                             // samples per pixel and axis
constexpr double kQuadPx = 0.8;  // wanted size of a cell of the thinned grid

struct Rgb {
  float r, g, b;
};

constexpr Rgb kPaper{1.0f, 1.0f, 1.0f}, kKerbRed{0.84f, 0.13f, 0.12f}, kKerbWhite{1.0f, 1.0f, 1.0f};
constexpr Rgb kRunoff{0.80f, 0.79f, 0.75f};
constexpr float kRunoffShare = 0.62f;

Rgb mix(const Rgb& a, const Rgb& b, float share) {
  return {a.r + (b.r - a.r) * share, a.g + (b.g - a.g) * share, a.b + (b.b - a.b) * share};
}

/// Dark to light with rising height, so that it also reads in grey. share in [0, 1].
Rgb height_colour(double share) {
  static constexpr std::array<Rgb, 6> kRamp{{{0.20f, 0.18f, 0.45f},
                                             {0.16f, 0.38f, 0.60f},
                                             {0.10f, 0.56f, 0.57f},
                                             {0.33f, 0.72f, 0.42f},
                                             {0.70f, 0.83f, 0.30f},
                                             {0.98f, 0.90f, 0.36f}}};
  const double at = std::clamp(share, 0.0, 1.0) * (kRamp.size() - 1);
  const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(at), kRamp.size() - 2);
  return mix(kRamp[i], kRamp[i + 1], static_cast<float>(at - static_cast<double>(i)));
}

struct XY {
  double x, y;
};

/// Unit vector along the reference line at a node; its left normal is (-y, x).
XY direction_at(const ReliefInput& road, std::size_t row) {
  const std::size_t a = row == 0 ? 0 : row - 1, b = std::min(row + 1, road.x_m.size() - 1);
  const double dx = road.x_m[b] - road.x_m[a], dy = road.y_m[b] - road.y_m[a];
  const double length = std::hypot(dx, dy);
  return length > 0.0 ? XY{dx / length, dy / length} : XY{1.0, 0.0};
}

XY position_at(const ReliefInput& road, std::size_t row, double v_m) {
  const XY d = direction_at(road, row);
  return {road.x_m[row] - v_m * d.y, road.y_m[row] + v_m * d.x};
}

/// Outermost columns with a height; first > last where the row has none.
struct Extent {
  std::size_t first, last;
  bool empty() const { return first > last; }
};

Extent extent_of(const ReliefInput& road, std::size_t row) {
  const std::size_t columns = road.v_m.size();
  const float* z = road.z_m.data() + row * columns;
  std::size_t first = 0, last = columns;
  while (first < columns && std::isnan(z[first])) ++first;
  while (last > first && std::isnan(z[last - 1])) --last;
  return first < last ? Extent{first, last - 1} : Extent{1, 0};
}

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

/// From the map to the picture; y of a picture points down.
struct Frame {
  double px_per_m = 1.0, left_m = 0.0, top_m = 0.0, left_px = 0.0, top_px = 0.0;
  int width = 0, height = 0;
  XY operator()(const XY& m) const {
    return {left_px + (m.x - left_m) * px_per_m, top_px + (top_m - m.y) * px_per_m};
  }
};

struct Bounds {
  double x_low = std::numeric_limits<double>::infinity(), x_high = -x_low;
  double y_low = x_low, y_high = -x_low;
  float z_low = std::numeric_limits<float>::infinity(), z_high = -z_low;
};

Bounds bounds_of(const ReliefInput& road, std::size_t row_stride) {
  Bounds b;
  for (std::size_t i = 0; i < road.x_m.size(); i += row_stride) {
    const Extent extent = extent_of(road, i);
    if (extent.empty()) continue;
    for (const std::size_t j : {extent.first, extent.last}) {
      const XY p = position_at(road, i, road.v_m[j]);
      if (!std::isfinite(p.x) || !std::isfinite(p.y)) continue;
      b.x_low = std::min(b.x_low, p.x);
      b.x_high = std::max(b.x_high, p.x);
      b.y_low = std::min(b.y_low, p.y);
      b.y_high = std::max(b.y_high, p.y);
    }
    const float* z = road.z_m.data() + i * road.v_m.size();
    for (std::size_t j = extent.first; j <= extent.last; ++j) {
      if (!(std::abs(z[j]) < 1e9f)) continue;
      b.z_low = std::min(b.z_low, z[j]);
      b.z_high = std::max(b.z_high, z[j]);
    }
  }
  return b;
}

Frame frame_of(const Bounds& b, int size_px) {
  const double w = std::max(b.x_high - b.x_low, 1.0), h = std::max(b.y_high - b.y_low, 1.0);
  const double room_x = size_px - 2.0 * kMargin, room_y = size_px - kHeader - kFooter;
  Frame frame;
  frame.px_per_m = std::min(room_x / w, room_y / h);
  frame.width = std::max(static_cast<int>(std::ceil(w * frame.px_per_m + 2.0 * kMargin)),
                         std::min(kMinWidth, size_px));
  frame.height = std::max(static_cast<int>(std::ceil(h * frame.px_per_m + kHeader + kFooter)),
                          std::min(kMinHeight, size_px));
  frame.left_px = (frame.width - w * frame.px_per_m) / 2.0;
  frame.top_px = kHeader + (frame.height - kHeader - kFooter - h * frame.px_per_m) / 2.0;
  frame.left_m = b.x_low;
  frame.top_m = b.y_high;
  return frame;
}

/// The grid thinned to about one cell per pixel, in picture coordinates.
struct ThinGrid {
  std::vector<std::size_t> rows, columns;
  std::vector<XY> start, across;  ///< per thin row: position at v = 0, and per metre of v
  std::vector<double> y_low, y_high;
};

std::vector<std::size_t> every(std::size_t count, std::size_t stride) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < count; i += stride) out.push_back(i);
  if (out.back() != count - 1) out.push_back(count - 1);
  return out;
}

ThinGrid thin(const ReliefInput& road, const Frame& frame) {
  ThinGrid grid;
  const double cell_m = kQuadPx / frame.px_per_m;
  grid.rows = every(road.x_m.size(),
                    std::max<std::size_t>(1, static_cast<std::size_t>(cell_m / road.u_step_m)));
  grid.columns.push_back(0);
  for (std::size_t j = 1; j + 1 < road.v_m.size(); ++j)
    if (road.v_m[j] - road.v_m[grid.columns.back()] >= cell_m * 0.999) grid.columns.push_back(j);
  grid.columns.push_back(road.v_m.size() - 1);
  for (const std::size_t i : grid.rows) {
    const XY d = direction_at(road, i);
    grid.start.push_back(frame({road.x_m[i], road.y_m[i]}));
    grid.across.push_back({-d.y * frame.px_per_m, -d.x * frame.px_per_m});
    const double a = grid.start.back().y + grid.across.back().y * road.v_m.front();
    const double b = grid.start.back().y + grid.across.back().y * road.v_m.back();
    grid.y_low.push_back(std::min(a, b));
    grid.y_high.push_back(std::max(a, b));
  }
  return grid;
}

/// One band of the picture: paints the cells that reach into it, highest wins (bridges), and
/// averages the samples of each pixel.
class Band {
 public:
  Band(const ReliefInput& road, const ReliefOptions& options, const Bounds& bounds,
       const Frame& frame, const ThinGrid& grid)
      : road_(road), bounds_(bounds), frame_(frame), grid_(grid) {
    const double azimuth = options.light_azimuth_deg * std::numbers::pi / 180.0;
    const double altitude = options.light_altitude_deg * std::numbers::pi / 180.0;
    light_ = {std::sin(azimuth) * std::cos(altitude), std::cos(azimuth) * std::cos(altitude)};
    light_z_ = std::sin(altitude);
    exaggeration_ = options.z_exaggeration;
    stripe_m_ = std::max(2.0, 5.0 / frame.px_per_m);
    z_.resize(static_cast<std::size_t>(frame.width) * kSub * kBandRows * kSub);
    colour_.resize(z_.size());
  }

  void paint(int top_px, int rows_px, std::uint32_t* pixels, std::size_t pitch) {
    top_ = top_px * kSub;
    bottom_ = (top_px + rows_px) * kSub;
    std::fill(z_.begin(), z_.end(), -std::numeric_limits<float>::infinity());
    for (std::size_t i = 0; i + 1 < grid_.rows.size(); ++i)
      if (std::max(grid_.y_high[i], grid_.y_high[i + 1]) >= top_px &&
          std::min(grid_.y_low[i], grid_.y_low[i + 1]) <= top_px + rows_px)
        paint_row(i);
    for (int y = 0; y < rows_px; ++y)
      for (int x = 0; x < frame_.width; ++x)
        pixels[static_cast<std::size_t>(y) * pitch + static_cast<std::size_t>(x)] = average(x, y);
  }

 private:
  void paint_row(std::size_t i) {
    const std::size_t columns = road_.v_m.size();
    const std::size_t row_a = grid_.rows[i], row_b = grid_.rows[i + 1];
    const float* za = road_.z_m.data() + row_a * columns;
    const float* zb = road_.z_m.data() + row_b * columns;
    const XY along = direction_at(road_, row_a);
    const double du = static_cast<double>(row_b - row_a) * road_.u_step_m;
    const bool odd_stripe =
        std::fmod(std::floor(static_cast<double>(row_a) * road_.u_step_m / stripe_m_), 2.0) != 0.0;
    for (std::size_t c = 0; c + 1 < grid_.columns.size(); ++c) {
      const std::size_t j = grid_.columns[c], k = grid_.columns[c + 1];
      if (std::isnan(za[j]) || std::isnan(za[k]) || std::isnan(zb[j]) || std::isnan(zb[k]))
        continue;
      const double dv = road_.v_m[k] - road_.v_m[j];
      const double slope_u = (zb[j] + zb[k] - za[j] - za[k]) / (2.0 * du);
      const double slope_v = (za[k] + zb[k] - za[j] - zb[j]) / (2.0 * dv);
      const float z = (za[j] + za[k] + zb[j] + zb[k]) / 4.0f;
      std::uint8_t kind = 0;
      if (!road_.kind.empty()) {
        // A thin kerb must not fall between two kept columns.
        const std::uint8_t* kinds = road_.kind.data() + row_a * columns;
        kind = kinds[j];
        for (std::size_t m = j; m < k; ++m)
          if (kinds[m] == 1) kind = 1;
      }
      fill(corner(i, j), corner(i, k), corner(i + 1, k), corner(i + 1, j), z,
           shaded(z, kind, odd_stripe, slope_u, slope_v, along));
    }
  }

  XY corner(std::size_t i, std::size_t column) const {
    const double v = road_.v_m[column];
    return {(grid_.start[i].x + grid_.across[i].x * v) * kSub,
            (grid_.start[i].y + grid_.across[i].y * v) * kSub};
  }

  std::uint32_t shaded(float z, std::uint8_t kind, bool odd_stripe, double slope_u, double slope_v,
                       const XY& along) const {
    const double span = std::max<double>(bounds_.z_high - bounds_.z_low, 1e-3);
    Rgb colour = height_colour((z - bounds_.z_low) / span);
    if (kind == 1) colour = odd_stripe ? kKerbRed : kKerbWhite;
    if (kind == 2) colour = mix(colour, kRunoff, kRunoffShare);
    const double gx = exaggeration_ * (slope_u * along.x - slope_v * along.y);
    const double gy = exaggeration_ * (slope_u * along.y + slope_v * along.x);
    const double lit =
        (light_z_ - gx * light_.x - gy * light_.y) / std::sqrt(1.0 + gx * gx + gy * gy);
    const auto shade = static_cast<float>(std::clamp(lit / light_z_, 0.25, 1.35));
    colour = {colour.r * shade, colour.g * shade, colour.b * shade};
    const auto byte = [](float c) {
      return static_cast<std::uint32_t>(std::clamp(c, 0.0f, 1.0f) * 255.0f + 0.5f);
    };
    return byte(colour.r) << 16 | byte(colour.g) << 8 | byte(colour.b);
  }

  /// Samples inside the convex quadrilateral, either way round.
  void fill(const XY& a, const XY& b, const XY& c, const XY& d, float z, std::uint32_t colour) {
    const double x_low = std::min({a.x, b.x, c.x, d.x}), x_high = std::max({a.x, b.x, c.x, d.x});
    const double y_low = std::min({a.y, b.y, c.y, d.y}), y_high = std::max({a.y, b.y, c.y, d.y});
    const int width = frame_.width * kSub;
    if (!(x_high >= 0.0 && x_low < width && y_high >= top_ && y_low < bottom_)) return;
    const int x0 = std::max(0, static_cast<int>(std::ceil(x_low - 0.5)));
    const int x1 = std::min(width - 1, static_cast<int>(std::floor(x_high - 0.5)));
    const int y0 = std::max(top_, static_cast<int>(std::ceil(y_low - 0.5)));
    const int y1 = std::min(bottom_ - 1, static_cast<int>(std::floor(y_high - 0.5)));
    const double area = (c.x - a.x) * (d.y - b.y) - (d.x - b.x) * (c.y - a.y);
    const double sign = area < 0.0 ? -1.0 : 1.0;
    const std::array<XY, 4> p{a, b, c, d};
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const double px = x + 0.5, py = y + 0.5;
        bool inside = true;
        for (std::size_t e = 0; e < 4 && inside; ++e) {
          const XY &s = p[e], &t = p[(e + 1) % 4];
          inside = sign * ((t.x - s.x) * (py - s.y) - (t.y - s.y) * (px - s.x)) >= 0.0;
        }
        const std::size_t at =
            static_cast<std::size_t>(y - top_) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(x);
        if (!inside || z < z_[at]) continue;
        z_[at] = z;
        colour_[at] = colour;
      }
    }
  }

  std::uint32_t average(int x, int y) const {
    const auto width = static_cast<std::size_t>(frame_.width) * kSub;
    std::array<std::uint32_t, 3> sum{};
    for (int sy = 0; sy < kSub; ++sy)
      for (int sx = 0; sx < kSub; ++sx) {
        const std::size_t at = static_cast<std::size_t>(y * kSub + sy) * width +
                               static_cast<std::size_t>(x * kSub + sx);
        const std::uint32_t colour = std::isinf(z_[at]) ? 0xffffffu : colour_[at];
        sum[0] += colour >> 16 & 255;
        sum[1] += colour >> 8 & 255;
        sum[2] += colour & 255;
      }
    constexpr std::uint32_t kCount = kSub * kSub;
    return (sum[0] / kCount) << 16 | (sum[1] / kCount) << 8 | sum[2] / kCount;
  }

  const ReliefInput& road_;
  const Bounds& bounds_;
  const Frame& frame_;
  const ThinGrid& grid_;
  XY light_{};
  double light_z_ = 1.0, exaggeration_ = 1.0, stripe_m_ = 2.0;
  int top_ = 0, bottom_ = 0;
  std::vector<float> z_;
  std::vector<std::uint32_t> colour_;
};

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Pen = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

void paint_surface(const ReliefInput& road, const ReliefOptions& options, const Bounds& bounds,
                   const Frame& frame, cairo_surface_t* picture) {
  const ThinGrid grid = thin(road, frame);
  cairo_surface_flush(picture);
  auto* pixels = reinterpret_cast<std::uint32_t*>(cairo_image_surface_get_data(picture));
  const std::size_t pitch = static_cast<std::size_t>(cairo_image_surface_get_stride(picture)) / 4;
  std::atomic<int> next{0};
  const auto work = [&] {
    Band band(road, options, bounds, frame, grid);
    for (int top; (top = next.fetch_add(kBandRows)) < frame.height;)
      band.paint(top, std::min(kBandRows, frame.height - top),
                 pixels + static_cast<std::size_t>(top) * pitch, pitch);
  };
  const unsigned threads =
      options.threads ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::jthread> helpers;
  for (unsigned t = 1; t < std::min(threads, 16u); ++t) helpers.emplace_back(work);
  work();
  helpers.clear();
  cairo_surface_mark_dirty(picture);
}

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

std::string to_png(cairo_surface_t* picture) {
  cairo_surface_flush(picture);
  const auto width = static_cast<std::size_t>(cairo_image_surface_get_width(picture));
  const auto height = static_cast<std::size_t>(cairo_image_surface_get_height(picture));
  const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(picture));
  const unsigned char* data = cairo_image_surface_get_data(picture);
  std::vector<unsigned char> rgb(width * height * 3);
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      std::uint32_t pixel;
      std::memcpy(&pixel, data + y * stride + 4 * x, 4);
      unsigned char* out = &rgb[(y * width + x) * 3];
      out[0] = static_cast<unsigned char>(pixel >> 16);
      out[1] = static_cast<unsigned char>(pixel >> 8);
      out[2] = static_cast<unsigned char>(pixel);
    }
  return encode_png(static_cast<int>(width), static_cast<int>(height), rgb);
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
  paint_surface(road, options, bounds, frame, picture.get());

  const Pen pen(cairo_create(picture.get()), &cairo_destroy);
  Annotations draw(road, bounds, frame, pen.get());
  draw.outline();
  draw.start();
  draw.marks();
  draw.header();
  draw.footer();

  return to_png(picture.get());
}

}  // namespace report
