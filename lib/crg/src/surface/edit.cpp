#include "crg/edit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "crg/error.h"
#include "crg/surface.h"
#include "text.h"

namespace crg {
namespace {

// A file for the new line and grid with everything of the old one that still holds.
Crg rebuilt(const Crg& from, const ReferenceLine& line, Grid grid) {
  Crg crg = make_crg(line, std::move(grid), from.comment);
  for (const HeaderEntry& entry : from.road) {
    if (entry.key.starts_with("REFERENCE_LINE_OFFSET_"))
      set_value(crg.road, entry.key, entry.value);
  }
  const auto closed = find_value(crg.options, "REFLINE_CONTINUATION");
  crg.options = from.options;
  erase_key(crg.options, "REFLINE_CONTINUATION");
  if (closed) set_value(crg.options, "REFLINE_CONTINUATION", *closed);
  crg.projection = from.projection;
  crg.other_sections = from.other_sections;
  crg.notes = from.notes;
  crg.source = from.source;
  crg.format = from.format;
  return crg;
}

template <typename Value>
std::vector<Value> part(const std::vector<Value>& values, std::size_t begin, std::size_t end) {
  return values.empty() ? values
                        : std::vector<Value>(values.begin() + static_cast<std::ptrdiff_t>(begin),
                                             values.begin() + static_cast<std::ptrdiff_t>(end));
}

double value_at(const std::vector<double>& channel, double row) {
  if (channel.empty()) return 0.0;
  const std::size_t i = std::min(static_cast<std::size_t>(std::max(row, 0.0)), channel.size() - 2);
  return channel[i] + (row - static_cast<double>(i)) * (channel[i + 1] - channel[i]);
}

// Walks along the line in chords of `step`: rows (fractional, of the old line) of `count` points.
// Stops early at the end of the line.
std::vector<double> walk(const ReferenceLine& line, double step, std::size_t count) {
  std::vector<double> rows = {0.0};
  Point2 here{line.x_m[0], line.y_m[0]};
  std::size_t i = 0;
  while (rows.size() < count) {
    // The first node farther than a step; the wanted point lies before it.
    while (i + 1 < line.size() &&
           std::hypot(line.x_m[i + 1] - here.x_m, line.y_m[i + 1] - here.y_m) < step)
      ++i;
    if (i + 1 >= line.size()) break;
    const double dx = line.x_m[i + 1] - line.x_m[i], dy = line.y_m[i + 1] - line.y_m[i];
    const double fx = line.x_m[i] - here.x_m, fy = line.y_m[i] - here.y_m;
    const double a = dx * dx + dy * dy, b = fx * dx + fy * dy, c = fx * fx + fy * fy - step * step;
    const double t = std::clamp((-b + std::sqrt(std::max(0.0, b * b - a * c))) / a, 0.0, 1.0);
    here = {line.x_m[i] + t * dx, line.y_m[i] + t * dy};
    rows.push_back(static_cast<double>(i) + t);
  }
  return rows;
}

// The step near `wanted` with which a whole number of chords leads from start to end.
double fitting_step(const ReferenceLine& line, double wanted, std::size_t& count) {
  const double length = line.u_step_m * static_cast<double>(line.size() - 1);
  const double steps = std::max(1.0, std::round(length / wanted));
  count = static_cast<std::size_t>(steps) + 1;
  double low = 0.5 * length / steps, high = length / steps * (1.0 + 1e-9);
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    const std::vector<double> rows = walk(line, middle, count);
    const bool reaches = rows.size() == count;
    (reaches ? low : high) = middle;
  }
  return low;
}

ReferenceLine resampled_line(const ReferenceLine& old, double wanted_step_m) {
  if (std::abs(wanted_step_m - old.u_step_m) < 1e-12) return old;
  std::size_t count = 0;
  ReferenceLine line;
  line.u_begin_m = old.u_begin_m;
  line.u_step_m = fitting_step(old, wanted_step_m, count);
  line.closed = old.closed;
  for (const double row : walk(old, line.u_step_m, count)) {
    const std::size_t i = std::min(static_cast<std::size_t>(row), old.size() - 2);
    const double t = row - static_cast<double>(i);
    line.x_m.push_back(old.x_m[i] + t * (old.x_m[i + 1] - old.x_m[i]));
    line.y_m.push_back(old.y_m[i] + t * (old.y_m[i + 1] - old.y_m[i]));
    if (!old.z_m.empty()) line.z_m.push_back(value_at(old.z_m, row));
    if (!old.banking.empty()) line.banking.push_back(value_at(old.banking, row));
  }
  line.heading_rad.assign(line.size(), old.heading_rad[1]);
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double heading = std::atan2(line.y_m[i] - line.y_m[i - 1], line.x_m[i] - line.x_m[i - 1]);
    line.heading_rad[i] = line.heading_rad[i - 1] +
                          std::remainder(heading - line.heading_rad[i - 1], 2.0 * std::numbers::pi);
  }
  line.heading_rad[0] = line.heading_rad[1];
  return line;
}

}  // namespace

Crg crop(Crg crg, const CropOptions& options) {
  crg = apply_modifiers(std::move(crg));
  const ReferenceLine old = integrate_reference_line(crg);
  const Grid& grid = crg.grid;
  constexpr double kTolerance_m = 1e-6;
  const auto low = [](const std::optional<double>& bound, double value) {
    return !bound || value >= *bound - kTolerance_m;
  };
  const auto high = [](const std::optional<double>& bound, double value) {
    return !bound || value <= *bound + kTolerance_m;
  };
  std::size_t row = 0, row_end = grid.rows(), column = 0, column_end = grid.columns();
  // The rows next to the bounds: two roads that are cut at one place share a row.
  const double half_m = 0.5 * grid.u_step_m;
  while (row < row_end && options.u_begin_m && grid.u_of(row) <= *options.u_begin_m - half_m) ++row;
  while (row_end > row && options.u_end_m && grid.u_of(row_end - 1) > *options.u_end_m + half_m)
    --row_end;
  while (column < column_end && !low(options.v_right_m, grid.v_m[column])) ++column;
  while (column_end > column && !high(options.v_left_m, grid.v_m[column_end - 1])) --column_end;
  if (row_end - row < 2 || column_end - column < 2) {
    throw Error(crg.source + ": crop leaves " + std::to_string(row_end - row) + " rows and " +
                std::to_string(column_end - column) +
                " columns: want at least 2 of each; u runs from " + shortest(grid.u_begin_m) +
                " to " + shortest(grid.u_of(grid.rows() - 1)) + " m, v from " +
                shortest(grid.v_m.front()) + " to " + shortest(grid.v_m.back()) + " m");
  }
  ReferenceLine line;
  line.u_begin_m = grid.u_of(row);
  line.u_step_m = old.u_step_m;
  line.x_m = part(old.x_m, row, row_end);
  line.y_m = part(old.y_m, row, row_end);
  line.heading_rad = part(old.heading_rad, row, row_end);
  line.z_m = part(old.z_m, row, row_end);
  line.banking = part(old.banking, row, row_end);
  line.closed = old.closed && row == 0 && row_end == grid.rows();
  Grid cut;
  cut.u_begin_m = line.u_begin_m;
  cut.u_step_m = line.u_step_m;
  cut.v_m = part(grid.v_m, column, column_end);
  for (std::size_t i = row; i < row_end; ++i) {
    const float* z = grid.z_m.data() + i * grid.columns();
    cut.z_m.insert(cut.z_m.end(), z + column, z + column_end);
  }
  return rebuilt(crg, line, std::move(cut));
}

Crg resample(Crg crg, const ResampleOptions& options) {
  for (const std::optional<double>& step : {options.u_step_m, options.v_step_m}) {
    if (step && !(*step >= 1e-4 && *step <= 1e4))
      throw Error(crg.source + ": resample to a step of " + shortest(*step) +
                  " m: want 1e-4 to 1e4 m");
  }
  crg = apply_modifiers(std::move(crg));
  const ReferenceLine old = integrate_reference_line(crg);
  const ReferenceLine line = resampled_line(old, options.u_step_m.value_or(old.u_step_m));
  Grid grid;
  grid.u_begin_m = line.u_begin_m;
  grid.u_step_m = line.u_step_m;
  grid.v_m = crg.grid.v_m;
  if (options.v_step_m) {
    const double right = crg.grid.v_m.front(), width = crg.grid.v_m.back() - right;
    const double steps = std::max(1.0, std::round(width / *options.v_step_m));
    if (steps > 1e6)
      throw Error(crg.source + ": resample to " + shortest(steps) + " columns: want at most 1e6");
    grid.v_m.clear();
    for (std::size_t j = 0; j <= static_cast<std::size_t>(steps); ++j) {
      grid.v_m.push_back(right + width * static_cast<double>(j) / steps);
    }
  }
  if (static_cast<double>(line.size()) * static_cast<double>(grid.v_m.size()) > 4e9) {
    throw Error(crg.source + ": resample to " + std::to_string(line.size()) + " x " +
                std::to_string(grid.v_m.size()) + " nodes: want at most 4e9");
  }
  // Beyond the edges the nearest height holds: new nodes on the edge may lie beyond it by rounding.
  Crg source = crg;
  source.options.clear();
  if (old.closed) set_value(source.options, "REFLINE_CONTINUATION", 1.0);
  const Surface surface(std::move(source));
  Cursor cursor;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double line_z = line.z_m.empty() ? 0.0 : line.z_m[i],
                 banking = line.banking.empty() ? 0.0 : line.banking[i];
    for (const double v : grid.v_m) {
      const Point2 p = node_position(line, i, v);
      grid.z_m.push_back(
          static_cast<float>(surface.z_at_xy(p.x_m, p.y_m, cursor) - line_z - banking * v));
    }
  }
  return rebuilt(crg, line, std::move(grid));
}

Crg reverse(Crg crg) {
  crg = apply_modifiers(std::move(crg));
  const ReferenceLine old = integrate_reference_line(crg);
  const std::size_t rows = old.size(), columns = crg.grid.columns();
  ReferenceLine line = old;
  for (std::vector<double>* channel : {&line.x_m, &line.y_m, &line.z_m, &line.banking})
    std::reverse(channel->begin(), channel->end());
  for (double& banking : line.banking) banking = -banking;
  for (std::size_t i = 1; i < rows; ++i)
    line.heading_rad[i] = old.heading_rad[rows - i] + std::numbers::pi;
  line.heading_rad[0] = line.heading_rad[1];
  Grid grid = crg.grid;
  std::reverse(grid.z_m.begin(), grid.z_m.end());
  for (std::size_t j = 0; j < columns; ++j) grid.v_m[j] = -crg.grid.v_m[columns - 1 - j];
  Crg result = rebuilt(crg, line, std::move(grid));
  const auto begin = find_value(crg.options, "BORDER_SMOOTH_UBEG"),
             end = find_value(crg.options, "BORDER_SMOOTH_UEND");
  if (begin || end) {
    set_value(result.options, "BORDER_SMOOTH_UBEG", end.value_or(0.0));
    set_value(result.options, "BORDER_SMOOTH_UEND", begin.value_or(0.0));
  }
  return result;
}

namespace {

constexpr double kLargestStep_m = 0.01;  // as at the seam of a closed road
constexpr double kLargestGap_m = 2e-3;   // closed roads end 1 mm before their start

/// By how much a column of the second road has to be raised to meet the first where they join.
struct Step {
  double v_m, up_m;
};

bool meets(const Step& step, double rise_m) {
  return std::abs(step.up_m - rise_m) <= kLargestStep_m;
}

/// With four decimals at most.
std::string short_of(double value) { return shortest(std::round(1e4 * value) / 1e4); }

/// The columns about v = 0 that meet, in words; empty: none.
std::string columns_that_meet(const std::vector<Step>& steps, double rise_m) {
  auto end = std::find_if(steps.begin(), steps.end(), [](const Step& s) { return s.v_m >= 0.0; });
  auto begin = end;
  while (begin != steps.begin() && meets(*std::prev(begin), rise_m)) --begin;
  while (end != steps.end() && meets(*end, rise_m)) ++end;
  if (end - begin < 2) return {};
  return shortest(begin->v_m) + " to " + shortest(std::prev(end)->v_m) + " m";
}

/// By how much the second road is raised: the median of `steps` where it may move, else not at all.
/// Throws Error where the cross sections do not meet.
double rise_at_joint(const std::vector<Step>& steps, bool move, const Crg& first,
                     const Crg& second) {
  if (steps.empty())
    throw Error(second.source + ": no column has a height both here, where it starts, and where " +
                first.source + " ends: want cross sections that overlap");
  std::vector<Step> sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end(),
                   [](const Step& a, const Step& b) { return a.up_m < b.up_m; });
  const double median_m = middle->up_m, rise_m = move ? median_m : 0.0;
  const auto worst = [&](double raised_m) {
    return *std::max_element(steps.begin(), steps.end(), [&](const Step& a, const Step& b) {
      return std::abs(a.up_m - raised_m) < std::abs(b.up_m - raised_m);
    });
  };
  const Step step = worst(rise_m);
  if (meets(step, rise_m)) return rise_m;
  const bool moving_helps = meets(worst(median_m), median_m);
  const std::string meet = columns_that_meet(steps, rise_m);
  throw Error(second.source + ": at v = " + shortest(step.v_m) + " m it starts " +
              short_of(std::abs(step.up_m - rise_m)) + " m " +
              (step.up_m > rise_m ? "below" : "above") + " the end of " + first.source +
              ": want at most " + shortest(kLargestStep_m) + " m; " +
              (moving_helps   ? "or let the second road be moved (--move), which raises it to fit"
               : meet.empty() ? "the cross sections differ"
                              : "the cross sections differ, crop both to v = " + meet));
}

/// Whether `second` begins in plan where `first` ends, and bends no more than both do beside it.
bool goes_on(const ReferenceLine& first, const ReferenceLine& second, double& gap_m,
             double& bend_rad) {
  const auto bend = [](double from, double to) {
    return std::abs(std::remainder(to - from, 2.0 * std::numbers::pi));
  };
  const std::vector<double>&before = first.heading_rad, &after = second.heading_rad;
  double usual_rad =
      std::max(bend(before[before.size() - 2], before.back()), bend(after[0], after[1]));
  if (after.size() > 2) usual_rad = std::max(usual_rad, bend(after[1], after[2]));
  gap_m = std::hypot(first.x_m.back() - second.x_m[0], first.y_m.back() - second.y_m[0]);
  bend_rad = bend(before.back(), after[0]);
  return gap_m <= kLargestGap_m && bend_rad <= 1e-3 + usual_rad;
}

double value_in(const std::vector<double>& channel, std::size_t row) {
  return channel.empty() ? 0.0 : channel[row];
}

/// From the first row of one road up to the last row of another.
std::vector<Step> steps_to(const ReferenceLine& end, const Grid& end_grid,
                           const ReferenceLine& start, const Grid& start_grid) {
  const std::size_t last = end.size() - 1, columns = end_grid.columns();
  std::vector<Step> steps;
  for (std::size_t j = 0; j < columns; ++j) {
    const double v_m = end_grid.v_m[j];
    const double up_m = value_in(end.z_m, last) - value_in(start.z_m, 0) +
                        (value_in(end.banking, last) - value_in(start.banking, 0)) * v_m +
                        static_cast<double>(end_grid.z_m[last * columns + j]) -
                        static_cast<double>(start_grid.z_m[j]);
    if (std::isfinite(up_m)) steps.push_back({v_m, up_m});
  }
  return steps;
}

}  // namespace

Crg append(Crg first, Crg second, const AppendOptions& options) {
  first = apply_modifiers(std::move(first));
  second = apply_modifiers(std::move(second));
  ReferenceLine a = integrate_reference_line(first);
  const ReferenceLine b = integrate_reference_line(second);
  bool same = std::abs(a.u_step_m - b.u_step_m) < 1e-9 * a.u_step_m &&
              first.grid.columns() == second.grid.columns();
  for (std::size_t j = 0; same && j < first.grid.columns(); ++j)
    same = std::abs(first.grid.v_m[j] - second.grid.v_m[j]) < 1e-6;
  if (!same) {
    throw Error(second.source + ": step " + shortest(b.u_step_m) + " m and " +
                std::to_string(second.grid.columns()) + " columns, but " + first.source +
                " has step " + shortest(a.u_step_m) + " m and " +
                std::to_string(first.grid.columns()) +
                ": want the same step and columns; see resample and crop");
  }
  const std::size_t last = a.size() - 1;
  const double turn = options.move ? a.heading_rad[last] - b.heading_rad[0] : 0.0;
  const Point2 end{a.x_m[last], a.y_m[last]}, start{b.x_m[0], b.y_m[0]};
  double gap_m = 0.0, bend_rad = 0.0;
  if (!options.move && !goes_on(a, b, gap_m, bend_rad))
    throw Error(second.source + ": starts " + short_of(gap_m) + " m and " + short_of(bend_rad) +
                " rad off the end of " + first.source +
                ": want the ends to meet; or let the second road be moved (--move)");
  const double rise =
      rise_at_joint(steps_to(a, first.grid, b, second.grid), options.move, first, second);
  const bool z = !a.z_m.empty() || !b.z_m.empty() || rise != 0.0,
             bank = !a.banking.empty() || !b.banking.empty();
  if (z && a.z_m.empty()) a.z_m.assign(a.size(), 0.0);
  if (bank && a.banking.empty()) a.banking.assign(a.size(), 0.0);
  const double cos = std::cos(turn), sin = std::sin(turn);
  for (std::size_t i = 1; i < b.size(); ++i) {
    const double dx = b.x_m[i] - start.x_m, dy = b.y_m[i] - start.y_m;
    const Point2 origin = options.move ? end : start;
    a.x_m.push_back(origin.x_m + cos * dx - sin * dy);
    a.y_m.push_back(origin.y_m + sin * dx + cos * dy);
    a.heading_rad.push_back(b.heading_rad[i] + turn);
    if (z) a.z_m.push_back(value_in(b.z_m, i) + rise);
    if (bank) a.banking.push_back(value_in(b.banking, i));
  }
  Grid grid = first.grid;
  grid.z_m.insert(grid.z_m.end(),
                  second.grid.z_m.begin() + static_cast<std::ptrdiff_t>(second.grid.columns()),
                  second.grid.z_m.end());
  const std::vector<Step> seam = steps_to(a, grid, a, grid);
  a.closed = goes_on(a, a, gap_m, bend_rad) && !seam.empty() &&
             std::all_of(seam.begin(), seam.end(), [](const Step& s) { return meets(s, 0.0); });
  return rebuilt(first, a, std::move(grid));
}

}  // namespace crg
