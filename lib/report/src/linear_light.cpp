#include <algorithm>
#include <cmath>

#include "report/mean_colour.h"

namespace report {

double linear_light(double coded_255) {
  const double coded = std::clamp(coded_255 / 255.0, 0.0, 1.0);
  return coded <= 0.04045 ? coded / 12.92 : std::pow((coded + 0.055) / 1.055, 2.4);
}

}  // namespace report
