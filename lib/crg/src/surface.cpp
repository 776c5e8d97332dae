#include "crg/surface.h"

#include <algorithm>
#include <cmath>

#include "height.h"
#include "locator.h"

namespace crg {
namespace {

Crg with_modifiers(Crg crg, ModifierUse use) {
  if (use == ModifierUse::None) {
    crg.modifiers.clear();
    return crg;
  }
  if (use == ModifierUse::ReferenceDefaults && !crg.has_modifier_section) {
    crg.modifiers = reference_default_modifiers(crg);
  }
  return apply_modifiers(std::move(crg));
}

}  // namespace

struct Surface::Data {
  Data(Crg crg, const SurfaceOptions& options)
      : file(with_modifiers(std::move(crg), options.modifiers)),
        line(integrate_reference_line(file)),
        heights(file.grid, line, options_of(file)),
        locator(line, heights.v_right_m(), heights.v_left_m()),
        curvature_of_reference_line(options.curvature_of_reference_line),
        half_chord(static_cast<std::size_t>(std::clamp(std::round(0.5 / line.u_step_m), 1.0, 1e9))) {
    // A track shorter than its chords has no curvature to speak of.
    joined = ends_joined(line) && 2 * half_chord < line.size();
  }

  void set_direction(const Place& place, Sample& sample) const noexcept;
  Sample sample(const Place& place) const noexcept;
  Place place_of(double u_m, double v_m) const noexcept;
  double u_of(const Place& place) const noexcept {
    return line.u_begin_m + (static_cast<double>(place.segment) + place.fraction) * line.u_step_m + place.beyond_m;
  }

  Crg file;
  ReferenceLine line;
  HeightField heights;
  Locator locator;
  bool curvature_of_reference_line;
  bool joined;             ///< a closed track whose last row repeats the first
  std::size_t half_chord;  ///< rows
};

// Curvature from the cross product of the two chords that meet in the segment's first node, each
// half a metre or one row long. Nearer than that to an open end the reference implementation answers
// the heading of that end and no curvature, and so do we.
void Surface::Data::set_direction(const Place& place, Sample& sample) const noexcept {
  const std::size_t last = line.size() - 1;
  std::size_t i = place.segment, before, after;
  if (joined) {
    before = i >= half_chord ? i - half_chord : i + last - half_chord;
    after = i + half_chord <= last ? i + half_chord : i + half_chord - last;
    sample.heading_rad = line.heading_rad[i + 1];
  } else if (place.beyond_m < 0.0 || i < half_chord) {
    sample.heading_rad = line.heading_rad.front();
    sample.curvature_1pm = 0.0;
    return;
  } else if (i + half_chord > last) {
    sample.heading_rad = line.heading_rad.back();
    sample.curvature_1pm = 0.0;
    return;
  } else {
    before = i - half_chord;
    after = i + half_chord;
    sample.heading_rad = line.heading_rad[i + 1];
  }
  const double x1 = line.x_m[i] - line.x_m[before], y1 = line.y_m[i] - line.y_m[before];
  const double x2 = line.x_m[after] - line.x_m[i], y2 = line.y_m[after] - line.y_m[i];
  const double chord = static_cast<double>(half_chord) * line.u_step_m;
  const double curvature = (x1 * y2 - y1 * x2) / (chord * chord * chord);
  sample.curvature_1pm = curvature_of_reference_line ? curvature : curvature / (1.0 - curvature * place.v_m);
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

Sample Surface::Data::sample(const Place& place) const noexcept {
  const SegmentFrame& frame = locator.records()[place.segment].frame;
  const bool on_line = place.beyond_m == 0.0;
  Sample sample;
  sample.u_m = u_of(place);
  sample.v_m = place.v_m;
  const Point2 point = frame.point(frame.along(place.fraction, place.v_m) + place.beyond_m, place.v_m);
  sample.x_m = point.x_m;
  sample.y_m = point.y_m;
  set_direction(place, sample);
  sample.inside = on_line && place.v_m >= heights.v_right_m() && place.v_m <= heights.v_left_m();
  const Height height = heights.at(sample.u_m, sample.v_m);
  if (std::isnan(height.z_m)) return sample;
  sample.valid = true;
  sample.z_m = height.z_m;
  // Along the segment, u advances by a step over the width of the cell at v; along the mitre line
  // both v and the place along the segment change.
  const double lean = frame.begin_lean + place.fraction * (frame.end_lean - frame.begin_lean);
  const double along = height.dzdu * (on_line ? line.u_step_m / frame.width(place.v_m) : 1.0);
  const double across = height.dzdv - lean * along;
  sample.dzdx = along * frame.cos - across * frame.sin;
  sample.dzdy = along * frame.sin + across * frame.cos;
  const double scale = 1.0 / std::sqrt(1.0 + sample.dzdx * sample.dzdx + sample.dzdy * sample.dzdy);
  sample.normal_x = -sample.dzdx * scale;
  sample.normal_y = -sample.dzdy * scale;
  sample.normal_z = scale;
  return sample;
}

Surface::Surface(Crg crg, const SurfaceOptions& options) : data_(std::make_unique<const Data>(std::move(crg), options)) {}
Surface::~Surface() = default;
Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;

double Surface::z_at_uv(double u_m, double v_m) const noexcept { return data_->heights.at(u_m, v_m).z_m; }

Point2 Surface::xy_of_uv(double u_m, double v_m) const noexcept {
  if (!std::isfinite(u_m) || !std::isfinite(v_m)) return {Sample::kNaN, Sample::kNaN};
  const Place place = data_->place_of(u_m, v_m);
  const SegmentFrame& frame = data_->locator.records()[place.segment].frame;
  return frame.point(frame.along(place.fraction, v_m) + place.beyond_m, v_m);
}

UV Surface::uv_of_xy(double x_m, double y_m, Cursor& cursor) const noexcept {
  if (!std::isfinite(x_m) || !std::isfinite(y_m)) return {};
  const Place place = data_->locator.locate(x_m, y_m, cursor.segment);
  cursor.segment = place.segment;
  return {data_->u_of(place), place.v_m};
}

Sample Surface::at_xy(double x_m, double y_m, Cursor& cursor) const noexcept {
  if (!std::isfinite(x_m) || !std::isfinite(y_m)) return {};
  const Place place = data_->locator.locate(x_m, y_m, cursor.segment);
  cursor.segment = place.segment;
  Sample sample = data_->sample(place);
  sample.x_m = x_m;
  sample.y_m = y_m;
  return sample;
}

Sample Surface::at_uv(double u_m, double v_m) const noexcept {
  if (!std::isfinite(u_m) || !std::isfinite(v_m)) return {};
  Sample sample = data_->sample(data_->place_of(u_m, v_m));
  sample.u_m = u_m;
  return sample;
}

const Crg& Surface::file() const noexcept { return data_->file; }
const ReferenceLine& Surface::reference_line() const noexcept { return data_->line; }

}  // namespace crg
