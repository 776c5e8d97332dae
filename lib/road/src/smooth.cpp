#include "road/smooth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "road/error.h"
#include "road/parallel.h"

namespace road {

namespace {

/// Symmetric moving average over values[i - h .. i + h], h shrunk to what `reach` allows at i.
/// `sum` holds prefix sums: sum[i] = values[0] + ... + values[i - 1].
double average(const std::vector<double>& sum, std::size_t i, std::size_t h) {
  return (sum[i + h + 1] - sum[i - h]) / static_cast<double>(2 * h + 1);
}

}  // namespace

void smooth(SampledGrid& sampled, const SmoothOptions& options, SmoothReport* report) {
  if (report != nullptr) *report = {};
  if (!(options.window_m >= 0.0)) throw Error(fmt::format("smooth_window_m is {}; wanted 0 (off) or more", options.window_m));
  crg::Grid& grid = sampled.grid;
  const std::size_t rows = grid.rows(), columns = grid.columns();
  const auto half = static_cast<std::size_t>(std::floor(0.5 * options.window_m / grid.u_step_m));
  if (half == 0 || rows < 3) return;

  // On a closed road the last row repeats the first and the window goes round.
  const std::size_t ring = options.closed ? rows - 1 : rows;
  if (options.closed && 2 * half + 1 > ring) {
    throw Error(fmt::format("smooth_window_m is {}; wanted less than the length of the track, {:.1f} m", options.window_m,
                            static_cast<double>(ring) * grid.u_step_m));
  }
  const std::size_t wrap = options.closed ? half : 0;
  std::vector<SmoothReport> partial(columns);
  parallel_for(columns, 4, options.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<double> value(ring + 2 * wrap), sum(value.size() + 1);
    std::vector<std::size_t> run_begin(value.size()), run_end(value.size());
    for (std::size_t j = begin; j < end; ++j) {
      const auto node = [&](std::size_t k) { return ((k + ring - wrap) % ring) * columns + j; };
      // A run is a stretch of one kind: road and run-off together, or kerb.
      const auto kind = [&](std::size_t k) {
        const std::size_t at = node(k);
        if (std::isnan(grid.z_m[at])) return 0;
        return sampled.surface_class[at] == SurfaceClass::kerb ? 1 : 2;
      };
      for (std::size_t k = 0; k < value.size(); ++k) {
        const float z = grid.z_m[node(k)];
        value[k] = std::isnan(z) ? 0.0 : static_cast<double>(z);
        sum[k + 1] = sum[k] + value[k];
      }
      for (std::size_t k = 0; k < value.size();) {
        std::size_t stop = k + 1;
        while (stop < value.size() && kind(stop) == kind(k)) ++stop;
        std::fill(run_begin.begin() + static_cast<std::ptrdiff_t>(k), run_begin.begin() + static_cast<std::ptrdiff_t>(stop), k);
        std::fill(run_end.begin() + static_cast<std::ptrdiff_t>(k), run_end.begin() + static_cast<std::ptrdiff_t>(stop), stop);
        k = stop;
      }
      for (std::size_t i = 0; i < ring; ++i) {
        const std::size_t k = i + wrap;
        const int what = kind(k);
        if (what == 0) continue;
        const std::size_t reach = std::min({half, k - run_begin[k], run_end[k] - 1 - k});
        const double bound_m = what == 1 ? options.max_change_kerb_m : options.max_change_road_m;
        double change_m = average(sum, k, reach) - value[k];
        if (std::abs(change_m) > bound_m) {
          change_m = std::copysign(bound_m, change_m);
          ++partial[j].nodes_at_bound;
        }
        double& largest = what == 1 ? partial[j].largest_change_kerb_m : partial[j].largest_change_road_m;
        largest = std::max(largest, std::abs(change_m));
        grid.z_m[i * columns + j] = static_cast<float>(value[k] + change_m);
      }
      if (options.closed) grid.z_m[ring * columns + j] = grid.z_m[j];
    }
  });
  if (report == nullptr) return;
  for (const SmoothReport& column : partial) {
    report->largest_change_road_m = std::max(report->largest_change_road_m, column.largest_change_road_m);
    report->largest_change_kerb_m = std::max(report->largest_change_kerb_m, column.largest_change_kerb_m);
    report->nodes_at_bound += column.nodes_at_bound;
  }
}

}  // namespace road
