#include "circuit/iso8608.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "base/random.h"
#include "mesh/error.h"

namespace road {
namespace {

constexpr double kReferenceFrequencyCpm = 0.1;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

}  // namespace

double iso8608_psd_at_n0(char iso_class) {
  if (iso_class < 'A' || iso_class > 'H') {
    throw Error(fmt::format("roughness class is '{}'; ISO 8608 has A (smooth) to H", iso_class));
  }
  return 16e-6 * std::pow(4.0, iso_class - 'A');
}

Roughness::Roughness(const RoughnessOptions& options, double period_m) {
  const double psd_n0 = iso8608_psd_at_n0(options.iso_class);
  if (!(options.n_min_cpm > 0.0) || !(options.n_max_cpm > options.n_min_cpm)) {
    throw Error(fmt::format("roughness band is {} to {} cycles/m; give 0 < n_min_cpm < n_max_cpm",
                            options.n_min_cpm, options.n_max_cpm));
  }
  if (options.waves_per_octave < 1 || options.waves_per_octave > 1000) {
    throw Error(fmt::format("waves_per_octave is {}; give 1 to 1000", options.waves_per_octave));
  }
  if (!(period_m * options.n_min_cpm > 1.0)) {
    throw Error(
        fmt::format("roughness below {} cycles/m does not fit a period of {} m; raise "
                    "n_min_cpm above {:.4g}",
                    options.n_min_cpm, period_m, 1.0 / period_m));
  }

  // Narrow bands of equal ratio; each gets one harmonic of the period, drawn among those inside it,
  // with the variance that the spectrum has in the band. A band without any harmonic (long waves on
  // a short road) is widened until there is one, so no variance is lost.
  base::Random random(options.seed);
  const double ratio = std::exp2(1.0 / options.waves_per_octave);
  for (double low = options.n_min_cpm; low < options.n_max_cpm;) {
    double high = low;
    double first = 0.0;
    double last = 0.0;
    do {
      high = std::min(high * ratio, options.n_max_cpm);
      // The last sliver of the band joins its neighbour instead of being drawn alone.
      if (high * ratio > options.n_max_cpm) high = options.n_max_cpm;
      first = std::ceil(low * period_m);
      last = std::ceil(high * period_m) - 1.0;
    } while (last < first && high < options.n_max_cpm);
    const double variance =
        psd_n0 * kReferenceFrequencyCpm * kReferenceFrequencyCpm * (1.0 / low - 1.0 / high);
    if (last >= first) {
      const auto count = static_cast<std::uint64_t>(last - first) + 1;
      const double harmonic = first + static_cast<double>(random.below(count));
      const double k_u = kTwoPi * harmonic / period_m;
      const double k_v = k_u * random.uniform(-1.0, 1.0);
      waves_.push_back({std::sqrt(2.0 * variance), k_u, k_v, kTwoPi * random.uniform()});
    } else if (!waves_.empty()) {  // the last band of a short road
      waves_.back().amplitude_m = std::hypot(waves_.back().amplitude_m, std::sqrt(2.0 * variance));
    }
    low = high;
  }
  if (waves_.empty()) {
    throw Error(
        fmt::format("no whole number of waves of {} to {} cycles/m fits {} m; widen the band",
                    options.n_min_cpm, options.n_max_cpm, period_m));
  }
}

double Roughness::height_m(double u_m, double v_m) const noexcept {
  double height = 0.0;
  for (const Wave& wave : waves_) {
    height +=
        wave.amplitude_m * std::cos(wave.k_u_radpm * u_m + wave.k_v_radpm * v_m + wave.phase_rad);
  }
  return height;
}

void Roughness::add_grid(std::span<const double> u_m, std::span<const double> v_m,
                         std::span<double> out_m) const {
  assert(out_m.size() == u_m.size() * v_m.size());
  // cos(a + b) = cos a cos b - sin a sin b: trigonometry once per row and once per column.
  const std::size_t columns = v_m.size();
  std::vector<double> column_cos(waves_.size() * columns);
  std::vector<double> column_sin(waves_.size() * columns);
  for (std::size_t w = 0; w < waves_.size(); ++w) {
    for (std::size_t j = 0; j < columns; ++j) {
      column_cos[w * columns + j] = std::cos(waves_[w].k_v_radpm * v_m[j]);
      column_sin[w * columns + j] = std::sin(waves_[w].k_v_radpm * v_m[j]);
    }
  }
  for (std::size_t i = 0; i < u_m.size(); ++i) {
    double* out = out_m.data() + i * columns;
    for (std::size_t w = 0; w < waves_.size(); ++w) {
      const double angle = waves_[w].k_u_radpm * u_m[i] + waves_[w].phase_rad;
      const double a = waves_[w].amplitude_m * std::cos(angle);
      const double b = waves_[w].amplitude_m * std::sin(angle);
      const double* c = column_cos.data() + w * columns;
      const double* s = column_sin.data() + w * columns;
      for (std::size_t j = 0; j < columns; ++j) out[j] += a * c[j] - b * s[j];
    }
  }
}

}  // namespace road
