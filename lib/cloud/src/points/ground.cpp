#include "cloud/ground.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "cloud/error.h"

namespace cloud {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kNoCell = std::numeric_limits<std::uint32_t>::max();
constexpr double kMostCells = 5e7;

using TilePlace = std::array<std::int64_t, 2>;  ///< row and column of a square of cells

/// Neighbouring cells of one row: columns [begin, end), and the number of the first.
struct Run {
  std::int64_t row, begin, end;
  std::size_t first;
  std::size_t size() const { return static_cast<std::size_t>(end - begin); }
};

/// The cells worth looking at, numbered row by row. Where they end, the area ends.
struct Cells {
  std::vector<Run> runs;                             ///< by row, then column
  std::vector<std::uint32_t> up, down, left, right;  ///< neighbours; kNoCell where there is none

  std::size_t size() const { return up.size(); }
  /// The first run of a row that ends behind a column; of a later row when there is none.
  std::size_t run_from(std::int64_t row, std::int64_t column) const {
    const auto found =
        std::lower_bound(runs.begin(), runs.end(), std::pair(row, column),
                         [](const Run& run, const std::pair<std::int64_t, std::int64_t>& wanted) {
                           return std::pair(run.row, run.end - 1) < wanted;
                         });
    return static_cast<std::size_t>(found - runs.begin());
  }
  /// Of a cell that exists.
  std::uint32_t at(std::int64_t row, std::int64_t column) const {
    const Run& run = runs[run_from(row, column)];
    return static_cast<std::uint32_t>(run.first + static_cast<std::size_t>(column - run.begin));
  }
  /// The eight around, row by row.
  std::array<std::uint32_t, 8> around(std::uint32_t k) const {
    const auto next = [](const std::vector<std::uint32_t>& to, std::uint32_t from) {
      return from == kNoCell ? kNoCell : to[from];
    };
    const auto corner = [&](const std::vector<std::uint32_t>& a,
                            const std::vector<std::uint32_t>& b) {
      const std::uint32_t found = next(b, a[k]);
      return found != kNoCell ? found : next(a, b[k]);
    };
    return {corner(up, left),   up[k],   corner(up, right),  left[k], right[k],
            corner(down, left), down[k], corner(down, right)};
  }
};

/// Whether tiles[k], of the sorted tiles of all points, is of the only point for three tiles
/// around.
bool alone(const std::vector<TilePlace>& tiles, std::size_t k) {
  if ((k > 0 && tiles[k - 1] == tiles[k]) || (k + 1 < tiles.size() && tiles[k + 1] == tiles[k]))
    return false;
  const auto [i, j] = tiles[k];
  std::size_t points = 0;
  for (std::int64_t row = i - 3; row <= i + 3 && points < 2; ++row)
    points += static_cast<std::size_t>(
        std::upper_bound(tiles.begin(), tiles.end(), TilePlace{row, j + 3}) -
        std::lower_bound(tiles.begin(), tiles.end(), TilePlace{row, j - 3}));
  return points < 2;
}

/// Tiles with points and those around them, as far as the area of rows x columns reaches.
Cells cells_around(const std::vector<TilePlace>& tiles, std::int64_t tile_cells, std::int64_t rows,
                   std::int64_t columns, double cell_m) {
  std::vector<TilePlace> wanted;
  wanted.reserve(9 * tiles.size());
  for (const auto& [i, j] : tiles)
    for (std::int64_t a = std::max<std::int64_t>(0, i - 1);
         a <= std::min((rows - 1) / tile_cells, i + 1); ++a)
      for (std::int64_t b = std::max<std::int64_t>(0, j - 1);
           b <= std::min((columns - 1) / tile_cells, j + 1); ++b)
        wanted.push_back({a, b});
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  const double all = static_cast<double>(wanted.size()) * static_cast<double>(tile_cells) *
                     static_cast<double>(tile_cells);
  if (std::min(all, static_cast<double>(rows) * static_cast<double>(columns)) > kMostCells)
    throw Error(fmt::format(
        "the points spread over {:.0f} x {:.0f} m and need {:.0f} million cells of {} m, {:.0f} "
        "million wanted at most; is the unit right? If so, give a cell of {:.0f} m or more",
        static_cast<double>(columns) * cell_m, static_cast<double>(rows) * cell_m, all / 1e6,
        cell_m, kMostCells / 1e6, std::ceil(cell_m * std::sqrt(all / kMostCells))));
  Cells cells;
  std::size_t count = 0;
  for (std::size_t from = 0, to = 0; from < wanted.size(); from = to) {
    while (to < wanted.size() && wanted[to][0] == wanted[from][0]) ++to;
    for (std::int64_t row = wanted[from][0] * tile_cells;
         row < std::min(rows, (wanted[from][0] + 1) * tile_cells); ++row)
      for (std::size_t k = from; k < to; ++k) {
        const std::int64_t begin = wanted[k][1] * tile_cells,
                           end = std::min(columns, begin + tile_cells);
        if (k > from && cells.runs.back().end == begin)
          cells.runs.back().end = end;
        else
          cells.runs.push_back({row, begin, end, count});
        count += static_cast<std::size_t>(end - begin);
      }
  }
  for (auto* neighbours : {&cells.up, &cells.down, &cells.left, &cells.right})
    neighbours->assign(count, kNoCell);
  std::size_t above = 0;
  for (const Run& run : cells.runs) {
    const auto first = static_cast<std::uint32_t>(run.first);
    for (std::uint32_t k = first; k + 1 < first + run.size(); ++k)
      cells.right[k] = k + 1, cells.left[k + 1] = k;
    while (std::pair(cells.runs[above].row, cells.runs[above].end - 1) <
           std::pair(run.row - 1, run.begin))
      ++above;
    for (std::size_t r = above; cells.runs[r].row < run.row && cells.runs[r].begin < run.end; ++r) {
      const Run& other = cells.runs[r];
      for (std::int64_t column = std::max(run.begin, other.begin);
           column < std::min(run.end, other.end); ++column) {
        const auto k = first + static_cast<std::uint32_t>(column - run.begin),
                   l = static_cast<std::uint32_t>(other.first) +
                       static_cast<std::uint32_t>(column - other.begin);
        cells.up[k] = l, cells.down[l] = k;
      }
    }
  }
  return cells;
}

/// Unknown cells by relaxation of the Laplace equation, coarse to fine: smooth, and exact at the
/// known ones.
void fill(const Cells& cells, const std::vector<std::uint8_t>& known, std::vector<double>& z) {
  // As on a chessboard, so that none hangs on the one before it.
  std::vector<std::uint32_t> unknown;
  for (const std::int64_t colour : {0, 1})
    for (const Run& run : cells.runs)
      for (std::int64_t column = run.begin + ((run.row + run.begin + colour) & 1); column < run.end;
           column += 2) {
        const auto k =
            static_cast<std::uint32_t>(run.first + static_cast<std::size_t>(column - run.begin));
        if (!known[k]) unknown.push_back(k);
      }
  if (unknown.size() == known.size() || unknown.empty()) return;
  // A first guess: the mean of the nearest known cells, ring by ring.
  enum : std::uint8_t { kMissing, kHas, kNext };
  std::vector<std::uint8_t> state = known;
  std::vector<std::uint32_t> ring, next;
  const auto queue_around = [&](std::uint32_t k) {
    for (const std::uint32_t other : cells.around(k))
      if (other != kNoCell && state[other] == kMissing) state[other] = kNext, next.push_back(other);
  };
  for (std::uint32_t k = 0; k < known.size(); ++k)
    if (known[k]) queue_around(k);
  while (!next.empty()) {
    ring.clear();
    std::swap(ring, next);
    for (const std::uint32_t k : ring) {
      double sum = 0.0, n = 0.0;
      for (const std::uint32_t other : cells.around(k))
        if (other != kNoCell && state[other] == kHas) sum += z[other], n += 1.0;
      z[k] = sum / n;
    }
    for (const std::uint32_t k : ring) state[k] = kHas;
    for (const std::uint32_t k : ring) queue_around(k);
  }
  for (int sweep = 0; sweep < 100; ++sweep)
    for (const std::uint32_t k : unknown) {
      double sum = 0.0, n = 0.0;
      for (const std::uint32_t other : {cells.up[k], cells.down[k], cells.left[k], cells.right[k]})
        if (other != kNoCell) sum += z[other], n += 1.0;
      z[k] += 1.5 * ((n == 4.0 ? 0.25 * sum : sum / n) - z[k]);  // over-relaxed
    }
}

/// Lowest (sign 1) or highest (sign -1) height within a disc.
std::vector<double> extreme(const Cells& cells, const std::vector<double>& z, std::int64_t radius,
                            double sign) {
  std::vector<double> out(z.size(), kInf), row, best;
  const auto r = static_cast<std::size_t>(radius);
  for (const Run& run : cells.runs) {
    // Of this row, the lowest within +-w, for w growing up to the radius; goes to the rows where
    // the disc is that wide.
    row.assign(run.size() + 4 * r, kInf);
    for (std::size_t k = 0; k < run.size(); ++k) row[2 * r + k] = sign * z[run.first + k];
    best.assign(row.begin() + radius, row.end() - radius);
    std::int64_t away = radius;
    for (std::size_t w = 0; w <= r; ++w) {
      for (std::size_t k = 0; w > 0 && k < best.size(); ++k)
        best[k] = std::min(best[k], std::min(row[k + r - w], row[k + r + w]));
      const auto reach = [&] {
        return static_cast<std::size_t>(
            std::sqrt(static_cast<double>(radius * radius - away * away)));
      };
      for (; away >= 0 && reach() == w; --away)
        for (const std::int64_t to : {run.row - away, run.row + away}) {
          for (std::size_t o = cells.run_from(to, run.begin - radius);
               o < cells.runs.size() && cells.runs[o].row == to &&
               cells.runs[o].begin < run.end + radius;
               ++o) {
            const Run& other = cells.runs[o];
            const std::int64_t begin = std::max(other.begin, run.begin - radius),
                               end = std::min(other.end, run.end + radius);
            double* const into = out.data() + other.first + (begin - other.begin);
            const double* const from = best.data() + (begin - run.begin + radius);
            for (std::int64_t k = 0; k < end - begin; ++k) into[k] = std::min(into[k], from[k]);
          }
          if (away == 0) break;
        }
    }
  }
  for (double& value : out) value *= sign;
  return out;
}

/// Marks cells that stand above the opened surface, window after window.
std::vector<std::uint8_t> objects_on(const Cells& cells, const std::vector<double>& z, double slope,
                                     std::int64_t windows, double cell_m,
                                     const std::function<void(double share)>& progress = {}) {
  std::vector<std::uint8_t> object(z.size(), 0);
  std::vector<double> last = z;
  for (std::int64_t radius = 1; radius <= windows; ++radius) {
    std::vector<double> opened = extreme(cells, extreme(cells, last, radius, 1.0), radius, -1.0);
    const double limit = slope * static_cast<double>(radius) * cell_m;
    for (std::size_t k = 0; k < object.size(); ++k)
      if (last[k] - opened[k] > limit) object[k] = 1;
    last = std::move(opened);
    if (progress)
      progress(static_cast<double>(radius * (radius + 1)) /
               static_cast<double>(windows * (windows + 1)));
  }
  return object;
}

/// Squares of one cell over the points of a cloud, from its lowest x and y on.
struct Raster {
  double x0, y0, cell_m;
  std::int64_t tile_cells;  ///< of a tile's side

  Raster(const Cloud& cloud, double side_m, std::int64_t cells_of_tile)
      : x0(*std::min_element(cloud.x_m.begin(), cloud.x_m.end())),
        y0(*std::min_element(cloud.y_m.begin(), cloud.y_m.end())),
        cell_m(side_m),
        tile_cells(cells_of_tile) {}
  std::int64_t index(double from, double to) const {
    return static_cast<std::int64_t>((to - from) / cell_m);
  }
  std::int64_t row(double y) const { return index(y0, y); }
  std::int64_t column(double x) const { return index(x0, x); }
  TilePlace tile_of(double x, double y) const {
    return {row(y) / tile_cells, column(x) / tile_cells};
  }
  /// From the middle of its cell.
  double beside(double from, double to) const {
    return to - from - (static_cast<double>(index(from, to)) + 0.5) * cell_m;
  }
};

/// The tiles of all points, sorted; one for each point.
std::vector<TilePlace> tiles_of(const Cloud& cloud, const Raster& raster) {
  std::vector<TilePlace> tiles;
  for (std::size_t k = 0; k < cloud.size(); ++k)
    tiles.push_back(raster.tile_of(cloud.x_m[k], cloud.y_m[k]));
  std::sort(tiles.begin(), tiles.end());
  return tiles;
}

/// A point alone, without another in a tile whose surroundings meet its own, has nothing to be
/// compared with and is ground; a raster would say the same with much more work. Throws Error where
/// most are.
std::vector<TilePlace> lonely_of(const std::vector<TilePlace>& tiles, const Raster& raster) {
  std::vector<TilePlace> lonely;
  for (std::size_t k = 0; k < tiles.size(); ++k)
    if (alone(tiles, k)) lonely.push_back(tiles[k]);
  if (lonely.size() > 1 && 2 * lonely.size() > tiles.size())
    throw Error(fmt::format(
        "{} of {} points have no other point within {:g} m: too few to tell ground; is the unit "
        "right? If so, give a larger window",
        lonely.size(), tiles.size(), 2.0 * static_cast<double>(raster.tile_cells) * raster.cell_m));
  return lonely;
}

/// The cells around all points but those of lonely tiles.
Cells cells_of(std::vector<TilePlace> tiles, const std::vector<TilePlace>& lonely,
               const Cloud& cloud, const Raster& raster) {
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  std::vector<TilePlace> together;
  std::set_difference(tiles.begin(), tiles.end(), lonely.begin(), lonely.end(),
                      std::back_inserter(together));
  const double x1 = *std::max_element(cloud.x_m.begin(), cloud.x_m.end()),
               y1 = *std::max_element(cloud.y_m.begin(), cloud.y_m.end());
  return cells_around(together, raster.tile_cells, raster.row(y1) + 1, raster.column(x1) + 1,
                      raster.cell_m);
}

/// The cell of each point; kNoCell for those of lonely tiles.
std::vector<std::uint32_t> cell_of_points(const Cloud& cloud, const Raster& raster,
                                          const std::vector<TilePlace>& lonely,
                                          const Cells& cells) {
  std::vector<std::uint32_t> cell_of(cloud.size(), kNoCell);
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    const double x = cloud.x_m[k], y = cloud.y_m[k];
    if (!std::binary_search(lonely.begin(), lonely.end(), raster.tile_of(x, y)))
      cell_of[k] = cells.at(raster.row(y), raster.column(x));
  }
  return cell_of;
}

/// The lowest point of each cell; infinite without one.
std::vector<double> lowest_in(const Cells& cells, const std::vector<std::uint32_t>& cell_of,
                              const Cloud& cloud) {
  std::vector<double> z(cells.size(), kInf);
  for (std::size_t k = 0; k < cloud.size(); ++k)
    if (cell_of[k] != kNoCell) z[cell_of[k]] = std::min(z[cell_of[k]], cloud.z_m[k]);
  return z;
}

/// Points far below everything around: the filter of objects upside down, with one small window.
std::vector<std::uint8_t> pits_in(const Cells& cells, std::vector<double> z, double cell_m) {
  for (double& value : z) value = -value;
  return objects_on(cells, z, 5.0 / cell_m, 1, cell_m);
}

/// The surface of the ground at the cells: without objects and pits, which are bridged.
std::vector<double> ground_surface(const Cells& cells, std::vector<double> z, std::int64_t windows,
                                   const GroundOptions& options) {
  std::vector<std::uint8_t> known(cells.size());
  for (std::size_t k = 0; k < known.size(); ++k) known[k] = std::isfinite(z[k]) ? 1 : 0;
  fill(cells, known, z);
  const std::vector<std::uint8_t> pits = pits_in(cells, z, options.cell_m);
  const std::vector<std::uint8_t> objects =
      objects_on(cells, z, options.slope, windows, options.cell_m, [&](double share) {
        if (options.progress) options.progress("ground", 0.3 + 0.5 * share);
      });
  for (std::size_t k = 0; k < known.size(); ++k)
    if (objects[k] || pits[k]) known[k] = 0;
  fill(cells, known, z);
  return z;
}

/// Per metre along x and y, from the neighbours of a cell.
Eigen::Vector2d slope_at(const Cells& cells, const std::vector<double>& z, std::uint32_t cell,
                         double cell_m) {
  const auto slope = [&](std::uint32_t forth, std::uint32_t back) {
    return (z[forth != kNoCell ? forth : cell] - z[back != kNoCell ? back : cell]) / (2.0 * cell_m);
  };
  return {slope(cells.right[cell], cells.left[cell]), slope(cells.down[cell], cells.up[cell])};
}

}  // namespace

std::vector<std::uint8_t> classify_ground(const Cloud& cloud, const GroundOptions& options) {
  if (cloud.size() == 0) return {};
  const auto windows = static_cast<std::int64_t>(std::ceil(options.max_window_m / options.cell_m));
  // The largest window, eroded and dilated, sees this far; narrower gaps are bridged.
  const Raster raster(cloud, options.cell_m, 2 * std::max<std::int64_t>(8, windows));
  const std::vector<TilePlace> tiles = tiles_of(cloud, raster), lonely = lonely_of(tiles, raster);
  const Cells cells = cells_of(tiles, lonely, cloud, raster);
  const std::vector<std::uint32_t> cell_of = cell_of_points(cloud, raster, lonely, cells);
  const std::vector<double> z =
      ground_surface(cells, lowest_in(cells, cell_of, cloud), windows, options);
  std::vector<std::uint8_t> ground(cloud.size(), 1);
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    const std::uint32_t cell = cell_of[k];
    if (cell == kNoCell) continue;
    // The surface at the point itself, by the slope of its cell.
    const Eigen::Vector2d slope = slope_at(cells, z, cell, options.cell_m);
    const double limit =
        options.height_m + options.height_per_slope_m * std::hypot(slope.x(), slope.y());
    const double above =
        cloud.z_m[k] - (z[cell] + slope.x() * raster.beside(raster.x0, cloud.x_m[k]) +
                        slope.y() * raster.beside(raster.y0, cloud.y_m[k]));
    ground[k] = std::abs(above) <= limit ? 1 : 0;
  }
  return ground;
}

}  // namespace cloud
