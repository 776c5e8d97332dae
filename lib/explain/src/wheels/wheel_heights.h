// Heights under the wheels, as the car itself measures them and as the road file has them.
#pragma once

#include <string>
#include <vector>

#include "explain/simulate.h"

namespace explain {

inline constexpr double kWaveCell_m = 10.0;  ///< of the road, for what even and odd laps agree on

/// One wheel at one sample; without slow parts, but for raw_m.
struct WheelHeight {
  double u_m, v_m, measured_m, file_m, strip_m;
  double raw_m;      ///< measured minus file with all slow parts in it
  std::size_t pass;  ///< one wheel on one lap
  int half;          ///< of the laps: even, odd
};

/// Appends the heights under the wheels of one recording to `out`. `strip`: through the contact
/// strip, in `only_cells`. A sentence when it cannot.
std::string wheel_heights(const RecordedLog& log, const Mapping& mapping,
                          const crg::Surface& surface, const vehicle::Vehicle& car, int first_lap,
                          bool strip, const std::vector<bool>& only_cells,
                          std::vector<WheelHeight>& out);

}  // namespace explain
