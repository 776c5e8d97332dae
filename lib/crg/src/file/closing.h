// How the two ends of a reference line meet when the file asks for a closed track.
#pragma once

#include <optional>

#include "crg/reference_line.h"

namespace crg {

/// Lengths by which the ends are extended along their headings until they meet; >= 0.
struct Closing {
  double before_start_m = 0.0;
  double after_end_m = 0.0;
};

/// Empty when the ends do not meet: headings more than 60 degrees apart, or the extended end does
/// not lie before the start. Gaps of zero are accepted.
std::optional<Closing> find_closing(const ReferenceLine& line);

/// Of a line that is closed; no lengths for others.
Closing closing_of(const ReferenceLine& line);

}  // namespace crg
