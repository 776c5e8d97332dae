// The tyre file of the stated cars: the Magic Formula fitted to the truth's brush tyre, as a team
// fits one to its tyre tests.
#pragma once

#include <array>
#include <string>

namespace trials {

/// A Magic Formula fitted to a law of the truth: peaks, slopes, curves and bends along and across,
/// what changes with the load, widths of combined slip.
struct TyreFit {
  double peak_x, slope_x, slope_x_load, curve_x, bend_x;
  double peak_y, slope_y, load_y, curve_y, bend_y;
  double loss;  ///< of peak with load, over the truth's at its nominal load
  double rbx1, rbx2, rcx1, rby1, rby2, rcy1;
};
/// The second car's brush, over slips up to 0.13 and loads of 0.3 to 1.3 of the nominal, weighted
/// towards what is driven. The forces differ by 2 % (RMS), -2 % at small slips, +2 to +3 % at 0.6
/// of the peak with drive: the two tyres have no law in common.
inline constexpr TyreFit kParabolicBrush{1.03,  0.924, 0,    1.221, 0.28, 1.03, 0.924, 3,   1.303,
                                         0.376, 1,     15.7, 17.9,  0.93, 21.6, 17.8,  0.85};

struct StatedTyre {
  double
      load_n = 0,
      grip = 0, grip_per_load = 0, cornering = 0,
      slip =
          0;  ///< of the brush tyre: nominal load, peak, its loss with load, stiffnesses per load
  double radius_m = 0, relaxation_m = 0;
  std::array<double, 8> shape{1, 1, 1, 1, 1,
                              1, 1, 1};  ///< factors on the fitted shape: curve and bend along and
                                         ///< across, widths of combined slip
  const TyreFit* fit = &kParabolicBrush;
};

std::string tir(const StatedTyre& tyre);

}  // namespace trials
