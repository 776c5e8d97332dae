// Making the tables of a Surface, and file and line again from them.
#include "surface_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "crg/error.h"

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

std::vector<float> take_friction(const Grid& road, SurfaceOptions& options) {
  if (!options.friction_map) return {};
  want_same_shape(road, options.friction_map->grid);
  return std::move(options.friction_map->grid.z_m);
}

// Also the memory.
template <typename T>
void drop(std::vector<T>& values) {
  std::vector<T>().swap(values);
}

bool is_float(double value) {
  return std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max()) &&
         static_cast<double>(static_cast<float>(value)) == value;
}

}  // namespace

// What a table repeats is dropped before the next one is made: that, too, counts in the peak.
Surface::Data::Data(Crg crg, SurfaceOptions& options)
    : friction_constant(options.friction),
      friction(take_friction(crg.grid, options)),
      file(with_modifiers(std::move(crg), options.modifiers)),
      line(integrate_reference_line(file)),
      heights(file.grid, line, options_of(file), options.interpolation),
      curvature_of_reference_line(options.curvature_of_reference_line),
      least_width_m(1e-9 * line.u_step_m),
      quick(heights.simple() && friction.empty()),
      fours(heights.simple() && four_wheels_available() &&
            file.grid.z_m.size() <= std::numeric_limits<std::int32_t>::max()) {
  spare_channels();
  spare_heights();
  const bool joined = ends_joined(line);
  const Closing closing = closing_of(line);
  std::vector<SegmentRecord> records = segment_records(line);
  headings = headings_of(std::move(line.heading_rad), line.u_step_m, joined);
  locator = Locator(std::move(records), line.u_step_m, heights.v_right_m(), heights.v_left_m(),
                    joined, closing);
  const std::span<const SegmentRecord> nodes(locator.records(), heights.rows());
  curvatures_1pm = curvatures_of(nodes, line.u_step_m, joined);
}

// The line has the headings and banking of the channels, but for the first heading.
void Surface::Data::spare_channels() {
  rest_.has_heading = !file.heading_rad.empty();
  rest_.has_banking = !file.banking.empty();
  if (rest_.has_heading) rest_.heading_rad = file.heading_rad.front();
  drop(file.heading_rad);
  drop(file.banking);
  if (!std::all_of(file.slope.begin(), file.slope.end(), is_float)) return;
  rest_.slope.reserve(file.slope.size());
  for (const double slope : file.slope) rest_.slope.push_back(static_cast<float>(slope));
  drop(file.slope);
}

void Surface::Data::spare_heights() {
  rest_.line_has_z = !line.z_m.empty();
  rest_.line_has_banking = !line.banking.empty();
  drop(line.z_m);
  drop(line.banking);
}

std::vector<double> Surface::Data::bankings() const {
  std::vector<double> out(heights.rows());
  for (std::size_t row = 0; row < out.size(); ++row) out[row] = heights.line()[row].banking;
  return out;
}

const Crg& Surface::Data::whole_file() const {
  std::call_once(file_made_, [&] {
    if (rest_.has_heading) {
      file.heading_rad = headings.of_line_rad();
      file.heading_rad.front() = rest_.heading_rad;
    }
    if (!rest_.slope.empty()) file.slope.assign(rest_.slope.begin(), rest_.slope.end());
    if (rest_.has_banking) file.banking = bankings();
  });
  return file;
}

const ReferenceLine& Surface::Data::whole_line() const {
  std::call_once(line_made_, [&] {
    const std::size_t rows = heights.rows();
    line.heading_rad = headings.of_line_rad();
    line.x_m.resize(rows);
    line.y_m.resize(rows);
    for (std::size_t row = 0; row < rows; ++row) {
      line.x_m[row] = locator.records()[row].frame.x_m;
      line.y_m[row] = locator.records()[row].frame.y_m;
    }
    if (rest_.line_has_z) {
      line.z_m.resize(rows);
      for (std::size_t row = 0; row < rows; ++row) line.z_m[row] = heights.line()[row].z_m;
    }
    if (rest_.line_has_banking) line.banking = bankings();
  });
  return line;
}

}  // namespace crg
