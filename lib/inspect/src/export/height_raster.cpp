#include "inspect/height_raster.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "inspect/height_map.h"
#include "mesh/error.h"
#include "report/picture.h"

namespace road {
namespace {

constexpr double kMostSamples = 64e6;
constexpr double kLevels = 65534.0;  ///< steps between 1 and 65535
constexpr double kFinest_m = 1e-3;
constexpr double kDoubtful_m = 0.02;  ///< larger errors are looked at

struct Frame {
  double x_min, x_max, y_min, y_max;
};

// Where one of the two is not a number, neither is this; std::lerp is not so.
double between(double a, double b, double share) { return a + share * (b - a); }

// Where the road lies: its outer columns' nodes that are on it.
Frame frame_of(const HeightMap& map) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Frame frame{kInfinity, -kInfinity, kInfinity, -kInfinity};
  for (std::size_t row = 0; row < map.rows(); ++row)
    for (std::size_t j = 0; j < map.columns(); ++j) {
      if (std::isnan(map.at(row, j))) continue;
      const crg::Point2 p = crg::node_position(map.line, row, map.v_m[j]);
      frame = {std::min(frame.x_min, p.x_m), std::max(frame.x_max, p.x_m),
               std::min(frame.y_min, p.y_m), std::max(frame.y_max, p.y_m)};
    }
  if (!(frame.x_min <= frame.x_max))
    throw Error("the file has no road: every cell of its grid is empty");
  return frame;
}

// The samples in the boxes around the cells of the road; all others lie off it.
std::vector<char> near_road(const HeightRaster& raster, const HeightMap& map) {
  std::vector<char> near(raster.rows * raster.columns, 0);
  const std::size_t columns = map.columns();
  std::vector<crg::Point2> before(columns), here(columns);
  for (std::size_t row = 0; row < map.rows(); ++row) {
    for (std::size_t j = 0; j < columns; ++j)
      here[j] = crg::node_position(map.line, row, map.v_m[j]);
    for (std::size_t j = 0; row > 0 && j + 1 < columns; ++j) {
      const auto [west, east] =
          std::minmax({here[j].x_m, here[j + 1].x_m, before[j].x_m, before[j + 1].x_m});
      const auto [south, north] =
          std::minmax({here[j].y_m, here[j + 1].y_m, before[j].y_m, before[j + 1].y_m});
      // One more on either side, for rounding.
      const auto first = [](double at) { return static_cast<std::size_t>(std::max(at, 0.0)); };
      const auto end = [](double at, std::size_t count) {
        return static_cast<std::size_t>(std::clamp(at + 2.0, 0.0, static_cast<double>(count)));
      };
      const std::size_t column_end = end((east - raster.x_m) / raster.cell_m, raster.columns),
                        line_end = end((raster.y_m - south) / raster.cell_m, raster.rows);
      for (std::size_t line = first((raster.y_m - north) / raster.cell_m); line < line_end; ++line)
        for (std::size_t k = first((west - raster.x_m) / raster.cell_m); k < column_end; ++k)
          near[line * raster.columns + k] = 1;
    }
    std::swap(before, here);
  }
  return near;
}

}  // namespace

double HeightRaster::height(std::size_t row, std::size_t column) const {
  const std::uint16_t level = levels[row * columns + column];
  return level == 0 ? std::numeric_limits<double>::quiet_NaN() : z_m + z_step_m * level;
}

HeightRaster height_raster(const crg::Surface& road, double cell_m) {
  const HeightMap map = height_map(road);
  const Frame frame = frame_of(map);
  const auto low = [&](double at) { return std::floor(at / cell_m); };
  const auto high = [&](double at) { return std::ceil(at / cell_m); };
  const double across = std::max(high(frame.x_max) - low(frame.x_min) + 1.0, 2.0),
               up = std::max(high(frame.y_max) - low(frame.y_min) + 1.0, 2.0);
  if (across * up > kMostSamples)
    throw Error(fmt::format(
        "{:.0f} x {:.0f} samples {} m apart; at most {:.0f} million are written; give --step-m "
        "{:.2g}",
        across, up, cell_m, kMostSamples / 1e6,
        1.1 * cell_m * std::sqrt(across * up / kMostSamples)));
  HeightRaster raster;
  raster.columns = static_cast<std::size_t>(across);
  raster.rows = static_cast<std::size_t>(up);
  raster.cell_m = cell_m;
  raster.x_m = low(frame.x_min) * cell_m;
  raster.y_m = high(frame.y_max) * cell_m;
  std::vector<float> above_m(raster.rows * raster.columns);  // the road's first height
  const double base_m = road.z_at_uv(road.grid().u_begin_m, 0.0);
  const double zero_m = std::isfinite(base_m) ? base_m : 0.0;
  float least = std::numeric_limits<float>::infinity(), most = -least;
  const std::vector<char> near = near_road(raster, map);
  crg::Cursor cursor;
  for (std::size_t k = 0; k < above_m.size(); ++k) {
    above_m[k] = std::numeric_limits<float>::quiet_NaN();
    if (near[k] == 0) continue;
    const std::size_t row = k / raster.columns, column = k % raster.columns;
    const crg::Sample sample = road.at_xy(raster.x_m + static_cast<double>(column) * cell_m,
                                          raster.y_m - static_cast<double>(row) * cell_m, cursor);
    if (!sample.inside || !sample.valid) continue;
    above_m[k] = static_cast<float>(sample.z_m - zero_m);
    least = std::min(least, above_m[k]);
    most = std::max(most, above_m[k]);
  }
  if (!(least <= most))
    throw Error(fmt::format("no sample lies on the road; give --step-m less than {} m", cell_m));
  const double range_m = static_cast<double>(most) - static_cast<double>(least);
  raster.z_step_m = std::max(kFinest_m, range_m / kLevels);
  raster.z_m = zero_m + static_cast<double>(least) - raster.z_step_m;
  raster.levels.resize(above_m.size());
  for (std::size_t k = 0; k < above_m.size(); ++k) {
    if (std::isnan(above_m[k])) continue;
    const double level = (zero_m + static_cast<double>(above_m[k]) - raster.z_m) / raster.z_step_m;
    raster.levels[k] = static_cast<std::uint16_t>(std::clamp(std::round(level), 1.0, 65535.0));
  }
  return raster;
}

RasterLoss raster_loss(const HeightRaster& raster, const crg::Surface& road) {
  const HeightMap map = height_map(road);
  RasterLoss loss;
  loss.at_samples_m = 0.5 * raster.z_step_m;
  double squares = 0.0;
  std::size_t nodes = 0, held = 0, elsewhere = 0;
  crg::Cursor cursor;
  for (std::size_t row = 0; row < map.rows(); ++row)
    for (std::size_t j = 0; j < map.columns(); ++j) {
      if (std::isnan(map.at(row, j))) continue;
      ++nodes;
      const crg::Point2 p = crg::node_position(map.line, row, map.v_m[j]);
      const double x = (p.x_m - raster.x_m) / raster.cell_m,
                   y = (raster.y_m - p.y_m) / raster.cell_m;
      const auto column =
          static_cast<std::size_t>(std::clamp(x, 0.0, static_cast<double>(raster.columns) - 2.0));
      const auto line =
          static_cast<std::size_t>(std::clamp(y, 0.0, static_cast<double>(raster.rows) - 2.0));
      const double fx = x - static_cast<double>(column), fy = y - static_cast<double>(line);
      const double u_m = map.u_of(row);
      const auto same_leg = [&](std::size_t at_line, std::size_t at_column) {
        const double away_m = std::abs(
            road.uv_of_xy(raster.x_m + static_cast<double>(at_column) * raster.cell_m,
                          raster.y_m - static_cast<double>(at_line) * raster.cell_m, cursor)
                .u_m -
            u_m);
        const double around_m = map.u_end_m() - map.line.u_begin_m - away_m;
        return std::min(away_m, map.line.closed ? around_m : away_m) < 10.0 + 3.0 * raster.cell_m;
      };
      const double north =
                       between(raster.height(line, column), raster.height(line, column + 1), fx),
                   south = between(raster.height(line + 1, column),
                                   raster.height(line + 1, column + 1), fx);
      const double error_m =
          between(north, south, fy) - (map.z_base_m + static_cast<double>(map.at(row, j)));
      if (std::isnan(error_m)) continue;
      // Between legs that lie above each other: not a loss of the raster's own.
      if (std::abs(error_m) > kDoubtful_m) {
        const bool own = same_leg(line, column) && same_leg(line, column + 1) &&
                         same_leg(line + 1, column) && same_leg(line + 1, column + 1);
        if (!own) {
          ++elsewhere;
          continue;
        }
      }
      ++held;
      squares += error_m * error_m;
      loss.between_samples_m = std::max(loss.between_samples_m, std::abs(error_m));
    }
  if (held > 0) loss.rms_m = std::sqrt(squares / static_cast<double>(held));
  const double all = static_cast<double>(std::max<std::size_t>(nodes, 1));
  loss.nodes_of_other_legs = static_cast<double>(elsewhere) / all;
  loss.nodes_without = 1.0 - static_cast<double>(held + elsewhere) / all;
  return loss;
}

std::string raw_bytes(const HeightRaster& raster) {
  std::string bytes;
  bytes.reserve(2 * raster.levels.size());
  for (const std::uint16_t level : raster.levels) {
    bytes.push_back(static_cast<char>(level & 0xffU));
    bytes.push_back(static_cast<char>(level >> 8U));
  }
  return bytes;
}

std::string png_bytes(const HeightRaster& raster) {
  return report::encode_grey_png(static_cast<int>(raster.columns), static_cast<int>(raster.rows),
                                 raster.levels);
}

}  // namespace road
