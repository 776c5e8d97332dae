#include "vehicle/trend.h"

#include <cmath>
#include <limits>

namespace vehicle {

std::pair<double, double> trend(const std::vector<double>& time_s,
                                const std::vector<double>& values, std::size_t row,
                                std::size_t first) {
  double n = 0.0, st = 0.0, sv = 0.0, stt = 0.0, stv = 0.0;
  for (std::size_t i = row + 1; i-- > first && time_s[row] - time_s[i] <= kTrend_s + 1e-9;) {
    if (!std::isfinite(values[i])) continue;
    const double t = time_s[i] - time_s[row];
    n += 1.0;
    st += t;
    sv += values[i];
    stt += t * t;
    stv += t * values[i];
  }
  if (n < 1.0) return {std::numeric_limits<double>::quiet_NaN(), 0.0};
  const double spread = n * stt - st * st;
  if (n < 2.0 || spread <= 0.0) return {sv / n, 0.0};
  const double slope = (n * stv - st * sv) / spread;
  return {(sv - slope * st) / n, slope};
}

}  // namespace vehicle
