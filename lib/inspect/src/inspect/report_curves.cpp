#include "report_curves.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/parallel.h"
#include "nan.h"

namespace road {
namespace {

constexpr std::size_t kMostCurvePoints = 60'000;

double heading_change(double from, double to) {
  return std::remainder(to - from, 2.0 * std::numbers::pi);
}

/// Change of heading per metre over 2 m: single steps of float32 headings are noise.
std::vector<float> curvature_of(const HeightMap& map) {
  const crg::ReferenceLine& line = map.line;
  std::vector<float> curvature(map.rows(), 0.0f);
  const auto reach = std::max<std::size_t>(1, static_cast<std::size_t>(1.0 / line.u_step_m + 0.5));
  for (std::size_t i = 0; i < map.rows(); ++i) {
    // heading[k] belongs to the segment before node k, so the segments i - reach + 1 .. i + reach
    // span the change.
    const std::size_t low = std::max<std::size_t>(1, i >= reach ? i - reach + 1 : 1),
                      high = std::min(map.rows() - 1, i + reach);
    if (high <= low) continue;
    curvature[i] =
        static_cast<float>(heading_change(line.heading_rad[low], line.heading_rad[high]) /
                           (static_cast<double>(high - low) * line.u_step_m));
  }
  return curvature;
}

/// Change per metre over `over_m`.
template <typename Value>
std::vector<float> rate_of(const std::vector<Value>& values, double u_step_m, double over_m) {
  std::vector<float> rate(values.size(), kNanF);
  const auto reach =
      std::max<std::size_t>(1, static_cast<std::size_t>(0.5 * over_m / u_step_m + 0.5));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t low = i >= reach ? i - reach : 0,
                      high = std::min(values.size() - 1, i + reach);
    rate[i] = static_cast<float>((values[high] - values[low]) /
                                 (static_cast<double>(high - low) * u_step_m));
  }
  return rate;
}

/// Along the line, not wrapped.
std::vector<float> headings_of(const crg::ReferenceLine& line) {
  std::vector<float> heading_rad;
  double now_rad = line.heading_rad.front();
  for (const double next_rad : line.heading_rad) {
    now_rad += heading_change(now_rad, next_rad);
    heading_rad.push_back(static_cast<float>(now_rad));
  }
  return heading_rad;
}

/// Least-squares slope across, over what has a height within 3 m of the reference line (or of the
/// middle of the road where the line has none).
std::vector<float> banking_of(const HeightMap& map, const std::vector<RowExtent>& extents) {
  std::vector<float> banking(map.rows(), kNanF);
  base::parallel_for(map.rows(), 512, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (extents[i].empty()) continue;
      const double low = map.v_m[extents[i].first], high = map.v_m[extents[i].last];
      const double middle = low < -1.0 && high > 1.0 ? 0.0 : 0.5 * (low + high);
      double n = 0, sv = 0, sz = 0, svv = 0, svz = 0;
      const auto from = static_cast<std::size_t>(
          std::lower_bound(map.v_m.begin(), map.v_m.end(), middle - 3.0) - map.v_m.begin());
      for (std::size_t j = from; j < map.columns() && map.v_m[j] <= middle + 3.0; ++j) {
        const double z = map.at(i, j), v = map.v_m[j];
        if (std::isnan(z)) continue;
        n += 1, sv += v, sz += z, svv += v * v, svz += v * z;
      }
      const double spread = n * svv - sv * sv;
      if (n >= 3 && spread > 0.0) banking[i] = static_cast<float>((n * svz - sv * sz) / spread);
    }
  });
  return banking;
}

std::vector<float> every(const std::vector<float>& values, std::size_t stride) {
  std::vector<float> result;
  for (std::size_t i = 0; i < values.size(); i += stride) result.push_back(values[i]);
  return result;
}

}  // namespace

AlongU along_u(const HeightMap& map, const std::vector<RowExtent>& extents) {
  AlongU curves;
  // The height of the middle of the road where the reference line has none.
  std::vector<double> z_m = long_section(map, 0.0);
  for (std::size_t i = 0; i < map.rows(); ++i) {
    if (std::isnan(z_m[i]) && !extents[i].empty())
      z_m[i] = map.at(i, (extents[i].first + extents[i].last) / 2);
  }
  constexpr double kRateOver_m = 5.0;
  const double step_m = map.line.u_step_m;
  curves.slope = rate_of(z_m, step_m, 2.0);
  curves.vertical_curvature_1pm = rate_of(curves.slope, step_m, kRateOver_m);
  curves.heading_rad = headings_of(map.line);
  curves.curvature_1pm = curvature_of(map);
  curves.curvature_rate_1pm2 = rate_of(curves.curvature_1pm, step_m, kRateOver_m);
  curves.banking = banking_of(map, extents);
  for (std::size_t i = 0; i < map.rows(); ++i) {
    curves.elevation_m.push_back(static_cast<float>(z_m[i] + map.z_base_m));
    const bool bare = extents[i].empty();
    curves.v_right_m.push_back(bare ? kNanF : static_cast<float>(map.v_m[extents[i].first]));
    curves.v_left_m.push_back(bare ? kNanF : static_cast<float>(map.v_m[extents[i].last]));
    curves.width_m.push_back(curves.v_left_m.back() - curves.v_right_m.back());
  }
  return curves;
}

void add_curves(const HeightMap& map, const AlongU& along, const Comparisons& comparisons,
                report::TrackReport& report) {
  const std::size_t stride = (map.rows() + kMostCurvePoints - 1) / kMostCurvePoints;
  report.u_begin_m = map.line.u_begin_m;
  report.u_step_m = map.line.u_step_m * static_cast<double>(stride);
  report.u_end_m = map.u_end_m();
  const auto add = [&](const char* key, const char* name, const char* unit,
                       const std::vector<float>& values, double factor = 1.0) {
    report.curves.push_back({key, name, unit, every(values, stride), factor});
  };
  add("elevation_m", "Elevation", "m", along.elevation_m);
  add("slope", "Slope", "%", along.slope, 100.0);
  add("vertical_curvature_1pm", "Vertical curvature", "1/m", along.vertical_curvature_1pm);
  add("banking", "Banking", "%", along.banking, 100.0);
  add("heading_rad", "Heading", "°", along.heading_rad, 180.0 / std::numbers::pi);
  add("curvature_1pm", "Curvature", "1/m", along.curvature_1pm);
  add("curvature_rate_1pm2", "Curvature rate", "1/m²", along.curvature_rate_1pm2);
  add("width_m", "Width", "m", along.width_m);
  add("v_left_m", "Left limit v", "m", along.v_left_m);
  add("v_right_m", "Right limit v", "m", along.v_right_m);
  for (const auto& [key, comparison] : comparisons) {
    std::vector<float> largest(map.rows(), kNanF);
    const std::size_t columns = comparison.v_m.size();
    std::vector<float> of_row(comparison.rows, kNanF);
    for (std::size_t k = 0; k < comparison.error_m.size(); ++k) {
      const float size = std::abs(comparison.error_m[k]);
      float& best = of_row[k / columns];
      if (!(best >= size) && !std::isnan(size)) best = size;
    }
    for (std::size_t i = 0; i < map.rows(); ++i) {
      const double row = (map.u_of(i) - comparison.u_begin_m) / comparison.u_cell_m;
      largest[i] = of_row[static_cast<std::size_t>(
          std::clamp(row, 0.0, static_cast<double>(comparison.rows - 1)))];
    }
    report.curves.push_back({"largest_error_" + key + "_m", "Largest error (" + key + ")", "mm",
                             every(largest, stride), 1000.0});
  }
}

}  // namespace road
