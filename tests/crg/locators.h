// The tables for finding places on a line, without a road around them.
#pragma once

#include "locator.h"

namespace crg::test {

inline Locator locator_of(ReferenceLine line, double v_right_m, double v_left_m) {
  const bool joined = ends_joined(line);
  const Closing closing = closing_of(line);
  return {segment_records(line), line.u_step_m, v_right_m, v_left_m, joined, closing};
}

}  // namespace crg::test
