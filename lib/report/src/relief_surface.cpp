#include "relief_surface.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <thread>
#include <vector>

namespace report {
namespace {

constexpr int kBandRows = 32;    // px, one unit of parallel work
constexpr int kSub = 2;          // samples per pixel and axis
constexpr double kQuadPx = 0.8;  // wanted size of a cell of the thinned grid

/// The grid thinned to about one cell per pixel, in picture coordinates.
struct ThinGrid {
  std::vector<std::size_t> rows, columns;
  std::vector<XY> start, across;  ///< per thin row: position at v = 0, and per metre of v
  std::vector<double> y_low, y_high;
};

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

}  // namespace

void paint_surface(const ReliefInput& road, const ReliefOptions& options, const Bounds& bounds,
                   const Frame& frame, std::uint32_t* pixels, std::size_t pitch) {
  const ThinGrid grid = thin(road, frame);
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
}

}  // namespace report
