// What a file says of its line and heights, against each other.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "checker.h"
#include "closing.h"
#include "header.h"
#include "line_geometry.h"
#include "text.h"

namespace crg {

// END_X, END_Y, END_Z against where headings and slopes lead, and the turns on the way.
void Checker::check_line() {
  Crg forward = {};
  forward.road = crg_.road;
  forward.heading_rad = crg_.heading_rad;
  forward.slope = crg_.slope;
  forward.grid.u_begin_m = crg_.grid.u_begin_m;
  forward.grid.u_step_m = crg_.grid.u_step_m;
  forward.grid.v_m = {0.0};
  forward.grid.z_m.resize(crg_.grid.rows());
  for (const char* key : {"REFERENCE_LINE_END_X", "REFERENCE_LINE_END_Y", "REFERENCE_LINE_END_Z"})
    erase_key(forward.road, key);
  const ReferenceLine reached = integrate_reference_line(forward);
  const double rows = static_cast<double>(line_.size());
  // A float heading is off by 1.2e-7 of its size at most, in every row.
  const double drift = options_.check_tolerance_m + rows * line_.u_step_m * 1.2e-7;
  if (crg_.x_m.empty() || crg_.y_m.empty()) {
    compare("REFERENCE_LINE_END_X", reached.x_m.back(), drift, "the end that the headings lead to");
    compare("REFERENCE_LINE_END_Y", reached.y_m.back(), drift, "the end that the headings lead to");
  } else if (!crg_.heading_rad.empty()) {
    double worst = 0.0;
    std::size_t at = 0;
    for (std::size_t i = 0; i < line_.size(); ++i) {
      const double distance =
          std::hypot(reached.x_m[i] - line_.x_m[i] + line_.x_m[0] - reached.x_m[0],
                     reached.y_m[i] - line_.y_m[i] + line_.y_m[0] - reached.y_m[0]);
      if (distance > worst) worst = distance, at = i;
    }
    if (worst > drift)
      add(Severity::Warning, "line.channels",
          "x and y channels are up to " + shortest(worst) + " m off what phi integrates to", at);
  }
  if (!crg_.slope.empty() && !reached.z_m.empty())
    compare("REFERENCE_LINE_END_Z", reached.z_m.back(), drift, "the end that the slopes lead to");

  std::size_t sharp = 0, first = 0;
  for (std::size_t i = 2; i < line_.size(); ++i) {
    const double turn = std::abs(
        std::remainder(line_.heading_rad[i] - line_.heading_rad[i - 1], 2.0 * std::numbers::pi));
    if (turn > std::numbers::pi / 4.0 && sharp++ == 0) first = i;
  }
  if (sharp > 0)
    add(Severity::Warning, "line.turn", "the line turns by more than 45 degrees between two rows",
        first, sharp);
  std::size_t uneven = 0;
  for (std::size_t i = 1; i < line_.size(); ++i) {
    const double length =
        std::hypot(line_.x_m[i] - line_.x_m[i - 1], line_.y_m[i] - line_.y_m[i - 1]);
    if (std::abs(length - line_.u_step_m) >
            std::max(options_.check_tolerance_m, 0.01 * line_.u_step_m) &&
        uneven++ == 0)
      first = i;
  }
  if (uneven > 0)
    add(Severity::Warning, "line.step",
        "nodes of the line are not one increment apart; END_X/END_Y or the x, y channels pull it",
        first, uneven);
}

// Lateral cuts of neighbouring rows must not meet where there are heights, and had better not meet
// within the v range.
void Checker::check_curvature() {
  const Grid& grid = crg_.grid;
  // A file may have its empty nodes filled when it is evaluated; the reference API does so by
  // itself where the section of modifiers is missing.
  const bool filled = !crg_.has_modifier_section ||
                      find_value(crg_.modifiers, "GRID_NAN_MODE").value_or(0.0) != 0.0;
  std::size_t with_heights = 0, empty = 0, first_with_heights = 0, first_empty = 0;
  for (std::size_t i = 0; i + 1 < line_.size(); ++i) {
    const SegmentFrame frame = segment_frame(line_, i);
    const auto folded = [&](double v) { return !(frame.width(v) > 0.0); };
    if (!folded(grid.v_m.front()) && !folded(grid.v_m.back())) continue;
    bool heights = filled;
    for (std::size_t j = 0; j < grid.columns() && !heights; ++j) {
      heights =
          folded(grid.v_m[j]) && !(std::isnan(grid.at(i, j)) && std::isnan(grid.at(i + 1, j)));
    }
    if (heights) {
      if (with_heights++ == 0) first_with_heights = i;
    } else if (empty++ == 0) {
      first_empty = i;
    }
  }
  const std::string meet = "lateral cuts of neighbouring rows meet ";
  if (with_heights > 0) {
    const bool wanted = options_.check_curvature_global || options_.check_curvature_local;
    add(wanted ? Severity::Error : Severity::Warning, "curvature.local",
        meet +
            "where there are heights: points there have two (u, v); reduce the width or the "
            "curvature",
        first_with_heights, with_heights);
  }
  if (empty > 0 && options_.check_curvature_global) {
    add(Severity::Note, "curvature.global",
        meet +
            "inside the v range, where no node has a height; a tool that looks at the v range "
            "alone (WARN_CURV_GLOBAL) remarks it",
        first_empty, empty);
  }
}

void Checker::check_closure() {
  if (!options_.close_track) return;
  const std::optional<Closing> closing = find_closing(line_);
  if (!closing) {
    add(Severity::Error, "closure",
        "REFLINE_CONTINUATION = 1, but the extended ends do not meet: want start and end heading "
        "within 60 degrees and the end before the start");
    return;
  }
  const double gap = closing->after_end_m + closing->before_start_m;
  if (gap == 0.0)
    add(Severity::Note, "closure.gap",
        "the ends meet without a gap; the reference API wants a positive one");
  if (gap > 2.0 * line_.u_step_m)
    add(Severity::Warning, "closure.gap",
        "the ends are " + shortest(gap) + " m apart; heights are not interpolated over that gap");
  const Grid& grid = crg_.grid;
  const std::size_t last = grid.rows() - 1;
  const auto value = [](const std::vector<double>& channel, std::size_t i) {
    return channel.empty() ? 0.0 : channel[i];
  };
  double worst = 0.0;
  for (std::size_t j = 0; j < grid.columns(); ++j) {
    const auto z = [&](std::size_t i) {
      return grid.at(i, j) + value(line_.z_m, i) + value(line_.banking, i) * grid.v_m[j];
    };
    const double step = std::abs(z(last) - z(0));
    if (step > worst) worst = step;
  }
  if (worst > 1e-3 && gap <= 2.0 * line_.u_step_m) {
    add(Severity::Warning, "closure.height",
        "a step of up to " + shortest(worst) + " m in height where the track closes", last);
  }
}

void Checker::check_heights() {
  const Grid& grid = crg_.grid;
  std::size_t empty_rows = 0, holes = 0, missing = 0, first_empty = 0, first_hole = 0;
  for (std::size_t i = 0; i < grid.rows(); ++i) {
    std::size_t first = 0, last = grid.columns();
    while (first < last && std::isnan(grid.at(i, first))) ++first;
    while (last > first && std::isnan(grid.at(i, last - 1))) --last;
    if (first == last) {
      if (empty_rows++ == 0) first_empty = i;
      continue;
    }
    missing += first + grid.columns() - last;
    for (std::size_t j = first; j < last; ++j) {
      if (std::isnan(grid.at(i, j)) && holes++ == 0) first_hole = i;
    }
  }
  if (empty_rows > 0)
    add(Severity::Warning, "nan.row",
        "rows without any height: the standard wants at least one per row", first_empty,
        empty_rows);
  if (holes > 0)
    add(Severity::Warning, "nan.inside",
        "NaN between heights of a row: the standard wants them at the edges only", first_hole,
        holes);
  if (missing > 0)
    add(Severity::Note, "nan.edge", "nodes without height at the edges", {}, missing);
  if (!crg_.z_double_m.empty())
    add(Severity::Note, "heights.double",
        "heights need double precision; the reference API and lib/crg evaluate them as float");
}

}  // namespace crg
