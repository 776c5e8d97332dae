#include "road/smooth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "base/parallel.h"
#include "mesh/error.h"
#include "road/roughness.h"

namespace road {

namespace {

constexpr double kWheelPath_m = 0.8;
constexpr double kBandEdge = 1.12246;                         // 2^(1/6): half a third octave
constexpr double kThirdOctave = kBandEdge - 1.0 / kBandEdge;  // width over centre
constexpr double kSmallestWave_m = 2e-6;  // float32 makes waves of this size by itself

/// What may be averaged with what: road and run-off together, kerbs by themselves.
enum class SmoothKind : std::uint8_t { none, kerb, road };

SmoothKind smooth_kind_of(const SampledGrid& sampled, std::size_t node) {
  if (std::isnan(sampled.grid.z_m[node])) return SmoothKind::none;
  return sampled.surface_class[node] == SurfaceClass::kerb ? SmoothKind::kerb : SmoothKind::road;
}

/// For every place the first of its run of one kind, and one past its last.
void find_runs(std::span<const SmoothKind> kind, std::span<std::size_t> run_begin,
               std::span<std::size_t> run_end) {
  for (std::size_t k = 0; k < kind.size();) {
    std::size_t stop = k + 1;
    while (stop < kind.size() && kind[stop] == kind[k]) ++stop;
    std::fill(run_begin.begin() + static_cast<std::ptrdiff_t>(k),
              run_begin.begin() + static_cast<std::ptrdiff_t>(stop), k);
    std::fill(run_end.begin() + static_cast<std::ptrdiff_t>(k),
              run_end.begin() + static_cast<std::ptrdiff_t>(stop), stop);
    k = stop;
  }
}

void average_along_u(SampledGrid& sampled, std::size_t half, bool closed, unsigned threads) {
  crg::Grid& grid = sampled.grid;
  const std::size_t rows = grid.rows(), columns = grid.columns();
  // On a closed road the last row repeats the first and the window goes round.
  const std::size_t ring = closed ? rows - 1 : rows, wrap = closed ? half : 0,
                    size = ring + 2 * wrap;
  base::parallel_for(columns, 4, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<double> value(size), sum(size + 1);
    std::vector<SmoothKind> kind(size);
    std::vector<std::size_t> run_begin(size), run_end(size);
    for (std::size_t j = begin; j < end; ++j) {
      for (std::size_t k = 0; k < size; ++k) {
        const std::size_t node = ((k + ring - wrap) % ring) * columns + j;
        kind[k] = smooth_kind_of(sampled, node);
        value[k] = kind[k] == SmoothKind::none ? 0.0 : static_cast<double>(grid.z_m[node]);
        sum[k + 1] = sum[k] + value[k];
      }
      find_runs(kind, run_begin, run_end);
      for (std::size_t i = 0; i < ring; ++i) {
        const std::size_t k = i + wrap;
        if (kind[k] == SmoothKind::none) continue;
        const std::size_t reach = std::min({half, k - run_begin[k], run_end[k] - 1 - k});
        const double mean =
            (sum[k + reach + 1] - sum[k - reach]) / static_cast<double>(2 * reach + 1);
        grid.z_m[i * columns + j] = static_cast<float>(mean);
      }
      if (closed) grid.z_m[ring * columns + j] = grid.z_m[j];
    }
  });
}

/// Along one row: a straight line from node to node, its integral, and what lies where.
struct Profile {
  std::span<const double> v_m;
  std::vector<double> z_m, integral;

  double integral_to(double v, std::size_t near) const {
    std::size_t j = std::min(near, v_m.size() - 2);
    while (j > 0 && v_m[j] > v) --j;
    while (j + 2 < v_m.size() && v_m[j + 1] < v) ++j;
    const double t = v - v_m[j], slope = (z_m[j + 1] - z_m[j]) / (v_m[j + 1] - v_m[j]);
    return integral[j] + t * (z_m[j] + 0.5 * t * slope);
  }
};

void average_along_v(SampledGrid& sampled, double half_m, unsigned threads) {
  crg::Grid& grid = sampled.grid;
  const std::size_t columns = grid.columns();
  if (columns < 3) return;
  base::parallel_for(grid.rows(), 64, threads, [&](std::size_t begin, std::size_t end) {
    Profile profile{grid.v_m, std::vector<double>(columns), std::vector<double>(columns)};
    std::vector<SmoothKind> kind(columns);
    std::vector<std::size_t> run_begin(columns), run_end(columns);
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = 0; j < columns; ++j) {
        kind[j] = smooth_kind_of(sampled, i * columns + j);
        profile.z_m[j] = kind[j] == SmoothKind::none ? 0.0 : static_cast<double>(grid.at(i, j));
        if (j > 0)
          profile.integral[j] = profile.integral[j - 1] + 0.5 * (grid.v_m[j] - grid.v_m[j - 1]) *
                                                              (profile.z_m[j] + profile.z_m[j - 1]);
      }
      find_runs(kind, run_begin, run_end);
      for (std::size_t j = 0; j < columns; ++j) {
        if (kind[j] == SmoothKind::none) continue;
        const double v = grid.v_m[j];
        const double reach_m =
            std::min({half_m, v - grid.v_m[run_begin[j]], grid.v_m[run_end[j] - 1] - v});
        if (!(reach_m > 0.0)) continue;
        grid.at(i, j) = static_cast<float>(
            (profile.integral_to(v + reach_m, j) - profile.integral_to(v - reach_m, j)) /
            (2.0 * reach_m));
      }
    }
  });
}

/// Holds every node within its bound of where it was.
void limit(SampledGrid& sampled, const std::vector<float>& before, const SmoothOptions& options,
           SmoothReport& report) {
  crg::Grid& grid = sampled.grid;
  const std::size_t columns = grid.columns();
  for (std::size_t node = 0; node < before.size(); ++node) {
    const SmoothKind kind = smooth_kind_of(sampled, node);
    if (kind == SmoothKind::none) continue;
    const double bound_m =
        kind == SmoothKind::kerb ? options.max_change_kerb_m : options.max_change_road_m;
    const auto old = static_cast<double>(before[node]);
    double change_m = static_cast<double>(grid.z_m[node]) - old;
    if (std::abs(change_m) > bound_m) {
      change_m = std::copysign(bound_m, change_m);
      grid.z_m[node] = static_cast<float>(old + change_m);
      if (bound_m > 0.0) ++report.nodes_at_bound;  // 0: not smoothed at all
    }
    if (kind == SmoothKind::kerb) {
      report.largest_change_kerb_m = std::max(report.largest_change_kerb_m, std::abs(change_m));
    } else if (std::abs(change_m) > report.largest_change_road_m) {
      report.largest_change_road_m = std::abs(change_m);
      report.largest_change_u_m = grid.u_of(node / columns);
      report.largest_change_v_m = grid.v_m[node % columns];
    }
  }
}

/// Both wheel paths of a grid with these heights, on the columns nearest to them.
std::vector<std::vector<double>> wheel_paths(const crg::Grid& grid, const std::vector<float>& z_m) {
  std::vector<std::vector<double>> paths;
  const std::size_t columns = grid.columns();
  for (const double v : {-kWheelPath_m, kWheelPath_m}) {
    const auto nearest =
        std::min_element(grid.v_m.begin(), grid.v_m.end(),
                         [&](double a, double b) { return std::abs(a - v) < std::abs(b - v); });
    const auto j = static_cast<std::size_t>(nearest - grid.v_m.begin());
    auto& path = paths.emplace_back(grid.rows());
    for (std::size_t i = 0; i < path.size(); ++i)
      path[i] = static_cast<double>(z_m[i * columns + j]);
  }
  return paths;
}

void compare_spectra(const crg::Grid& grid, const std::vector<float>& before,
                     SmoothReport& report) {
  const auto bands_of = [&](const std::vector<float>& z_m) {
    return third_octave_bands(displacement_psd(wheel_paths(grid, z_m), grid.u_step_m));
  };
  const std::vector<PsdBand> old_bands = bands_of(before), new_bands = bands_of(grid.z_m);
  for (std::size_t k = 0; k < old_bands.size(); ++k)
    report.bands.push_back({old_bands[k].n_cpm, old_bands[k].psd_m3, new_bands[k].psd_m3});
  for (const SmoothedBand& band : report.bands) {
    const double rms_m = std::sqrt(band.before_m3 * band.n_cpm * kThirdOctave);
    if (rms_m < kSmallestWave_m || band.after_m3 >= 0.5 * band.before_m3) continue;
    const double longest_m = kBandEdge / band.n_cpm, shortest_m = 1.0 / (band.n_cpm * kBandEdge);
    if (!report.halved_waves_m) report.halved_waves_m = {shortest_m, longest_m};
    report.halved_waves_m->shortest_m = shortest_m;  // bands come from long waves to short ones
  }
}

}  // namespace

void smooth(SampledGrid& sampled, const SmoothOptions& options, SmoothReport* report) {
  SmoothReport result;
  for (const auto& [name, window_m] : {std::pair{"smooth_window_m", options.window_u_m},
                                       {"smooth_window_v_m", options.window_v_m}})
    if (!(window_m >= 0.0))
      throw Error(fmt::format("{} is {}; wanted 0 (off) or more", name, window_m));
  crg::Grid& grid = sampled.grid;
  const std::size_t rows = grid.rows();
  const auto half = static_cast<std::size_t>(std::floor(0.5 * options.window_u_m / grid.u_step_m));
  if (options.closed && rows >= 3 && 2 * half + 1 > rows - 1) {
    throw Error(
        fmt::format("smooth_window_m is {}; wanted less than the length of the track, {:.1f} m",
                    options.window_u_m, static_cast<double>(rows - 1) * grid.u_step_m));
  }
  const bool along_u = half > 0 && rows >= 3;
  if (along_u || options.window_v_m > 0.0) {
    const std::vector<float> before = grid.z_m;
    if (along_u) average_along_u(sampled, half, options.closed, options.threads);
    if (options.window_v_m > 0.0)
      average_along_v(sampled, 0.5 * options.window_v_m, options.threads);
    limit(sampled, before, options, result);
    if (report != nullptr) compare_spectra(grid, before, result);
  }
  if (report != nullptr) *report = std::move(result);
}

}  // namespace road
