#include "road/roughness.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/FFT>
#include <unsupported/Eigen/MatrixFunctions>

#include "base/statistics.h"

namespace road {

namespace {

constexpr double kN0 = 0.1;  // cycle/m, reference frequency of ISO 8608
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Run {
  std::size_t begin, end;
};

/// Pieces of a section without NaN.
std::vector<Run> finite_runs(std::span<const double> values) {
  std::vector<Run> runs;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    if (runs.empty() || runs.back().end != i) runs.push_back({i, i});
    runs.back().end = i + 1;
  }
  return runs;
}

std::size_t power_of_two_near(double value) {
  return std::size_t{1} << static_cast<unsigned>(std::max(1.0, std::round(std::log2(value))));
}

void remove_line(std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double sum = 0.0, moment = 0.0, square = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double t = static_cast<double>(i) - 0.5 * (n - 1.0);
    sum += values[i];
    moment += t * values[i];
    square += t * t;
  }
  const double mean = sum / n, slope = moment / square;
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] -= mean + slope * (static_cast<double>(i) - 0.5 * (n - 1.0));
  }
}

}  // namespace

DisplacementPsd displacement_psd(std::span<const std::vector<double>> sections_m, double step_m,
                                 const PsdOptions& options) {
  assert(step_m > 0.0);
  std::size_t longest = 0;
  for (const auto& section : sections_m) {
    for (const Run& run : finite_runs(section)) longest = std::max(longest, run.end - run.begin);
  }
  std::size_t size = power_of_two_near(options.segment_m / step_m);
  while (size > longest && static_cast<double>(size) * step_m > 50.0) size /= 2;
  DisplacementPsd psd;
  if (size > longest || size < 8) return psd;

  std::vector<double> window(size);
  double window_square = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    window[i] = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * static_cast<double>(i) /
                                     static_cast<double>(size));
    window_square += window[i] * window[i];
  }
  std::vector<double> sum(size / 2, 0.0);
  Eigen::FFT<double> fft;
  std::vector<double> segment(size);
  std::vector<std::complex<double>> spectrum;
  for (const auto& section : sections_m) {
    for (const Run& run : finite_runs(section)) {
      if (run.end - run.begin < size) continue;
      // Segments are spread so that the last one ends with the run.
      const std::size_t spare = run.end - run.begin - size;
      const std::size_t count = 1 + (2 * spare + size - 1) / size;
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t begin = run.begin + (count == 1 ? 0 : k * spare / (count - 1));
        std::copy_n(section.begin() + static_cast<std::ptrdiff_t>(begin), size, segment.begin());
        remove_line(segment);
        for (std::size_t i = 0; i < size; ++i) segment[i] *= window[i];
        fft.fwd(spectrum, segment);
        for (std::size_t i = 1; i < size / 2; ++i) sum[i] += std::norm(spectrum[i]);
        ++psd.segments;
      }
    }
  }
  const double scale = 2.0 * step_m / (window_square * static_cast<double>(psd.segments));
  for (std::size_t i = 1; i < size / 2; ++i) {
    psd.n_cpm.push_back(static_cast<double>(i) / (static_cast<double>(size) * step_m));
    psd.psd_m3.push_back(sum[i] * scale);
  }
  return psd;
}

std::vector<PsdBand> third_octave_bands(const DisplacementPsd& psd) {
  std::vector<PsdBand> bands;
  if (psd.n_cpm.size() < 2) return bands;
  const int first = static_cast<int>(std::ceil(3.0 * std::log2(psd.n_cpm.front() / kN0)));
  const int last = static_cast<int>(std::floor(3.0 * std::log2(psd.n_cpm.back() / kN0)));
  std::size_t i = 0;
  for (int k = first; k <= last; ++k) {
    const double centre = kN0 * std::exp2(k / 3.0);
    const double low = centre * std::exp2(-1.0 / 6.0), high = centre * std::exp2(1.0 / 6.0);
    while (i < psd.n_cpm.size() && psd.n_cpm[i] < low) ++i;
    double sum = 0.0;
    std::size_t count = 0;
    for (; i < psd.n_cpm.size() && psd.n_cpm[i] < high; ++i, ++count) sum += psd.psd_m3[i];
    if (count > 0) bands.push_back({centre, sum / static_cast<double>(count)});
  }
  return bands;
}

std::optional<Iso8608Fit> fit_iso8608(const DisplacementPsd& psd, const Iso8608Options& options) {
  Iso8608Fit fit;
  std::vector<PsdBand> used;
  for (const PsdBand& band : third_octave_bands(psd)) {
    if (band.n_cpm < options.n_min_cpm || band.n_cpm > options.n_max_cpm) continue;
    if (!used.empty()) {
      const double ratio = used.back().n_cpm / band.n_cpm;
      if (!(band.psd_m3 > 0.1 * used.back().psd_m3 * ratio * ratio)) {
        fit.band_cut = true;
        break;
      }
    } else if (!(band.psd_m3 > 0.0)) {
      continue;
    }
    used.push_back(band);
  }
  // The band across the end of the spectrum is only partly filled: it would bend the line down.
  if (fit.band_cut && !used.empty()) used.pop_back();
  if (used.size() < 5) return std::nullopt;
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (const PsdBand& band : used) {
    const double x = std::log(band.n_cpm / kN0), y = std::log(band.psd_m3);
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  const auto count = static_cast<double>(used.size());
  const double slope = (count * sxy - sx * sy) / (count * sxx - sx * sx);
  fit.exponent = -slope;
  fit.psd_at_n0_m3 = std::exp((sy - slope * sx) / count);
  fit.n_min_cpm = used.front().n_cpm;
  fit.n_max_cpm = used.back().n_cpm;
  // Class limits lie a factor of 2 around the means 16e-6 * 4^k.
  const int index =
      static_cast<int>(std::floor(std::log(fit.psd_at_n0_m3 / 32e-6) / std::log(4.0))) + 1;
  fit.iso_class = static_cast<char>('A' + std::clamp(index, 0, 7));
  return fit;
}

QuarterCarStep quarter_car_step(double step_m) {
  // Sprung and unsprung mass over a stiff profile, all divided by the sprung mass; the state holds
  // slopes (d/dx of heights) and their time derivatives, so that the input is the profile's slope.
  constexpr double kSpring = 63.3, kTyre = 653.0, kDamper = 6.0, kMass = 0.15;
  constexpr double kSpeed = 80.0 / 3.6;
  Eigen::Matrix4d a;
  a << 0.0, 1.0, 0.0, 0.0,                   //
      -kSpring, -kDamper, kSpring, kDamper,  //
      0.0, 0.0, 0.0, 1.0,                    //
      kSpring / kMass, kDamper / kMass, -(kTyre + kSpring) / kMass, -kDamper / kMass;
  const Eigen::Vector4d b(0.0, 0.0, 0.0, kTyre / kMass);
  Eigen::Matrix<double, 5, 5> augmented = Eigen::Matrix<double, 5, 5>::Zero();
  augmented.topLeftCorner<4, 4>() = a * (step_m / kSpeed);
  augmented.topRightCorner<4, 1>() = b * (step_m / kSpeed);
  const Eigen::Matrix<double, 5, 5> exponential = augmented.exp();
  QuarterCarStep step{};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) step.transition[i][j] = exponential(i, j);
    step.input[i] = exponential(i, 4);
  }
  return step;
}

std::vector<IriSegment> iri(std::span<const double> section_m, double step_m, double length_m) {
  assert(step_m > 0.0 && length_m > 0.0);
  const std::size_t n = section_m.size();
  const double total_m = static_cast<double>(n > 0 ? n - 1 : 0) * step_m;
  std::vector<IriSegment> segments;
  if (n < 2) return segments;
  const auto count = static_cast<std::size_t>(std::max(1.0, std::floor(total_m / length_m + 0.5)));
  for (std::size_t k = 0; k < count; ++k) {
    segments.push_back({static_cast<double>(k) * length_m,
                        k + 1 == count ? total_m : static_cast<double>(k + 1) * length_m, kNan});
  }
  const QuarterCarStep step = quarter_car_step(step_m);
  const std::size_t base = std::max<std::size_t>(1, static_cast<std::size_t>(0.25 / step_m + 0.5));
  const double base_m = static_cast<double>(base) * step_m;
  std::vector<double> sum(count, 0.0);
  std::vector<std::size_t> steps(count, 0);
  for (const Run& run : finite_runs(section_m)) {
    if (run.end - run.begin <= base + 1) continue;
    const std::size_t lead =
        std::min(run.end - run.begin - 1, static_cast<std::size_t>(11.0 / step_m + 0.5));
    const double start =
        (section_m[run.begin + lead] - section_m[run.begin]) / (static_cast<double>(lead) * step_m);
    std::array<double, 4> x{start, 0.0, start, 0.0};
    for (std::size_t i = run.begin; i + base < run.end; ++i) {
      const double slope = (section_m[i + base] - section_m[i]) / base_m;
      std::array<double, 4> next{};
      for (int r = 0; r < 4; ++r) {
        next[r] = step.input[r] * slope;
        for (int c = 0; c < 4; ++c) next[r] += step.transition[r][c] * x[c];
      }
      x = next;
      const auto k =
          std::min(count - 1, static_cast<std::size_t>(static_cast<double>(i) * step_m / length_m));
      sum[k] += std::abs(x[0] - x[2]);
      ++steps[k];
    }
  }
  for (std::size_t k = 0; k < count; ++k) {
    // A segment with more than a tenth missing has no index; the ends lose one base length.
    const double wanted = (segments[k].end_m - segments[k].begin_m) / step_m;
    if (static_cast<double>(steps[k]) >= 0.9 * wanted - static_cast<double>(base)) {
      if (steps[k] > 0) segments[k].iri_m_per_km = 1000.0 * sum[k] / static_cast<double>(steps[k]);
    }
  }
  return segments;
}

std::optional<FacetSpacing> facet_spacing(std::span<const double> section_m, double step_m) {
  std::vector<double> second, magnitudes;
  for (std::size_t i = 0; i < section_m.size(); ++i) {
    const bool inside = i > 0 && i + 1 < section_m.size();
    const double d = inside ? section_m[i - 1] - 2.0 * section_m[i] + section_m[i + 1] : kNan;
    second.push_back(std::abs(d));
    if (!std::isnan(d)) magnitudes.push_back(std::abs(d));
  }
  if (magnitudes.size() < 100) return std::nullopt;
  // A floor of 1 um keeps the rounding of float32 files out where a road is exactly flat.
  const double threshold = 8.0 * std::max(base::quantile(magnitudes, 0.5), 1e-6 / 8.0);
  double total = 0.0, in_kinks = 0.0;
  std::vector<std::size_t> kinks;
  for (std::size_t i = 0; i < second.size(); ++i) {
    if (std::isnan(second[i])) continue;
    total += second[i] * second[i];
    if (second[i] <= threshold) continue;
    in_kinks += second[i] * second[i];
    // A kink between two nodes shows at both of them: it counts once.
    if (kinks.empty() || i > kinks.back() + 1) kinks.push_back(i);
  }
  if (kinks.size() < 10 || in_kinks < 0.8 * total) return std::nullopt;
  std::vector<double> distances;
  for (std::size_t k = 1; k < kinks.size(); ++k)
    distances.push_back(static_cast<double>(kinks[k] - kinks[k - 1]) * step_m);
  std::sort(distances.begin(), distances.end());
  // Of the road's length: a corner that two edges of the mesh cross side by side is no facet of its
  // own.
  const double all_m = std::accumulate(distances.begin(), distances.end(), 0.0);
  const auto where = [&](double share) {
    double gone_m = 0.0;
    for (const double distance : distances)
      if ((gone_m += distance) >= share * all_m) return distance;
    return distances.back();
  };
  FacetSpacing spacing;
  spacing.median_m = where(0.5);
  spacing.p10_m = where(0.1);
  spacing.p90_m = where(0.9);
  spacing.kinks = kinks.size();
  spacing.kink_share = in_kinks / total;
  return spacing;
}

}  // namespace road
