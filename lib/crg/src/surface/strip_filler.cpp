#include "strip_filler.h"

#include <optional>

namespace crg {

// The nodes of tile.rows rows from (row, column) on; those beyond the grid are not used.
void StripFiller::fill_tile(std::size_t row, std::size_t column, Tile& tile) const noexcept {
  const std::size_t columns = std::min(kTileSide, heights_.columns() - column);
  std::array<double, kTileSide> v_m;
  for (std::size_t j = 0; j < kTileSide; ++j)
    v_m[j] = heights_.v_m(column + std::min(j, columns - 1));
  for (std::size_t i = 0; i < tile.rows; ++i) {
    const float* z = heights_.node(row + i, column);
    const double line = heights_.line()[row + i].z_m - base_m_;
    const double banking = heights_.line()[row + i].banking;
    float* const out = tile.dz_m.data() + i * kTileSide;
    const auto put = [&](std::size_t j) {
      out[j] = static_cast<float>(line + banking * v_m[j] + static_cast<double>(z[j]));
    };
    if (columns == kTileSide)
      for (std::size_t j = 0; j < kTileSide; ++j) put(j);
    else
      for (std::size_t j = 0; j < columns; ++j) put(j);
    std::fill(out + columns, out + kTileSide, out[columns - 1]);
  }
}

namespace {

/// Between the nine points the quadratic may reach a little further, and float rounds.
constexpr double kMargin = 2e-3;
constexpr double kEven_m = 1e-9;  // between one column and the next: rounding

/// Through nine values at the offsets -half, 0 and half; none where it misses their corners.
std::optional<Quadratic> through(const double (&f)[3][3], double half_a, double half_b) {
  const double f0 = f[1][1];
  // Coefficients in the scaled offsets (-1, 0, 1), then in samples.
  const double ca = 0.5 * (f[2][1] - f[0][1]), cb = 0.5 * (f[1][2] - f[1][0]);
  const double caa = 0.5 * (f[2][1] + f[0][1]) - f0, cbb = 0.5 * (f[1][2] + f[1][0]) - f0;
  const double cab = 0.25 * (f[2][2] - f[2][0] - f[0][2] + f[0][0]);
  for (const int i : {0, 2}) {
    for (const int j : {0, 2}) {
      const double fitted = f0 + ca * (i - 1) + cb * (j - 1) + caa + cbb + cab * (i - 1) * (j - 1);
      if (!(std::abs(fitted - f[i][j]) < 1e-3)) return std::nullopt;
    }
  }
  const double per_a = 1.0 / half_a, per_b = 1.0 / half_b;
  return Quadratic{{f0, ca * per_a, cb * per_b, caa * (per_a * per_a), cab * (per_a * per_b),
                    cbb * (per_b * per_b)}};
}

}  // namespace

void StripFiller::fill_part_of(const Tile& tile, const StripPart& part) const noexcept {
  fill_from_tile(tile, a_of(static_cast<double>(part.along_begin)) - tile.a0,
                 b_of(static_cast<double>(part.across_begin)) - tile.b0,
                 part.along_end - part.along_begin, part.across_end - part.across_begin,
                 dz_m_.data() + part.along_begin * strip_.across + part.across_begin, strip_.across,
                 strip_.kernel);
}

float StripFiller::highest_m(const Tile& tile, StripRows rows) const noexcept {
  if (rows.begin >= rows.end) return -std::numeric_limits<float>::infinity();
  const double a_begin = a_of(static_cast<double>(rows.begin)) - tile.a0,
               a_end = a_of(static_cast<double>(rows.end - 1)) - tile.a0;
  const double b = 0.5 * static_cast<double>(strip_.across),
               a = std::max(std::abs(a_begin), std::abs(a_end));
  const auto& c = tile.row.c;
  const double middle = c[0] + 0.5 * (a_begin + a_end) * c[1];
  const double away = 0.5 * (a_end - a_begin) * std::abs(c[1]) + b * std::abs(c[2]) +
                      a * a * std::abs(c[3]) + a * b * std::abs(c[4]) + b * b * std::abs(c[5]) +
                      kMargin;
  const auto last = static_cast<std::ptrdiff_t>(tile.rows) - 1;
  const auto from = std::max<std::ptrdiff_t>(0, static_cast<std::ptrdiff_t>(middle - away)),
             to = std::min(last, static_cast<std::ptrdiff_t>(middle + away) + 1);
  std::array<float, kTileSide> of_column;
  of_column.fill(-std::numeric_limits<float>::infinity());
  for (std::ptrdiff_t i = from; i <= to; ++i) {
    const float* z = tile.dz_m.data() + i * static_cast<std::ptrdiff_t>(kTileSide);
    for (std::size_t j = 0; j < kTileSide; ++j)  // holes are not numbers
      of_column[j] = z[j] > of_column[j] ? z[j] : of_column[j];
  }
  return *std::max_element(of_column.begin(), of_column.end());
}

bool StripFiller::lay_tile(const StripPart& part, Cursor& cursor, Tile& tile) noexcept {
  if (!heights_.plain() || !heights_.bilinear()) return false;
  const double a_begin = a_of(static_cast<double>(part.along_begin)),
               a_end = a_of(static_cast<double>(part.along_end - 1));
  const double b_begin = b_of(static_cast<double>(part.across_begin)),
               b_end = b_of(static_cast<double>(part.across_end - 1));
  const double a0 = 0.5 * (a_begin + a_end), b0 = 0.5 * (b_begin + b_end);
  // Half extents; at least half a sample, so that single rows have a quadratic too.
  const double ha = std::max(0.5, 0.5 * (a_end - a_begin)),
               hb = std::max(0.5, 0.5 * (b_end - b_begin));

  double rows[3][3], columns[3][3];
  bool usable = true;
  const auto look = [&](std::size_t i, std::size_t j) {
    const Point2 p =
        point(a0 + (static_cast<double>(i) - 1.0) * ha, b0 + (static_cast<double>(j) - 1.0) * hb);
    Place place;
    // Each from the strip's middle, so that none waits for another.
    if (!locator_.locate_on(locator_.straight_from(middle_.segment, segments_per_m_, p.x_m, p.y_m),
                            p.x_m, p.y_m, place))
      place = locator_.locate(p.x_m, p.y_m, cursor);
    usable &= place.beyond_m == 0.0 && place.v_m >= heights_.v_right_m() &&
              place.v_m <= heights_.v_left_m();
    rows[i][j] = static_cast<double>(place.segment) + place.fraction;
    columns[i][j] = place.v_m;
  };
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) look(i, j);
  if (!usable) return false;
  // Columns as far apart as beside the middle of the part; whether they are is looked at below.
  const GridPlace beside = heights_.place(0, 0.0, columns[1][1]);
  const double v_step_m = heights_.v_step_m(beside.column), per_v_step = 1.0 / v_step_m;
  for (auto& line : columns)
    for (double& column : line)
      column =
          (column - heights_.v_m(beside.column)) * per_v_step + static_cast<double>(beside.column);

  const std::optional<Quadratic> of_row = through(rows, ha, hb),
                                 of_column = through(columns, ha, hb);
  if (!of_row || !of_column) return false;

  double row_min = rows[0][0], row_max = row_min, column_min = columns[0][0],
         column_max = column_min;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      row_min = std::min(row_min, rows[i][j]);
      row_max = std::max(row_max, rows[i][j]);
      column_min = std::min(column_min, columns[i][j]);
      column_max = std::max(column_max, columns[i][j]);
    }
  }
  row_min -= kMargin, column_min -= kMargin, row_max += kMargin, column_max += kMargin;
  if (row_min < 0.0 || column_min < 0.0 || row_max > static_cast<double>(heights_.rows() - 1) ||
      column_max > static_cast<double>(heights_.columns() - 1)) {
    return false;
  }
  const auto first = [](double least) { return static_cast<double>(static_cast<int>(least)); };
  const double first_row = first(row_min), first_column = first(column_min);
  constexpr double kSide = static_cast<double>(kTileSide - 1);
  if (row_max - first_row >= kSide || column_max - first_column >= kSide) return false;
  if (!(heights_.per_v_step() > 0.0))
    for (double at = first_column; at < column_max; ++at)
      if (!(std::abs(heights_.v_step_m(static_cast<std::size_t>(at)) - v_step_m) < kEven_m))
        return false;
  tile.row = *of_row, tile.column = *of_column;
  tile.row.c[0] -= first_row;
  tile.column.c[0] -= first_column;
  tile.a0 = a0, tile.b0 = b0;
  // Rows of cells that hold samples, and the nodes at the end of the last.
  tile.rows = std::min(static_cast<std::size_t>(row_max - first_row) + 2,
                       heights_.rows() - static_cast<std::size_t>(first_row));
  fill_tile(static_cast<std::size_t>(first_row), static_cast<std::size_t>(first_column), tile);
  return true;
}

}  // namespace crg
