#include <algorithm>
#include <cmath>
#include <numbers>

#include "crg/error.h"
#include "crg/file.h"
#include "round_channels.h"
#include "text.h"

namespace crg {
namespace {

bool constant(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(),
                     [&](double value) { return value == values.front(); });
}

void want_fit(const ReferenceLine& line, const Grid& grid) {
  const std::size_t rows = grid.rows();
  if (grid.columns() < 2 || rows < 2 || grid.z_m.size() != rows * grid.columns()) {
    throw Error("make_crg: a grid of " + std::to_string(rows) + " rows and " +
                std::to_string(grid.columns()) + " columns with " +
                std::to_string(grid.z_m.size()) + " values: want at least 2 x 2, all filled");
  }
  if (line.size() != rows || line.y_m.size() != rows || line.heading_rad.size() != rows ||
      (!line.z_m.empty() && line.z_m.size() != rows) ||
      (!line.banking.empty() && line.banking.size() != rows)) {
    throw Error("make_crg: a line of " + std::to_string(line.size()) + " nodes and a grid of " +
                std::to_string(rows) + " rows: want as many of each, in every vector of the line");
  }
  if (!(grid.u_step_m > 0.0) || std::abs(line.u_step_m - grid.u_step_m) > 1e-9 * grid.u_step_m ||
      std::abs(line.u_begin_m - grid.u_begin_m) > 1e-6) {
    throw Error("make_crg: line from u = " + shortest(line.u_begin_m) + " step " +
                shortest(line.u_step_m) + ", grid from u = " + shortest(grid.u_begin_m) + " step " +
                shortest(grid.u_step_m) + ": want the same");
  }
}

}  // namespace

Crg make_crg(const ReferenceLine& line, Grid grid, std::vector<std::string> comment) {
  want_fit(line, grid);
  Crg crg;
  crg.comment = std::move(comment);
  crg.has_modifier_section = true;
  crg.has_option_section = true;
  const auto round = [](double value) { return static_cast<double>(static_cast<float>(value)); };
  const RoundedLine rounded = round_headings(line, round);
  const auto set = [&](const char* key, double value) { set_value(crg.road, key, value); };
  set("REFERENCE_LINE_START_U", grid.u_begin_m);
  set("REFERENCE_LINE_END_U", grid.u_of(grid.rows() - 1));
  set("REFERENCE_LINE_INCREMENT", grid.u_step_m);
  set("REFERENCE_LINE_START_X", line.x_m.front());
  set("REFERENCE_LINE_START_Y", line.y_m.front());
  set("REFERENCE_LINE_START_PHI", rounded.heading_rad.front());
  set("REFERENCE_LINE_END_X", rounded.end.x_m);
  set("REFERENCE_LINE_END_Y", rounded.end.y_m);
  set("REFERENCE_LINE_END_PHI", rounded.heading_rad.back());
  crg.heading_rad = rounded.heading_rad;
  if (!line.z_m.empty()) {
    set("REFERENCE_LINE_START_Z", line.z_m.front());
    double end_z = line.z_m.back();
    if (!constant(line.z_m)) crg.slope = round_slopes(line.z_m, line.u_step_m, round, end_z);
    set("REFERENCE_LINE_END_Z", end_z);
  }
  if (!line.banking.empty()) {
    set("REFERENCE_LINE_START_B", line.banking.front());
    set("REFERENCE_LINE_END_B", line.banking.back());
    if (!constant(line.banking)) {
      crg.banking.resize(line.banking.size());
      std::transform(line.banking.begin(), line.banking.end(), crg.banking.begin(), round);
    }
  }
  set("LONG_SECTION_V_RIGHT", grid.v_m.front());
  set("LONG_SECTION_V_LEFT", grid.v_m.back());
  if (line.closed) set_value(crg.options, "REFLINE_CONTINUATION", 1.0);
  crg.grid = std::move(grid);
  return crg;
}

}  // namespace crg
