#include "inspect/sizes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/statistics.h"

namespace road {

CentrelineReport describe(const Centreline& centreline) {
  CentrelineReport report;
  report.stations = centreline.points_m.size();
  report.length_m = centreline.length_m;
  report.closed = centreline.closed;
  const std::vector<double>& half = centreline.half_width_m;
  if (half.empty()) return report;
  report.width_median_m = 2.0 * base::median(half);
  const auto [low, high] = std::minmax_element(half.begin(), half.end());
  report.width_min_m = 2.0 * *low;
  report.width_max_m = 2.0 * *high;
  return report;
}

GeoEnds geo_ends(const crg::Crg& file) {
  const auto end = [&](const std::string& which) -> std::optional<GeoPoint> {
    const auto value = [&](const char* key) {
      return crg::find_value(file.road, "REFERENCE_LINE_" + which + key);
    };
    const auto latitude = value("_LAT"), longitude = value("_LON");
    if (!latitude || !longitude) return std::nullopt;
    return GeoPoint{*latitude, *longitude, value("_ALT")};
  };
  return {end("START"), end("END")};
}

GridReport describe(const crg::Grid& grid, const crg::ReferenceLine& line) {
  GridReport report;
  report.rows = grid.rows();
  report.columns = grid.columns();
  report.nodes = report.rows * report.columns;
  report.u_begin_m = grid.u_begin_m;
  report.u_step_m = grid.u_step_m;
  report.z_min_m = report.z_max_m = report.width_min_m = report.width_median_m =
      report.width_max_m = std::numeric_limits<double>::quiet_NaN();
  if (report.nodes == 0) return report;
  report.u_end_m = grid.u_of(report.rows - 1);
  report.v_min_m = grid.v_m.front();
  report.v_max_m = grid.v_m.back();
  if (report.columns > 1) {
    report.v_step_min_m = std::numeric_limits<double>::infinity();
    for (std::size_t j = 1; j < report.columns; ++j) {
      const double step = grid.v_m[j] - grid.v_m[j - 1];
      report.v_step_min_m = std::min(report.v_step_min_m, step);
      report.v_step_max_m = std::max(report.v_step_max_m, step);
    }
  }
  double low = std::numeric_limits<double>::infinity(), high = -low;
  std::vector<double> widths;
  for (std::size_t i = 0; i < report.rows; ++i) {
    const double line_z = line.z_m.empty() ? 0.0 : line.z_m[i],
                 banking = line.banking.empty() ? 0.0 : line.banking[i];
    const float* row = grid.z_m.data() + i * report.columns;
    std::size_t with_z = 0, first = report.columns, last = 0;
    for (std::size_t j = 0; j < report.columns; ++j) {
      if (std::isnan(row[j])) continue;
      ++with_z;
      first = std::min(first, j);
      last = j;
      const double z = static_cast<double>(row[j]) + line_z + banking * grid.v_m[j];
      low = std::min(low, z);
      high = std::max(high, z);
    }
    report.nodes_with_z += with_z;
    if (with_z == 0) continue;
    report.holes += last - first + 1 - with_z;
    widths.push_back(grid.v_m[last] - grid.v_m[first]);
  }
  if (report.nodes_with_z == 0) return report;
  report.z_min_m = low;
  report.z_max_m = high;
  std::sort(widths.begin(), widths.end());
  report.width_min_m = widths.front();
  report.width_median_m = widths[widths.size() / 2];
  report.width_max_m = widths.back();
  return report;
}

}  // namespace road
