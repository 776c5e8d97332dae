// From headings to nodes and back: the reference line that a file means, and the file for a line.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "closing.h"
#include "crg/error.h"
#include "crg/file.h"
#include "text.h"

namespace crg {
namespace {

double value_or(const Crg& crg, const char* key, double otherwise) {
  return find_value(crg.road, key).value_or(otherwise);
}

// Where the end of an integrated channel is given, the file means that it is also integrated back
// from there, and that the result passes from the one to the other with the weight
// w <- (1 - i/N) w + i/N per row, as the reference implementation does (opencrg 2.0.1).
void lead_to(std::optional<double> end, std::vector<double>& values) {
  if (!end) return;
  const std::size_t rows = values.size();
  const double gap = *end - values.back();
  const double last = static_cast<double>(rows - 1);
  double weight = 0.0;
  for (std::size_t i = 1; i < rows; ++i) {
    const double share = static_cast<double>(i) / last;
    weight = (1.0 - share) * weight + share;
    values[i] += weight * gap;
  }
  values.back() = *end;
}

void integrate_heights(const Crg& crg, ReferenceLine& line) {
  const std::size_t rows = line.size();
  const double begin = value_or(crg, "REFERENCE_LINE_START_Z", 0.0);
  const std::optional<double> end = find_value(crg.road, "REFERENCE_LINE_END_Z");
  const double length = line.u_step_m * static_cast<double>(rows - 1);
  if (!crg.slope.empty()) {
    line.z_m.assign(rows, begin);
    for (std::size_t i = 1; i < rows; ++i)
      line.z_m[i] = line.z_m[i - 1] + line.u_step_m * crg.slope[i];
    lead_to(end, line.z_m);
    return;
  }
  const double slope = end ? (*end - begin) / length : value_or(crg, "REFERENCE_LINE_START_S", 0.0);
  if (begin == 0.0 && slope == 0.0) return;
  line.z_m.resize(rows);
  for (std::size_t i = 0; i < rows; ++i)
    line.z_m[i] = begin + slope * line.u_step_m * static_cast<double>(i);
}

void integrate_nodes(const Crg& crg, ReferenceLine& line) {
  const std::size_t rows = line.heading_rad.size();
  line.x_m.assign(rows, value_or(crg, "REFERENCE_LINE_START_X", 0.0));
  line.y_m.assign(rows, value_or(crg, "REFERENCE_LINE_START_Y", 0.0));
  for (std::size_t i = 1; i < rows; ++i) {
    const double heading_rad = line.heading_rad[i];
    line.x_m[i] = line.x_m[i - 1] + line.u_step_m * std::cos(heading_rad);
    line.y_m[i] = line.y_m[i - 1] + line.u_step_m * std::sin(heading_rad);
  }
  const std::optional<double> end_x = find_value(crg.road, "REFERENCE_LINE_END_X");
  const std::optional<double> end_y = find_value(crg.road, "REFERENCE_LINE_END_Y");
  if (!end_x || !end_y) return;
  lead_to(end_x, line.x_m);
  lead_to(end_y, line.y_m);
}

void take_nodes(const Crg& crg, ReferenceLine& line) {
  line.x_m = crg.x_m;
  line.y_m = crg.y_m;
  if (!crg.heading_rad.empty()) return;
  for (std::size_t i = 1; i < line.size(); ++i) {
    line.heading_rad[i] = std::atan2(line.y_m[i] - line.y_m[i - 1], line.x_m[i] - line.x_m[i - 1]);
  }
  if (!find_value(crg.road, "REFERENCE_LINE_START_PHI")) line.heading_rad[0] = line.heading_rad[1];
}

}  // namespace

ReferenceLine integrate_reference_line(const Crg& crg) {
  const std::size_t rows = crg.grid.rows();
  if (rows < 2) throw Error("crg file: " + std::to_string(rows) + " rows: want at least 2");
  if (!(crg.grid.u_step_m > 0.0) || !std::isfinite(crg.grid.u_step_m)) {
    throw Error("crg file: increment " + shortest(crg.grid.u_step_m) + " m: want more than 0");
  }
  for (const std::vector<double>* channel :
       {&crg.heading_rad, &crg.slope, &crg.banking, &crg.x_m, &crg.y_m}) {
    if (!channel->empty() && channel->size() != rows) {
      throw Error("crg file: a channel of " + std::to_string(channel->size()) +
                  " values beside a grid of " + std::to_string(rows) + " rows");
    }
  }
  ReferenceLine line;
  line.u_begin_m = crg.grid.u_begin_m;
  line.u_step_m = crg.grid.u_step_m;
  line.heading_rad = crg.heading_rad;
  const std::optional<double> start_heading = find_value(crg.road, "REFERENCE_LINE_START_PHI");
  if (line.heading_rad.empty()) line.heading_rad.assign(rows, start_heading.value_or(0.0));
  line.heading_rad[0] = start_heading.value_or(line.heading_rad[1]);
  if (!crg.x_m.empty() && !crg.y_m.empty()) {
    take_nodes(crg, line);
  } else {
    integrate_nodes(crg, line);
  }
  integrate_heights(crg, line);
  line.banking = crg.banking;
  const double banking = value_or(crg, "REFERENCE_LINE_START_B", 0.0);
  if (line.banking.empty() && banking != 0.0) line.banking.assign(rows, banking);
  line.closed = find_value(crg.options, "REFLINE_CONTINUATION").value_or(0.0) == 1.0 &&
                find_closing(line).has_value();
  return line;
}

}  // namespace crg
