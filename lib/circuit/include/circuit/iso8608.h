// Random road roughness with the displacement spectrum of a class of ISO 8608.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace road {

/// What roughness is wanted. Spectrum of ISO 8608 (annex B, displacement PSD over spatial
/// frequency):
///   Gd(n) = Gd(n0) * (n / n0)^-2,  n0 = 0.1 cycle/m,  Gd(n0) = 16e-6 m^3 * 4^(class - 'A')
/// (the geometric mean of the class; A..H), inside the band [n_min, n_max], nothing outside it.
struct RoughnessOptions {
  char iso_class = 'A';  ///< 'A' (smooth) .. 'H'
  std::uint64_t seed = 1;
  double n_min_cpm = 0.01;    ///< cycles/m; ISO 8608 asks for nothing below 0.01 on roads
  double n_max_cpm = 0.5;     ///< cycles/m; a mesh needs vertices closer than 1 / (4 n_max)
  int waves_per_octave = 24;  ///< harmonics drawn per octave; each carries the variance of its band
};

/// A fixed sum of waves: pure function of (u, v), periodic in u with `period_m`. Along any line of
/// constant v it has the wanted spectrum; two lines lose coherence with their distance because each
/// wave has its own lateral wave number, uniform in +-(its longitudinal one).
class Roughness {
 public:
  Roughness() = default;  ///< flat
  /// `period_m` > 1 / n_min. Throws Error on a class, band or period that cannot be used.
  Roughness(const RoughnessOptions& options, double period_m);

  double height_m(double u_m, double v_m) const noexcept;

  /// out[i * v.size() + j] += height at (u[i], v[j]); about 10x faster per point than height_m and
  /// within 1e-12 m of it. `out` has u.size() * v.size() values.
  void add_grid(std::span<const double> u_m, std::span<const double> v_m,
                std::span<double> out_m) const;

  std::size_t waves() const noexcept { return waves_.size(); }

 private:
  struct Wave {
    double amplitude_m, k_u_radpm, k_v_radpm, phase_rad;
  };
  std::vector<Wave> waves_;
};

/// The geometric mean Gd(n0) of a class in m^3. Throws Error when `iso_class` is not A..H.
double iso8608_psd_at_n0(char iso_class);

}  // namespace road
