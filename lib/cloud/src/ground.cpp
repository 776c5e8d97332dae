#include "cloud/ground.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "road/error.h"

namespace cloud {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

/// A raster of heights; NaN where nothing is known.
struct Raster {
  std::size_t columns = 0, rows = 0;
  std::vector<double> z;
  double& at(std::size_t i, std::size_t j) { return z[i * columns + j]; }
  double at(std::size_t i, std::size_t j) const { return z[i * columns + j]; }
};

/// Unknown cells by relaxation of the Laplace equation, coarse to fine: smooth, and exact at the
/// known ones.
void fill(Raster& raster, const std::vector<std::uint8_t>& known) {
  const auto rows = static_cast<std::ptrdiff_t>(raster.rows),
             columns = static_cast<std::ptrdiff_t>(raster.columns);
  std::vector<std::size_t> unknown;
  for (std::size_t k = 0; k < known.size(); ++k)
    if (!known[k]) unknown.push_back(k);
  if (unknown.size() == known.size() || unknown.empty()) return;
  // A first guess: the mean of the nearest known cells, ring by ring.
  std::vector<std::uint8_t> has = known;
  for (bool missing = true; missing;) {
    missing = false;
    std::vector<std::uint8_t> next = has;
    for (const std::size_t k : unknown) {
      if (has[k]) continue;
      const auto i = static_cast<std::ptrdiff_t>(k) / columns,
                 j = static_cast<std::ptrdiff_t>(k) % columns;
      double sum = 0.0, n = 0.0;
      for (std::ptrdiff_t a = std::max<std::ptrdiff_t>(0, i - 1); a <= std::min(rows - 1, i + 1);
           ++a)
        for (std::ptrdiff_t b = std::max<std::ptrdiff_t>(0, j - 1);
             b <= std::min(columns - 1, j + 1); ++b)
          if (has[static_cast<std::size_t>(a * columns + b)])
            sum += raster.z[static_cast<std::size_t>(a * columns + b)], n += 1.0;
      if (n > 0.0)
        raster.z[k] = sum / n, next[k] = 1;
      else
        missing = true;
    }
    has = std::move(next);
  }
  for (int sweep = 0; sweep < 100; ++sweep)
    for (const std::size_t k : unknown) {
      const auto i = static_cast<std::ptrdiff_t>(k) / columns,
                 j = static_cast<std::ptrdiff_t>(k) % columns;
      double sum = 0.0, n = 0.0;
      if (i > 0) sum += raster.z[k - raster.columns], n += 1.0;
      if (i + 1 < rows) sum += raster.z[k + raster.columns], n += 1.0;
      if (j > 0) sum += raster.z[k - 1], n += 1.0;
      if (j + 1 < columns) sum += raster.z[k + 1], n += 1.0;
      raster.z[k] += 1.5 * (sum / n - raster.z[k]);  // over-relaxed
    }
}

/// Lowest (sign 1) or highest (sign -1) height within a disc.
Raster extreme(const Raster& in, std::ptrdiff_t radius, double sign) {
  Raster out = in;
  const auto rows = static_cast<std::ptrdiff_t>(in.rows),
             columns = static_cast<std::ptrdiff_t>(in.columns);
  for (std::ptrdiff_t i = 0; i < rows; ++i)
    for (std::ptrdiff_t j = 0; j < columns; ++j) {
      double best = kInf;
      for (std::ptrdiff_t a = std::max<std::ptrdiff_t>(0, i - radius);
           a <= std::min(rows - 1, i + radius); ++a) {
        const auto reach = static_cast<std::ptrdiff_t>(
            std::sqrt(static_cast<double>(radius * radius - (a - i) * (a - i))));
        const double* const row = in.z.data() + a * columns;
        for (std::ptrdiff_t b = std::max<std::ptrdiff_t>(0, j - reach);
             b <= std::min(columns - 1, j + reach); ++b)
          best = std::min(best, sign * row[b]);
      }
      out.at(static_cast<std::size_t>(i), static_cast<std::size_t>(j)) = sign * best;
    }
  return out;
}

/// Marks cells that stand above the opened surface, window after window.
std::vector<std::uint8_t> objects_on(const Raster& raster, double slope, double max_window_m,
                                     double cell_m) {
  std::vector<std::uint8_t> object(raster.z.size(), 0);
  Raster last = raster;
  const auto windows = static_cast<std::ptrdiff_t>(std::ceil(max_window_m / cell_m));
  for (std::ptrdiff_t radius = 1; radius <= windows; ++radius) {
    const Raster opened = extreme(extreme(last, radius, 1.0), radius, -1.0);
    const double limit = slope * static_cast<double>(radius) * cell_m;
    for (std::size_t k = 0; k < object.size(); ++k)
      if (last.z[k] - opened.z[k] > limit) object[k] = 1;
    last = opened;
  }
  return object;
}

}  // namespace

std::vector<std::uint8_t> classify_ground(const Cloud& cloud, const GroundOptions& options) {
  if (cloud.size() == 0) return {};
  const auto [x0, x1] = std::minmax_element(cloud.x_m.begin(), cloud.x_m.end());
  const auto [y0, y1] = std::minmax_element(cloud.y_m.begin(), cloud.y_m.end());
  const double wide = (*x1 - *x0) / options.cell_m + 1.0, high = (*y1 - *y0) / options.cell_m + 1.0;
  if (wide * high > 5e7)
    throw road::Error(fmt::format(
        "{:.0f} x {:.0f} m in cells of {} m are too many; give a cell of {:.0f} m or more",
        *x1 - *x0, *y1 - *y0, options.cell_m,
        std::ceil(options.cell_m * std::sqrt(wide * high / 5e7))));
  Raster raster;
  raster.columns = static_cast<std::size_t>(wide), raster.rows = static_cast<std::size_t>(high);
  raster.z.assign(raster.columns * raster.rows, kInf);
  const auto cell_of = [&](std::size_t k) {
    return static_cast<std::size_t>((cloud.y_m[k] - *y0) / options.cell_m) * raster.columns +
           static_cast<std::size_t>((cloud.x_m[k] - *x0) / options.cell_m);
  };
  for (std::size_t k = 0; k < cloud.size(); ++k)
    raster.z[cell_of(k)] = std::min(raster.z[cell_of(k)], cloud.z_m[k]);
  std::vector<std::uint8_t> known(raster.z.size());
  for (std::size_t k = 0; k < known.size(); ++k) known[k] = std::isfinite(raster.z[k]) ? 1 : 0;
  fill(raster, known);
  // Points far below everything around: the same filter upside down, with one small window.
  Raster turned = raster;
  for (double& z : turned.z) z = -z;
  const std::vector<std::uint8_t> pits =
      objects_on(turned, 5.0 / options.cell_m, options.cell_m, options.cell_m);
  const std::vector<std::uint8_t> objects =
      objects_on(raster, options.slope, options.max_window_m, options.cell_m);
  for (std::size_t k = 0; k < known.size(); ++k)
    if (objects[k] || pits[k]) known[k] = 0;
  fill(raster, known);
  std::vector<std::uint8_t> ground(cloud.size(), 0);
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    const std::size_t cell = cell_of(k), i = cell / raster.columns, j = cell % raster.columns;
    const auto clamp = [](std::size_t a, std::ptrdiff_t d, std::size_t n) {
      return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(
          static_cast<std::ptrdiff_t>(a) + d, 0, static_cast<std::ptrdiff_t>(n) - 1));
    };
    const double gx =
        (raster.at(i, clamp(j, 1, raster.columns)) - raster.at(i, clamp(j, -1, raster.columns))) /
        (2.0 * options.cell_m);
    const double gy =
        (raster.at(clamp(i, 1, raster.rows), j) - raster.at(clamp(i, -1, raster.rows), j)) /
        (2.0 * options.cell_m);
    // The surface at the point itself, by the slope of its cell.
    const double dx = cloud.x_m[k] - *x0 - (static_cast<double>(j) + 0.5) * options.cell_m,
                 dy = cloud.y_m[k] - *y0 - (static_cast<double>(i) + 0.5) * options.cell_m;
    const double limit = options.height_m + options.height_per_slope_m * std::hypot(gx, gy);
    const double above = cloud.z_m[k] - (raster.at(i, j) + gx * dx + gy * dy);
    ground[k] = std::abs(above) <= limit ? 1 : 0;
  }
  return ground;
}

}  // namespace cloud
