// A road for scans that are made and read again.
#pragma once

#include <cmath>
#include <string>

#include "crg/file.h"

namespace support {

/// Writes 200 m of a wavy road that bends nowhere, 10 m wide, in steps of 0.2 m.
inline void write_wavy_road(const std::string& path) {
  crg::ReferenceLine line;
  line.u_step_m = 0.2;
  crg::Grid grid;
  grid.u_step_m = line.u_step_m;
  for (int j = -25; j <= 25; ++j) grid.v_m.push_back(0.2 * j);
  for (int i = 0; i <= 1000; ++i) {
    line.x_m.push_back(0.2 * i), line.y_m.push_back(0.0), line.heading_rad.push_back(0.0);
    for (const double v : grid.v_m)
      grid.z_m.push_back(static_cast<float>(0.3 * std::sin(0.01 * i) + 0.02 * v +
                                            0.01 * std::sin(0.2 * i) * std::cos(v)));
  }
  crg::write(crg::make_crg(line, grid), path, crg::Format::KRBI);
}

}  // namespace support
