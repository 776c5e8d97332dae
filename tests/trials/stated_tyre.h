// The tyre file of the stated cars: the Magic Formula fitted to the truth's brush tyre, as a team
// fits one to its tyre tests.
#pragma once

#include <array>
#include <string>

namespace trials {

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
};

/// Fitted over slips up to 0.13 and loads of 0.3 to 1.3 of the nominal, weighted towards what is
/// driven. The forces differ by 2 % (RMS), -2 % at small slips, +2 to +3 % at 0.6 of the peak with
/// drive: the two tyres have no law in common.
std::string tir(const StatedTyre& tyre);

}  // namespace trials
