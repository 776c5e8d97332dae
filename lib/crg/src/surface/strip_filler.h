// Heights of a strip. A small tile of nodes, with line height and banking worked in, and the place
// of the strip on it as a quadratic function of the sample numbers replace a search per sample.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "crg/strip.h"
#include "height.h"
#include "locator.h"

namespace crg {

/// Row and column of the tile as a function of the offsets a (along) and b (across) in samples from
/// the middle: c[0] + c[1] a + c[2] b + c[3] a^2 + c[4] a b + c[5] b^2.
struct Quadratic {
  std::array<double, 6> c;
  double at(double a, double b) const {
    return c[0] + a * (c[1] + a * c[3] + b * c[4]) + b * (c[2] + b * c[5]);
  }
};

inline constexpr std::size_t kTileSide = 8;

/// Nodes of the grid around a part of a strip, and where the samples of the part lie on it.
struct Tile {
  alignas(64) std::array<float, kTileSide * kTileSide> dz_m;  ///< above the strip's base
  std::size_t rows;
  Quadratic row, column;  ///< of offsets from the middle of the part,
  double a0, b0;          ///< which lies here from the middle of the strip, in samples
};

/// A part of a strip: samples [along_begin, along_end) x [across_begin, across_end).
struct StripPart {
  std::size_t along_begin, along_end, across_begin, across_end;
  std::size_t size() const { return (along_end - along_begin) * (across_end - across_begin); }
};

/// Evaluates the tile at rows x columns samples, the first (a, b) from the middle of the tile's
/// part. stride: from one sample row of `out` to the next.
void fill_from_tile(const Tile& tile, double a, double b, std::size_t rows, std::size_t columns,
                    float* out, std::size_t stride, StripKernel kernel) noexcept;

/// Parts of fewer samples are asked for one by one.
inline constexpr std::size_t kLeastOnTile = 16, kLeastToCut = 32;

class StripFiller {
 public:
  /// middle: of the strip.
  StripFiller(const Locator& locator, const HeightField& heights, const Strip& strip,
              const Place& middle, double base_m, std::span<float> dz_m)
      : locator_(locator),
        heights_(heights),
        strip_(strip),
        middle_(middle),
        segments_per_m_(1.0 / locator.records()[middle.segment].frame.width(middle.v_m)),
        base_m_(base_m),
        dz_m_(dz_m) {}

  /// z_of(x, y, cursor): height of one point, for what the tile cannot do (borders, seams, holes in
  /// the assumptions).
  template <typename HeightOf>
  void fill(StripRows first, const MoreRows& more, Cursor& cursor, const HeightOf& z_of) noexcept {
    cos_ = strip_.ahead.x_m * strip_.step_m;
    sin_ = strip_.ahead.y_m * strip_.step_m;
    const std::size_t rows =
        strip_.across == 0 ? 0 : std::min(strip_.along, dz_m_.size() / strip_.across);
    const StripPart all{0, rows, 0, strip_.across};
    Tile tile;
    if (all.size() >= kLeastOnTile && lay_tile(all, cursor, tile)) {
      fill_rows(tile, first);
      const StripRows wanted =
          more(base_m_, highest_m(tile, {0, first.begin}), highest_m(tile, {first.end, rows}));
      fill_rows(tile, {wanted.begin, first.begin});
      fill_rows(tile, {first.end, wanted.end});
    } else {
      cut(all, cursor, z_of, 0);
      constexpr float kUnknown = std::numeric_limits<float>::infinity();
      more(base_m_, kUnknown, kUnknown);
    }
  }

 private:
  double a_of(double i) const { return i - 0.5 * static_cast<double>(strip_.along - 1); }
  double b_of(double j) const { return j - 0.5 * static_cast<double>(strip_.across - 1); }
  Point2 point(double a, double b) const {
    return {strip_.x_m + a * cos_ - b * sin_, strip_.y_m + a * sin_ + b * cos_};
  }

  template <typename HeightOf>
  void fill_part(const StripPart& part, Cursor& cursor, const HeightOf& z_of, int depth) noexcept {
    if (part.size() == 0) return;
    Tile tile;
    if (part.size() >= kLeastOnTile && lay_tile(part, cursor, tile))
      fill_part_of(tile, part);
    else
      cut(part, cursor, z_of, depth);
  }

  /// What lies on no tile: in halves, the smallest sample by sample.
  template <typename HeightOf>
  void cut(const StripPart& part, Cursor& cursor, const HeightOf& z_of, int depth) noexcept {
    if (part.size() >= kLeastToCut && depth < 24) {
      StripPart first = part, second = part;
      if (part.along_end - part.along_begin > part.across_end - part.across_begin) {
        first.along_end = second.along_begin = (part.along_begin + part.along_end) / 2;
      } else {
        first.across_end = second.across_begin = (part.across_begin + part.across_end) / 2;
      }
      fill_part(first, cursor, z_of, depth + 1);
      fill_part(second, cursor, z_of, depth + 1);
      return;
    }
    for (std::size_t i = part.along_begin; i < part.along_end; ++i) {
      for (std::size_t j = part.across_begin; j < part.across_end; ++j) {
        const Point2 p = point(a_of(static_cast<double>(i)), b_of(static_cast<double>(j)));
        dz_m_[i * strip_.across + j] = static_cast<float>(z_of(p.x_m, p.y_m, cursor) - base_m_);
      }
    }
  }

  /// False when the part does not fit a tile, its columns are not even or the road there is not as
  /// smooth as the quadratic assumes: a smaller part may do.
  bool lay_tile(const StripPart& part, Cursor& cursor, Tile& tile) noexcept;
  void fill_tile(std::size_t row, std::size_t column, Tile& tile) const noexcept;
  void fill_part_of(const Tile& tile, const StripPart& part) const noexcept;
  void fill_rows(const Tile& tile, StripRows rows) const noexcept {
    if (rows.begin < rows.end) fill_part_of(tile, {rows.begin, rows.end, 0, strip_.across});
  }
  /// What no sample of these rows of the whole strip is above.
  float highest_m(const Tile& tile, StripRows rows) const noexcept;

  const Locator& locator_;
  const HeightField& heights_;
  const Strip& strip_;
  Place middle_;
  double segments_per_m_;
  double base_m_;
  std::span<float> dz_m_;
  double cos_ = 1.0, sin_ = 0.0;
};

}  // namespace crg
