#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "crg/error.h"
#include "crg/options.h"
#include "height.h"
#include "text.h"

namespace crg {
namespace {

// The modifier, bounded; empty when the file does not give it.
std::optional<double> modifier(const Crg& crg, const char* key, double low, double high) {
  const std::optional<double> value = find_value(crg.modifiers, key);
  if (value && !(*value >= low && *value <= high)) {
    throw Error(std::string("$ROAD_CRG_MODS ") + key + " = " + shortest(*value) + ": want " +
                shortest(low) + " to " + shortest(high));
  }
  return value;
}

void scale(std::vector<double>& values, double factor) {
  for (double& value : values) value *= factor;
}

void scale_key(std::vector<HeaderEntry>& entries, const char* key, double factor) {
  if (const auto value = find_value(entries, key)) set_value(entries, key, *value * factor);
}

void scale_heights(Crg& crg) {
  if (const auto factor = modifier(crg, "SCALE_Z_GRID", -1e6, 1e6)) {
    for (float& z : crg.grid.z_m) z = static_cast<float>(z * *factor);
    scale(crg.z_double_m, *factor);
  }
  if (const auto factor = modifier(crg, "SCALE_SLOPE", -1e6, 1e6)) {
    scale(crg.slope, *factor);
    scale_key(crg.road, "REFERENCE_LINE_START_S", *factor);
    scale_key(crg.road, "REFERENCE_LINE_END_S", *factor);
    erase_key(crg.road, "REFERENCE_LINE_END_Z");
  }
  if (const auto factor = modifier(crg, "SCALE_BANKING", -1e6, 1e6)) {
    scale(crg.banking, *factor);
    scale_key(crg.road, "REFERENCE_LINE_START_B", *factor);
    scale_key(crg.road, "REFERENCE_LINE_END_B", *factor);
  }
}

// Headings as a continuous function along u: steps between rows stay within half a turn.
std::vector<double> unwrapped(std::vector<double> heading_rad) {
  for (std::size_t i = 1; i < heading_rad.size(); ++i) {
    heading_rad[i] = heading_rad[i - 1] +
                     std::remainder(heading_rad[i] - heading_rad[i - 1], 2.0 * std::numbers::pi);
  }
  return heading_rad;
}

void drop_end_position(Crg& crg) {
  erase_key(crg.road, "REFERENCE_LINE_END_X");
  erase_key(crg.road, "REFERENCE_LINE_END_Y");
}

// Node channels would contradict a changed line; headings take their place.
void use_headings(Crg& crg) {
  if (crg.x_m.empty() || crg.y_m.empty()) return;
  const ReferenceLine line = integrate_reference_line(crg);
  crg.heading_rad = line.heading_rad;
  set_value(crg.road, "REFERENCE_LINE_START_X", line.x_m.front());
  set_value(crg.road, "REFERENCE_LINE_START_Y", line.y_m.front());
  set_value(crg.road, "REFERENCE_LINE_START_PHI", line.heading_rad.front());
  crg.x_m.clear();
  crg.y_m.clear();
}

void scale_line(Crg& crg) {
  if (const auto factor = modifier(crg, "SCALE_LENGTH", 1e-6, 1e6)) {
    use_headings(crg);
    crg.grid.u_begin_m *= *factor;
    crg.grid.u_step_m *= *factor;
    scale(crg.u_m, *factor);
    for (const char* key :
         {"REFERENCE_LINE_START_U", "REFERENCE_LINE_END_U", "REFERENCE_LINE_INCREMENT"}) {
      scale_key(crg.road, key, *factor);
    }
    drop_end_position(crg);
    erase_key(crg.road, "REFERENCE_LINE_END_Z");
  }
  if (const auto factor = modifier(crg, "SCALE_WIDTH", 1e-6, 1e6)) {
    scale(crg.grid.v_m, *factor);
    for (const char* key :
         {"LONG_SECTION_V_RIGHT", "LONG_SECTION_V_LEFT", "LONG_SECTION_V_INCREMENT"}) {
      scale_key(crg.road, key, *factor);
    }
  }
  if (const auto factor = modifier(crg, "SCALE_CURVATURE", -1e6, 1e6)) {
    use_headings(crg);
    drop_end_position(crg);
    if (crg.heading_rad.empty()) return;
    std::vector<double> heading = crg.heading_rad;
    heading[0] = find_value(crg.road, "REFERENCE_LINE_START_PHI").value_or(heading[1]);
    heading = unwrapped(std::move(heading));
    const double start = heading[0];
    for (double& value : heading) value = start + *factor * (value - start);
    crg.heading_rad = std::move(heading);
    set_value(crg.road, "REFERENCE_LINE_END_PHI", crg.heading_rad.back());
  }
}

// Fills the NaN at both ends of a row; holes inside the road stay.
template <typename Value>
void fill_row(Value* row, std::size_t columns, int mode, Value offset) {
  std::size_t first = 0;
  while (first < columns && std::isnan(row[first])) ++first;
  std::size_t last = columns;
  while (last > first && std::isnan(row[last - 1])) --last;
  if (first == columns && mode == 2) return;  // nothing to keep
  const Value right = mode == 1 ? offset : row[first] + offset;
  const Value left = mode == 1 ? offset : row[last - 1] + offset;
  std::fill(row, row + first, right);
  std::fill(row + last, row + columns, left);
}

void fill_nan(Crg& crg) {
  const auto mode = modifier(crg, "GRID_NAN_MODE", 0.0, 2.0);
  const double offset = modifier(crg, "GRID_NAN_OFFSET", -1e9, 1e9).value_or(0.0);
  if (!mode || *mode < 1.0) return;
  if (*mode != std::floor(*mode))
    throw Error("$ROAD_CRG_MODS GRID_NAN_MODE = " + shortest(*mode) + ": want 0, 1 or 2");
  const std::size_t columns = crg.grid.columns();
  for (std::size_t row = 0; row < crg.grid.rows(); ++row) {
    fill_row(crg.grid.z_m.data() + row * columns, columns, static_cast<int>(*mode),
             static_cast<float>(offset));
    if (!crg.z_double_m.empty()) {
      fill_row(crg.z_double_m.data() + row * columns, columns, static_cast<int>(*mode), offset);
    }
  }
}

// A rigid motion: rotation about (x, y), then translation.
struct Motion {
  double rotation_rad = 0.0;
  Point2 about;
  Point2 shift;
  double shift_z_m = 0.0;
};

void move(Crg& crg, const Motion& motion) {
  const double cos = std::cos(motion.rotation_rad), sin = std::sin(motion.rotation_rad);
  const auto turned = [&](double x, double y) {
    const double dx = x - motion.about.x_m, dy = y - motion.about.y_m;
    return Point2{motion.about.x_m + cos * dx - sin * dy + motion.shift.x_m,
                  motion.about.y_m + sin * dx + cos * dy + motion.shift.y_m};
  };
  const auto turn_keys = [&](const char* x_key, const char* y_key, bool add) {
    const auto x = find_value(crg.road, x_key), y = find_value(crg.road, y_key);
    if (!add && (!x || !y)) return;
    const Point2 point = turned(x.value_or(0.0), y.value_or(0.0));
    set_value(crg.road, x_key, point.x_m);
    set_value(crg.road, y_key, point.y_m);
  };
  turn_keys("REFERENCE_LINE_START_X", "REFERENCE_LINE_START_Y", true);
  turn_keys("REFERENCE_LINE_END_X", "REFERENCE_LINE_END_Y", false);
  for (std::size_t i = 0; i < std::min(crg.x_m.size(), crg.y_m.size()); ++i) {
    const Point2 point = turned(crg.x_m[i], crg.y_m[i]);
    crg.x_m[i] = point.x_m;
    crg.y_m[i] = point.y_m;
  }
  for (double& heading : crg.heading_rad) heading += motion.rotation_rad;
  const auto start_heading = find_value(crg.road, "REFERENCE_LINE_START_PHI");
  if (start_heading || crg.heading_rad.empty()) {
    set_value(crg.road, "REFERENCE_LINE_START_PHI",
              start_heading.value_or(0.0) + motion.rotation_rad);
  }
  if (const auto heading = find_value(crg.road, "REFERENCE_LINE_END_PHI")) {
    set_value(crg.road, "REFERENCE_LINE_END_PHI", *heading + motion.rotation_rad);
  }
  if (motion.shift_z_m != 0.0) {
    set_value(crg.road, "REFERENCE_LINE_START_Z",
              find_value(crg.road, "REFERENCE_LINE_START_Z").value_or(0.0) + motion.shift_z_m);
    if (const auto z = find_value(crg.road, "REFERENCE_LINE_END_Z")) {
      set_value(crg.road, "REFERENCE_LINE_END_Z", *z + motion.shift_z_m);
    }
  }
}

bool any_reference_point(const Crg& crg) {
  return std::any_of(crg.modifiers.begin(), crg.modifiers.end(),
                     [](const HeaderEntry& entry) { return entry.key.starts_with("REFPOINT_"); });
}

Motion by_reference_point(const Crg& crg) {
  constexpr double kFar = 1e12;
  const ReferenceLine line = integrate_reference_line(crg);
  Options keep;
  keep.close_track = line.closed;
  const HeightField heights(crg.grid, line, keep);
  const double length = heights.u_end_m() - line.u_begin_m;
  const double width = heights.v_left_m() - heights.v_right_m();
  const auto value = [&](const char* key) { return modifier(crg, key, -kFar, kFar); };
  const double u_m =
      value("REFPOINT_U")
          .value_or(line.u_begin_m + value("REFPOINT_U_FRACTION").value_or(0.0) * length) +
      value("REFPOINT_U_OFFSET").value_or(0.0);
  const double v_m =
      value("REFPOINT_V")
          .value_or(heights.v_right_m() + value("REFPOINT_V_FRACTION").value_or(0.0) * width) +
      value("REFPOINT_V_OFFSET").value_or(0.0);
  const double rows =
      std::clamp((u_m - line.u_begin_m) / line.u_step_m, 0.0, static_cast<double>(line.size() - 2));
  const double heading = line.heading_rad[static_cast<std::size_t>(rows) + 1];
  const Point2 here = position(line, u_m, v_m);
  const double z = heights.at(u_m, v_m).z_m;
  Motion motion;
  motion.rotation_rad = value("REFPOINT_PHI").value_or(0.0) - heading;
  motion.about = here;
  motion.shift = {value("REFPOINT_X").value_or(0.0) - here.x_m,
                  value("REFPOINT_Y").value_or(0.0) - here.y_m};
  motion.shift_z_m = value("REFPOINT_Z").value_or(0.0) - (std::isnan(z) ? 0.0 : z);
  return motion;
}

Motion by_offsets(const Crg& crg) {
  constexpr double kFar = 1e12;
  const auto value = [&](const char* key, double otherwise) {
    return modifier(crg, key, -kFar, kFar).value_or(otherwise);
  };
  Motion motion;
  motion.rotation_rad = value("REFLINE_OFFSET_PHI", 0.0);
  motion.about = {
      value("REFLINE_ROTCENTER_X", find_value(crg.road, "REFERENCE_LINE_START_X").value_or(0.0)),
      value("REFLINE_ROTCENTER_Y", find_value(crg.road, "REFERENCE_LINE_START_Y").value_or(0.0))};
  motion.shift = {value("REFLINE_OFFSET_X", 0.0), value("REFLINE_OFFSET_Y", 0.0)};
  motion.shift_z_m = value("REFLINE_OFFSET_Z", 0.0);
  return motion;
}

}  // namespace

std::vector<HeaderEntry> reference_default_modifiers(const Crg& crg) {
  std::vector<HeaderEntry> modifiers;
  // The reference takes the right edge from the header and not from the channels.
  if (!find_value(crg.road, "LONG_SECTION_V_RIGHT")) modifiers.push_back({.key = "REFPOINT_V"});
  for (const char* key : {"REFPOINT_U_FRACTION", "REFPOINT_V_FRACTION", "REFPOINT_X", "REFPOINT_Y",
                          "REFPOINT_Z", "REFPOINT_PHI"}) {
    modifiers.push_back({.key = key});
  }
  modifiers.push_back({.key = "GRID_NAN_MODE", .value = 2.0});
  return modifiers;
}

Crg apply_modifiers(Crg crg) {
  const bool any = std::any_of(crg.modifiers.begin(), crg.modifiers.end(),
                               [](const HeaderEntry& entry) { return entry.key != "*"; });
  if (!any) return crg;
  scale_heights(crg);
  scale_line(crg);
  fill_nan(crg);
  move(crg, any_reference_point(crg) ? by_reference_point(crg) : by_offsets(crg));
  crg.modifiers.clear();
  crg.has_modifier_section = true;
  return crg;
}

}  // namespace crg
