#include "strip_filler.h"

#include <optional>

namespace crg {

// The nodes of `rows` rows from (row, column) on; those beyond the grid are not used.
void StripFiller::fill_tile(std::size_t row, std::size_t column, std::size_t rows,
                            Tile& tile) const noexcept {
  const std::size_t columns = std::min(kTileSide, heights_.columns() - column);
  std::array<double, kTileSide> v_m;
  for (std::size_t j = 0; j < kTileSide; ++j)
    v_m[j] = heights_.v_right_m() + static_cast<double>(column + j) * heights_.v_step_m(0);
  for (std::size_t i = 0; i < rows; ++i) {
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
  }
}

namespace {

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

bool StripFiller::try_tile(const StripPart& part, Cursor& cursor) noexcept {
  wide_ = false;
  if (!heights_.plain() || !heights_.bilinear() || !(heights_.per_v_step() > 0.0)) return false;
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
    columns[i][j] = (place.v_m - heights_.v_right_m()) * heights_.per_v_step();
  };
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) look(i, j);
  if (!usable) return false;

  const std::optional<Quadratic> of_row = through(rows, ha, hb),
                                 of_column = through(columns, ha, hb);
  if (!of_row || !of_column) return false;
  Quadratic row = *of_row, column = *of_column;

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
  // Between the nine points the quadratic may reach a little further, and float rounds.
  constexpr double kMargin = 2e-3;
  row_min -= kMargin, column_min -= kMargin, row_max += kMargin, column_max += kMargin;
  if (row_min < 0.0 || column_min < 0.0 || row_max > static_cast<double>(heights_.rows() - 1) ||
      column_max > static_cast<double>(heights_.columns() - 1)) {
    return false;
  }
  const auto first = [](double least) { return static_cast<double>(static_cast<int>(least)); };
  const double first_row = first(row_min), first_column = first(column_min);
  constexpr double kSide = static_cast<double>(kTileSide - 1);
  if (row_max - first_row >= kSide || column_max - first_column >= kSide) {
    wide_ = true;
    return false;
  }
  Tile tile;
  // Rows of cells that hold samples, and the nodes at the end of the last.
  fill_tile(static_cast<std::size_t>(first_row), static_cast<std::size_t>(first_column),
            std::min(static_cast<std::size_t>(row_max - first_row) + 2,
                     heights_.rows() - static_cast<std::size_t>(first_row)),
            tile);
  row.c[0] -= first_row;
  column.c[0] -= first_column;
  fill_from_tile(tile, row, column, a_begin - a0, b_begin - b0, part.along_end - part.along_begin,
                 part.across_end - part.across_begin,
                 dz_m_.data() + part.along_begin * strip_.across + part.across_begin, strip_.across,
                 strip_.kernel);
  return true;
}

}  // namespace crg
