#include "error_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/parallel.h"
#include "map_rows.h"
#include "nan.h"

namespace road {
namespace {

std::size_t cell_of(const Comparison& result, const PlaceError& place) {
  const double v_cell_m = result.v_m.size() > 1 ? result.v_m[1] - result.v_m[0] : 1.0;
  const auto index = [](double at, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(count - 1)));
  };
  return index((place.u_m - result.u_begin_m) / result.u_cell_m, result.rows) * result.v_m.size() +
         index((place.v_m - result.v_m[0]) / v_cell_m + 0.5, result.v_m.size());
}

}  // namespace

void make_error_map(const HeightMap& map, const ReferenceHeights& reference,
                    const CompareOptions& options, Comparison& result) {
  const double length_m = map.u_end_m() - map.line.u_begin_m,
               width_m = map.v_m.back() - map.v_m.front();
  double u_cell_m = std::max(options.u_cell_m, map.line.u_step_m), v_cell_m = options.v_cell_m;
  while (length_m / u_cell_m * (width_m / v_cell_m) > static_cast<double>(options.max_cells))
    u_cell_m *= 2.0, v_cell_m = std::min(v_cell_m * 1.5, 1.0);
  result.rows = std::max<std::size_t>(1, static_cast<std::size_t>(length_m / u_cell_m));
  const std::size_t columns =
      std::max<std::size_t>(1, static_cast<std::size_t>(width_m / v_cell_m));
  result.u_begin_m = map.line.u_begin_m;
  result.u_cell_m = length_m / static_cast<double>(result.rows);
  for (std::size_t j = 0; j < columns; ++j) {
    result.v_m.push_back(map.v_m.front() +
                         width_m * (static_cast<double>(j) + 0.5) / static_cast<double>(columns));
  }
  result.error_m.assign(result.rows * columns, std::numeric_limits<float>::quiet_NaN());
  result.without_reference.assign(result.rows * columns, 0);
  base::parallel_for(result.rows, 32, options.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<crg::Point2> points;
    std::vector<double> z, z_reference;
    std::vector<std::size_t> column;
    for (std::size_t i = begin; i < end; ++i) {
      const RowPlace place =
          place_of(map, result.u_begin_m + (static_cast<double>(i) + 0.5) * result.u_cell_m);
      const RowLine line = line_of(map, place);
      points.clear(), z.clear(), column.clear();
      for (std::size_t j = 0; j < columns; ++j) {
        const double height = height_at(map, place, result.v_m[j]);
        if (std::isnan(height)) continue;
        points.push_back(line.at(result.v_m[j]));
        z.push_back(height);
        column.push_back(j);
      }
      z_reference.assign(z.size(), kNan);
      reference(points, z, z_reference);
      for (std::size_t k = 0; k < z.size(); ++k) {
        const double error = z[k] - z_reference[k];
        result.error_m[i * columns + column[k]] = static_cast<float>(error);
        result.without_reference[i * columns + column[k]] = std::isnan(error);
      }
    }
  });
}

void make_statistics(Comparison& result) {
  std::vector<float> sizes;
  double sum = 0.0;
  std::size_t without = 0;
  for (std::size_t k = 0; k < result.error_m.size(); ++k) {
    without += result.without_reference[k];
    const float error = result.error_m[k];
    if (std::isnan(error)) continue;
    sizes.push_back(std::abs(error));
    sum += static_cast<double>(error);
  }
  result.points = sizes.size();
  if (result.points + without > 0)
    result.share_without_reference =
        static_cast<double>(without) / static_cast<double>(result.points + without);
  if (sizes.empty()) return;
  result.mean_error_m = sum / static_cast<double>(sizes.size());
  std::sort(sizes.begin(), sizes.end());
  // To the nanometre: what is below is the rounding of heights.
  const auto rounded = [](double length_m) { return std::round(length_m * 1e9) * 1e-9; };
  const auto at = [&](double share) {
    return rounded(static_cast<double>(
        sizes[static_cast<std::size_t>(share * static_cast<double>(sizes.size() - 1))]));
  };
  result.mean_error_m = rounded(result.mean_error_m);
  result.abs_error_m = {at(0.50), at(0.95), at(0.99), at(1.0)};
  // The bins span three times the 95th percentile, so that the shape shows whatever the scale.
  const double reach = std::max(1e-6, 3.0 * result.abs_error_m.p95);
  constexpr std::size_t kBins = 61;
  result.histogram_begin_m = -reach;
  result.histogram_step_m = 2.0 * reach / kBins;
  result.histogram.assign(kBins, 0);
  for (const float error : result.error_m) {
    if (std::isnan(error)) continue;
    const double bin = (static_cast<double>(error) + reach) / result.histogram_step_m;
    ++result.histogram[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))];
  }
}

std::vector<PlaceError> show_known(std::span<const PlaceError> known, Comparison& result) {
  std::vector<PlaceError> shown;
  for (const PlaceError& place : known) {
    const std::size_t cell = cell_of(result, place);
    // A cell without an error at its middle shows any.
    if (place.error_m == 0.0 ||
        std::abs(place.error_m) <= std::abs(static_cast<double>(result.error_m[cell])))
      continue;
    result.error_m[cell] = static_cast<float>(place.error_m);
    result.without_reference[cell] = 0;
    std::erase_if(shown, [&](const PlaceError& other) { return cell_of(result, other) == cell; });
    shown.push_back(place);
  }
  return shown;
}

void find_worst(const HeightMap& map, const ReferenceHeights& reference,
                const CompareOptions& options, const std::vector<PlaceError>& shown,
                Comparison& result) {
  const std::size_t columns = result.v_m.size();
  // The largest of each row, then rows from large to small with a distance between them.
  std::vector<std::pair<float, std::size_t>> rows;
  for (std::size_t i = 0; i < result.rows; ++i) {
    std::pair<float, std::size_t> best{-1.0f, 0};
    for (std::size_t k = i * columns; k < (i + 1) * columns; ++k) {
      if (std::abs(result.error_m[k]) > best.first) best = {std::abs(result.error_m[k]), k};
    }
    if (best.first >= 0.0f) rows.push_back(best);
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  for (const auto& [size, k] : rows) {
    if (result.worst.size() == options.worst_places) break;
    double u_m = result.u_begin_m + (static_cast<double>(k / columns) + 0.5) * result.u_cell_m;
    double v_m = result.v_m[k % columns];
    for (const PlaceError& place : shown) {
      if (cell_of(result, place) == k) u_m = place.u_m, v_m = place.v_m;
    }
    if (std::any_of(result.worst.begin(), result.worst.end(), [&](const CrossCut& c) {
          return std::abs(c.u_m - u_m) < options.worst_apart_m;
        }))
      continue;
    CrossCut place = cut(map, reference, u_m, v_m, v_m - 3.0, v_m + 3.0);
    place.error_m = result.error_m[k];
    result.worst.push_back(std::move(place));
  }
}

}  // namespace road
