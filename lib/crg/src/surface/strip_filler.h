// Heights of a strip. A small tile of nodes, with line height and banking worked in, and the place
// of the strip on it as a quadratic function of the sample numbers replace a search per sample.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
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

/// Nodes of the grid around a strip: height above the base, float.
struct Tile {
  alignas(64) std::array<float, kTileSide * kTileSide> dz_m;
};

/// A part of a strip: samples [along_begin, along_end) x [across_begin, across_end).
struct StripPart {
  std::size_t along_begin, along_end, across_begin, across_end;
  std::size_t size() const { return (along_end - along_begin) * (across_end - across_begin); }
};

/// Evaluates the tile at the samples of a part. row, column: tile coordinates; out: the part's
/// first sample; stride: from one sample row to the next.
void fill_from_tile(const Tile& tile, const Quadratic& row, const Quadratic& column, double a0,
                    double b0, std::size_t rows, std::size_t columns, float* out,
                    std::size_t stride, StripKernel kernel) noexcept;

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
  void fill(Cursor& cursor, const HeightOf& z_of) noexcept {
    if (strip_.across == 0) return;
    const std::size_t rows = std::min(strip_.along, dz_m_.size() / strip_.across);
    cos_ = std::cos(strip_.heading_rad) * strip_.step_m;
    sin_ = std::sin(strip_.heading_rad) * strip_.step_m;
    fill_part({0, rows, 0, strip_.across}, cursor, z_of, 0);
  }

 private:
  double a_of(double i) const { return i - 0.5 * static_cast<double>(strip_.along - 1); }
  double b_of(double j) const { return j - 0.5 * static_cast<double>(strip_.across - 1); }
  Point2 point(double a, double b) const {
    return {strip_.x_m + a * cos_ - b * sin_, strip_.y_m + a * sin_ + b * cos_};
  }

  template <typename HeightOf>
  void fill_part(StripPart part, Cursor& cursor, const HeightOf& z_of, int depth) noexcept {
    if (part.size() == 0) return;
    if (part.size() >= 16 && try_tile(part, cursor)) return;
    if (part.size() >= 64 && depth < 24 && wide_) {
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

  /// False when the part does not fit a tile (wide_ then says that a smaller part might) or the
  /// road there is not as smooth as the quadratic assumes.
  bool try_tile(const StripPart& part, Cursor& cursor) noexcept;
  void fill_tile(std::size_t row, std::size_t column, std::size_t rows, Tile& tile) const noexcept;

  const Locator& locator_;
  const HeightField& heights_;
  const Strip& strip_;
  Place middle_;
  double segments_per_m_;
  double base_m_;
  std::span<float> dz_m_;
  double cos_ = 1.0, sin_ = 0.0;
  bool wide_ = false;
};

}  // namespace crg
