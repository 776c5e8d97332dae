#include "crg/surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <new>
#include <vector>

#include "batch.h"
#include "crg/error.h"
#include "strip_filler.h"
#include "surface_data.h"

namespace crg {
namespace {

// Map points as they come: pairs, or x and y each by themselves.
auto in_pairs(std::span<const Point2> points) {
  return [p = points.data()](std::size_t k) { return p[k]; };
}
auto apart(std::span<const double> x_m, std::span<const double> y_m) {
  return [x = x_m.data(), y = y_m.data()](std::size_t k) { return Point2{x[k], y[k]}; };
}

// Errors about the contents name the file they came from.
template <typename Work>
auto naming(const std::string& source, Work work) {
  try {
    return work();
  } catch (const Error& error) {
    if (source.empty()) throw;
    throw Error(source + ": " + error.what());
  }
}

}  // namespace

inline double Surface::Data::z_of(const Place& place) const noexcept {
  if (heights.plain() && on_grid(place)) {
    if (heights.simple()) {
      const double z = heights.z_simple(
          heights.place_simple(place.segment, place.fraction, place.v_m), place.v_m);
      if (!std::isnan(z)) return z;
    }
    return heights.on_grid(place.segment, place.fraction, place.v_m).z_m;
  }
  return heights.at(u_of(place), place.v_m).z_m;
}

// After a jump the rows of the grid are fetched while the place is still being refined.
inline Place Surface::Data::locate_far(double x_m, double y_m, Cursor& cursor) const noexcept {
  return locator.locate_from(x_m, y_m, cursor, [&](std::size_t segment, float v_m) {
    heights.prefetch_cell(segment, static_cast<double>(v_m));
  });
}

[[gnu::noinline]] double Surface::Data::z_anywhere(double x_m, double y_m,
                                                   Cursor& cursor) const noexcept {
  return z_of(locate_far(x_m, y_m, cursor));
}

// The usual case after a jump, short so that the processor sees the next query while it waits for
// the memory of this one.
[[gnu::noinline]] double Surface::Data::z_far(double x_m, double y_m,
                                              Cursor& cursor) const noexcept {
  if (!is_new(cursor) || !heights.simple()) return z_anywhere(x_m, y_m, cursor);
  const CoarseIndex::Guess guess = locator.guess(x_m, y_m);
  if (guess.segment == CoarseIndex::kNone) return z_anywhere(x_m, y_m, cursor);
  heights.prefetch_cell(guess.segment, static_cast<double>(guess.v_m));
  Place place;
  if (!locator.locate_on(guess.segment, x_m, y_m, place)) return z_anywhere(x_m, y_m, cursor);
  const double z =
      heights.z_simple(heights.place_simple(place.segment, place.fraction, place.v_m), place.v_m);
  if (std::isnan(z)) return z_anywhere(x_m, y_m, cursor);
  cursor =
      cursor_at(static_cast<double>(static_cast<std::ptrdiff_t>(place.segment)) + place.fraction);
  return z;
}

[[gnu::noinline]] Sample Surface::Data::sample_far(double x_m, double y_m,
                                                   Cursor& cursor) const noexcept {
  const bool back = leads_back(cursor);
  Place place;
  if (!locator.locate_ahead(x_m, y_m, cursor, place)) place = locate_far(x_m, y_m, cursor);
  heights.prefetch(back, heights.node(place.segment, 0) + heights.column_near(place.v_m));
  return sample(place, x_m, y_m);
}

double Surface::Data::friction_of(const Place& place) const noexcept {
  if (friction.empty()) return friction_constant;
  const GridPlace p = heights.place(place.segment, place.fraction,
                                    std::clamp(place.v_m, heights.v_right_m(), heights.v_left_m()));
  const float* low = friction.data() + p.row * heights.columns() + p.column;
  const float* high = low + heights.columns();
  const double a = low[0] + p.fv * (static_cast<double>(low[1]) - low[0]);
  const double b = high[0] + p.fv * (static_cast<double>(high[1]) - high[0]);
  const double value = a + p.fu * (b - a);
  return std::isnan(value) ? friction_constant : value;
}

Place Surface::Data::place_of(double u_m, double v_m) const noexcept {
  const double u = heights.wrap_u(u_m);
  const double rows = (u - line.u_begin_m) / line.u_step_m;
  const double last = static_cast<double>(locator.segments());
  Place place;
  place.segment = static_cast<std::size_t>(std::clamp(rows, 0.0, last - 1.0));
  place.fraction = std::clamp(rows - static_cast<double>(place.segment), 0.0, 1.0);
  place.v_m = v_m;
  if (rows < 0.0) place.beyond_m = u - line.u_begin_m;
  if (rows > last) place.beyond_m = u - heights.u_end_m();
  return place;
}

inline Heading Surface::Data::direction(const Place& place) const noexcept {
  double heading_rad = headings.of_segment_rad(place.segment);
  double curvature_1pm = curvatures_1pm[place.segment];
  if (place.beyond_m < 0.0) [[unlikely]] {
    heading_rad = headings.of_row_rad.front();
    curvature_1pm = 0.0;
  }
  if (!curvature_of_reference_line) curvature_1pm /= 1.0 - curvature_1pm * place.v_m;
  return {heading_rad, curvature_1pm};
}

[[gnu::noinline]] Sample Surface::Data::sample(const Place& place, double x_m,
                                               double y_m) const noexcept {
  const bool inside = on_grid(place);
  Height height{Sample::kNaN, Sample::kNaN, Sample::kNaN};
  if (inside && heights.simple()) {
    height = heights.at_simple(heights.place_simple(place.segment, place.fraction, place.v_m),
                               place.v_m);
  }
  if (std::isnan(height.z_m)) {
    height = inside && heights.plain() ? heights.on_grid(place.segment, place.fraction, place.v_m)
                                       : heights.at(u_of(place), place.v_m);
    if (std::isnan(height.z_m)) {
      const auto [heading_rad, curvature_1pm] = direction(place);
      return {.inside = inside,
              .u_m = u_of(place),
              .v_m = place.v_m,
              .x_m = x_m,
              .y_m = y_m,
              .heading_rad = heading_rad,
              .curvature_1pm = curvature_1pm};
    }
  }
  // Along the segment, u advances by a step over the width of the cell at v. Where lateral cuts
  // meet there is no gradient along the line.
  const double width = locator.records()[place.segment].frame.width(place.v_m);
  const double u_per_metre = place.beyond_m != 0.0             ? 1.0
                             : std::abs(width) < least_width_m ? 0.0
                                                               : line.u_step_m / width;
  return answer(place, height, inside, x_m, y_m, u_per_metre,
                friction.empty() ? friction_constant : friction_of(place));
}

// The same where Locator::locate_ahead() found the place: on the grid, nothing beyond an end.
[[gnu::always_inline]] inline Sample Surface::Data::sample_ahead(const Place& place, double x_m,
                                                                 double y_m,
                                                                 bool back) const noexcept {
  const GridPlace cell = heights.place_simple(place.segment, place.fraction, place.v_m);
  heights.prefetch(back, heights.node(cell.row, cell.column));
  const Height height = heights.at_simple(cell, place.v_m);
  const double width = locator.records()[place.segment].frame.width(place.v_m);
  // Positive, so that the bits have the order of the numbers.
  if (std::isnan(height.z_m) || std::bit_cast<std::int64_t>(width) <
                                    std::bit_cast<std::int64_t>(least_width_m)) [[unlikely]] {
    const Place copy = place;  // its address leads out, so that of `place` need not
    return sample(copy, x_m, y_m);
  }
  return answer({place.segment, place.fraction, place.v_m, 0.0}, height, true, x_m, y_m,
                line.u_step_m / width, friction_constant);
}

// What is known of a place whose height is.
[[gnu::always_inline]] inline Sample Surface::Data::answer(const Place& place, const Height& height,
                                                           bool inside, double x_m, double y_m,
                                                           double u_per_metre,
                                                           double friction_there) const noexcept {
  const auto [heading_rad, curvature_1pm] = direction(place);
  const Two slope = gradient(place, height, u_per_metre);
  const Two squares = slope * slope;
  const double normal_z = 1.0 / std::sqrt(1.0 + squares[0] + squares[1]);
  const Two normal = slope * both(-normal_z);
  return {.valid = true,
          .inside = inside,
          .u_m = u_of(place),
          .v_m = place.v_m,
          .x_m = x_m,
          .y_m = y_m,
          .z_m = height.z_m,
          .dzdx = slope[0],
          .dzdy = slope[1],
          .heading_rad = heading_rad,
          .curvature_1pm = curvature_1pm,
          .normal_x = normal[0],
          .normal_y = normal[1],
          .normal_z = normal_z,
          .friction = friction_there};
}

Surface::Surface(Crg crg, SurfaceOptions options) {
  const std::string source = crg.source;
  data_ = naming(source, [&] { return std::make_unique<const Data>(std::move(crg), options); });
}
Surface::~Surface() = default;
Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;

double Surface::z_at_uv(double u_m, double v_m) const noexcept {
  const HeightField& heights = data_->heights;
  if (const double z = heights.z_at_simple(u_m, v_m); !std::isnan(z)) [[likely]]
    return z;
  return heights.at(u_m, v_m).z_m;
}

Point2 Surface::xy_of_uv(double u_m, double v_m) const noexcept {
  if (!std::isfinite(u_m) || !std::isfinite(v_m)) return {Sample::kNaN, Sample::kNaN};
  const Place place = data_->place_of(u_m, v_m);
  const SegmentFrame& frame = data_->locator.records()[place.segment].frame;
  return frame.point(frame.along(place.fraction, v_m) + place.beyond_m, v_m);
}

UV Surface::uv_of_xy(double x_m, double y_m, Cursor& cursor) const noexcept {
  const bool back = leads_back(cursor);
  const Place place = data_->locator.locate(x_m, y_m, cursor);
  data_->heights.prefetch(back, data_->heights.node(place.segment, 0));
  return {data_->u_of(place), place.v_m};
}

double Surface::z_at_xy(double x_m, double y_m, Cursor& cursor) const noexcept {
  const Data& data = *data_;
  const bool back = leads_back(cursor);
  Place place;
  if (data.heights.simple() && data.locator.locate_ahead(x_m, y_m, cursor, place)) [[likely]] {
    const GridPlace p = data.heights.place_simple(place.segment, place.fraction, place.v_m);
    data.heights.prefetch(back, data.heights.node(p.row, p.column));
    const double z = data.heights.z_simple(p, place.v_m);
    if (!std::isnan(z)) [[likely]]
      return z;
  }
  return data.z_far(x_m, y_m, cursor);
}

[[gnu::always_inline]] inline Sample Surface::Data::at(double x_m, double y_m,
                                                       Cursor& cursor) const noexcept {
  const bool back = leads_back(cursor);
  Place place;
  if (quick && locator.locate_ahead(x_m, y_m, cursor, place)) [[likely]]
    return sample_ahead(place, x_m, y_m, back);
  return sample_far(x_m, y_m, cursor);
}

Sample Surface::at_xy(double x_m, double y_m, Cursor& cursor) const noexcept {
  return data_->at(x_m, y_m, cursor);
}

template <typename PointAt>
void Surface::Data::many(std::size_t count, const PointAt& point_at, Sample* out,
                         Cursor& cursor) const noexcept {
  const auto ahead = [&](const Point2& p, Cursor& near, Sample& sample) {
    const bool back = leads_back(near);
    Place place;
    if (!quick || !locator.locate_ahead(p.x_m, p.y_m, near, place)) return false;
    // Made where it belongs: copied, its parts would have to reach memory first.
    ::new (&sample) Sample(sample_ahead(place, p.x_m, p.y_m, back));
    return true;
  };
  for_each_place(locator, heights, count, point_at, out, cursor, ahead,
                 [&](const Point2& p, Cursor& near) { return at(p.x_m, p.y_m, near); });
}

template <typename PointAt>
void Surface::Data::many(std::size_t count, const PointAt& point_at, double* z_m,
                         Cursor& cursor) const noexcept {
  const auto ahead = [&](const Point2& p, Cursor& near, double& z) {
    const bool back = leads_back(near);
    Place place;
    if (!locator.locate_ahead(p.x_m, p.y_m, near, place)) return false;
    if (!heights.simple()) return z = z_of(place), true;
    const GridPlace cell = heights.place_simple(place.segment, place.fraction, place.v_m);
    heights.prefetch(back, heights.node(cell.row, cell.column));
    z = heights.z_simple(cell, place.v_m);
    if (std::isnan(z)) [[unlikely]]
      z = z_of(place);
    return true;
  };
  for_each_place(locator, heights, count, point_at, z_m, cursor, ahead,
                 [&](const Point2& p, Cursor& near) {
                   const Place place = locator.locate(p.x_m, p.y_m, near);
                   return z_of(place);
                 });
}

void Surface::at_xy(std::span<const Point2> points, std::span<Sample> out,
                    Cursor& cursor) const noexcept {
  data_->many(std::min(points.size(), out.size()), in_pairs(points), out.data(), cursor);
}
void Surface::at_xy(std::span<const double> x_m, std::span<const double> y_m, std::span<Sample> out,
                    Cursor& cursor) const noexcept {
  data_->many(std::min({x_m.size(), y_m.size(), out.size()}), apart(x_m, y_m), out.data(), cursor);
}
void Surface::z_at_xy(std::span<const Point2> points, std::span<double> z_m,
                      Cursor& cursor) const noexcept {
  data_->many(std::min(points.size(), z_m.size()), in_pairs(points), z_m.data(), cursor);
}
void Surface::z_at_xy(std::span<const double> x_m, std::span<const double> y_m,
                      std::span<double> z_m, Cursor& cursor) const noexcept {
  data_->many(std::min({x_m.size(), y_m.size(), z_m.size()}), apart(x_m, y_m), z_m.data(), cursor);
}

void Surface::z_at_xy(std::span<const Point2> points, std::span<Cursor> cursors,
                      std::span<double> z_m) const noexcept {
  const std::size_t count = std::min({points.size(), cursors.size(), z_m.size()});
  std::size_t k = 0;
  while (k < count) {
    if (data_->fours && k + 4 <= count &&
        z_of_four_wheels(data_->locator, data_->heights, &points[k], &cursors[k], &z_m[k])) {
      k += 4;
      continue;
    }
    for (const std::size_t end = std::min(k + 4, count); k < end; ++k)
      z_m[k] = z_at_xy(points[k].x_m, points[k].y_m, cursors[k]);
  }
}

double Surface::strip(const Strip& strip, std::span<float> dz_m, Cursor& cursor) const noexcept {
  const std::size_t rows =
      strip.across == 0 ? 0 : std::min(strip.along, dz_m.size() / strip.across);
  return this->strip(
      strip, {0, rows},
      [rows](double, float, float) {
        return StripRows{0, rows};
      },
      dz_m, cursor);
}

double Surface::strip(const Strip& strip, StripRows first, const MoreRows& more,
                      std::span<float> dz_m, Cursor& cursor) const noexcept {
  if (!std::isfinite(strip.x_m) || !std::isfinite(strip.y_m) || !std::isfinite(strip.ahead.x_m) ||
      !std::isfinite(strip.ahead.y_m) || !std::isfinite(strip.step_m)) {
    std::fill(dz_m.begin(), dz_m.end(), std::numeric_limits<float>::quiet_NaN());
    return Sample::kNaN;
  }
  const bool back = leads_back(cursor);
  const Place middle = data_->locator.locate(strip.x_m, strip.y_m, cursor);
  data_->heights.prefetch(
      back, data_->heights.node(middle.segment, 0) + data_->heights.column_near(middle.v_m));
  const LineNode* line = data_->heights.line() + middle.segment;
  const double base = line[0].z_m + middle.fraction * (line[1].z_m - line[0].z_m);
  StripFiller filler(data_->locator, data_->heights, strip, middle, base, dz_m);
  filler.fill(first, more, cursor, [&](double x, double y, Cursor& near) {
    return data_->z_of(data_->locator.locate(x, y, near));
  });
  return base;
}

Sample Surface::at_uv(double u_m, double v_m) const noexcept {
  if (!std::isfinite(u_m) || !std::isfinite(v_m)) return {};
  const Place place = data_->place_of(u_m, v_m);
  const Point2 point = xy_of_uv(u_m, v_m);
  Sample sample = data_->sample(place, point.x_m, point.y_m);
  sample.u_m = u_m;
  return sample;
}

Heading Surface::heading_at_uv(double u_m, double v_m) const noexcept {
  if (!std::isfinite(u_m) || !std::isfinite(v_m)) return {};
  return data_->direction(data_->place_of(u_m, v_m));
}

const Crg& Surface::file() const { return data_->whole_file(); }
const ReferenceLine& Surface::reference_line() const { return data_->whole_line(); }
const Grid& Surface::grid() const noexcept { return data_->file.grid; }
bool Surface::closed() const noexcept { return data_->line.closed; }

}  // namespace crg
