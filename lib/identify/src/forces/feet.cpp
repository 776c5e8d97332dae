#include "feet.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace identify {
namespace {

constexpr double kMovedWithin_s = 0.06;  // rows that tell how fast a foot moves
// Of the variance of a foot that is not recorded, what one at rest has.
constexpr double kAtRest = 0.01;

/// Variance of the steps of a channel from row to row, without that of its noise.
std::vector<double> step_variance(const std::vector<double>& values, double noise, double step_s) {
  const auto reach = static_cast<std::size_t>(std::max(2.0, std::round(kMovedWithin_s / step_s)));
  std::vector<double> out(values.size(), 0.0);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::size_t from = k > reach ? k - reach : 0, to = std::min(values.size() - 1, k + reach);
    double sum = 0.0;
    for (std::size_t i = from + 1; i <= to; ++i) sum += std::pow(values[i] - values[i - 1], 2);
    if (to > from)
      out[k] = std::max(0.0, sum / static_cast<double>(to - from) - 2.0 * noise * noise);
  }
  return out;
}

/// What a sensor measured, by row; between its rows on a straight line.
std::vector<double> measured_by(std::size_t sensor, const std::vector<double>& time_s,
                                const std::vector<SmootherRow>& rows) {
  std::vector<double> out(rows.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < rows.size(); ++k)
    for (const Measured& m : rows[k].measured)
      if (m.sensor == sensor) out[k] = m.value;
  return recording::fill_gaps(time_s, out);
}

}  // namespace

void move_feet(const recording::Recording& recording, ForceChannels& out) {
  const std::vector<double>& time = *recording.table.find("time_s");
  for (std::size_t at = 0; at < out.sensors.size(); ++at) {
    const Sensor& s = out.sensors[at];
    if (s.seen || s.place < kPlaceThrottle || s.place >= kPlaceParts) continue;
    const std::vector<double> values = measured_by(at, time, out.rows);
    const std::vector<double> moves = step_variance(values, s.deviation, recording.step_s);
    for (std::size_t k = 0; k < values.size(); ++k) {
      double& noise = out.rows[k].noise[static_cast<Eigen::Index>(s.place)];
      noise = std::max(moves[k], kAtRest * noise);
      if (k + 1 == values.size() || !(moves[k] > 0.0)) continue;
      const double moved = moves[k] / (moves[k] + 2.0 * s.deviation * s.deviation);
      out.rows[k].driven.feet_per_s[s.place - kPlaceThrottle] =
          moved * (values[k + 1] - values[k]) / (time[k + 1] - time[k]);
    }
  }
}

}  // namespace identify
