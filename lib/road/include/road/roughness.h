// How rough a long section is: spectrum, ISO 8608 class, IRI, and the facets of the mesh behind it.
//
// A long section is one line of heights with equal steps, e.g. the path of a wheel. NaN marks
// missing heights; everything here works on the pieces between them.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace road {

/// One-sided displacement spectral density over spatial frequency.
struct DisplacementPsd {
  std::vector<double> n_cpm;   ///< cycles per metre, ascending, without 0
  std::vector<double> psd_m3;  ///< m^2 / (cycle/m); same length
  std::size_t segments =
      0;  ///< averaged; 0 = the section has no piece long enough, vectors are empty
};

struct PsdOptions {
  double segment_m =
      400.0;  ///< rounded to a power of two of samples; shorter sections halve it, down to 50 m
};

/// Welch's method (IEEE Trans. Audio Electroacoust. 15, 1967): segments that overlap by half,
/// straight line removed, Hann window, periodograms averaged. Parseval holds: the integral over n
/// is the variance of the detrended section. The sections (e.g. both wheels) are averaged into one
/// density. `step_m` > 0.
DisplacementPsd displacement_psd(std::span<const std::vector<double>> sections_m, double step_m,
                                 const PsdOptions& options = {});

struct Iso8608Options {
  double n_min_cpm = 0.03;  ///< below, hills of the track's design outweigh roughness
  double n_max_cpm = 2.83;  ///< upper end of the band that ISO 8608 reports for roads
};

/// Class of ISO 8608:2016, annex C: straight line Gd(n) = Gd(n0) (n / n0)^-w through the smoothed
/// density in log-log axes, n0 = 0.1 cycle/m.
struct Iso8608Fit {
  char iso_class = 'A';       ///< 'A'..'H' by Gd(n0): A below 32e-6 m^3, then limits 4 times apart
  double psd_at_n0_m3 = 0.0;  ///< Gd(n0) of the fitted line
  double exponent = 2.0;      ///< w; ISO 8608 classes assume 2
  double n_min_cpm = 0.0;     ///< band that was fitted
  double n_max_cpm = 0.0;
  bool band_cut =
      false;  ///< the spectrum ends before n_max_cpm of the options (resolution of the source)
};

/// Means of the density over third-octave bands around n0 * 2^(k/3).
struct PsdBand {
  double n_cpm = 0.0;  ///< band centre
  double psd_m3 = 0.0;
};
std::vector<PsdBand> third_octave_bands(const DisplacementPsd& psd);

/// Least squares through the third-octave bands inside the options' band. The band ends early where
/// a third-octave falls below a tenth of what exponent 2 predicts from the one before: there the
/// source (mesh, filter) holds no more waves. Empty with fewer than 5 bands.
std::optional<Iso8608Fit> fit_iso8608(const DisplacementPsd& psd,
                                      const Iso8608Options& options = {});

/// International Roughness Index in m/km (= mm/m): mean rectified velocity of the suspension of
/// Sayers' reference quarter car at 80 km/h per speed. Constants (k1 = 653, k2 = 63.3 1/s^2, mu =
/// 0.15, c = 6 1/s), moving base of 250 mm and start with the mean slope of the first 11 m: Sayers,
/// Gillespie, Queiroz, World Bank Technical Paper 46 (1986), annex A. Steps are exact (matrix
/// exponential with slope constant over a step). Wants `step_m` <= 0.3; larger steps lose waves.
struct IriSegment {
  double begin_m = 0.0, end_m = 0.0;  ///< along the section, from its first value
  double iri_m_per_km = 0.0;          ///< NaN where heights are missing
};

/// Segments of `length_m`; a last piece shorter than half of that joins its neighbour.
std::vector<IriSegment> iri(std::span<const double> section_m, double step_m,
                            double length_m = 100.0);

/// The transition of the reference quarter car over one step: state (zs', zu slopes and their
/// derivatives over time t = x / V in s) x[i+1] = transition * x[i] + input * slope.
struct QuarterCarStep {
  double transition[4][4];
  double input[4];
};
QuarterCarStep quarter_car_step(double step_m);

/// Kinks that the facets of a mesh leave in a section.
struct FacetSpacing {
  double median_m = 0.0, p10_m = 0.0, p90_m = 0.0;  ///< between kinks; shares of the length
  std::size_t kinks = 0;
  double kink_share = 0.0;  ///< of the sum of squared second differences; near 1: flat facets
};

/// Empty when the section bends evenly, i.e. kinks (second difference above 8 times its median)
/// hold less than 80 % of the squared second differences, or fewer than 10 exist. A Gaussian
/// profile keeps less than 1 % there.
std::optional<FacetSpacing> facet_spacing(std::span<const double> section_m, double step_m);

}  // namespace road
