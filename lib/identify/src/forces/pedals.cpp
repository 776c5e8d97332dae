#include "pedals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "base/statistics.h"

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
    for (const Reading& m : rows[k].measured)
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

namespace {

constexpr double kLongest_s = 0.15;  // between rows at the stop: five rows of 50 Hz by chance
constexpr double kLeastNoisy = 0.2;  // of rows at rest; cut noise makes it half
constexpr double kFar = 4.0;         // times the noise

}  // namespace

AtStop at_stop(const std::vector<double>& time_s, const std::vector<double>& values, double stop) {
  AtStop out{std::vector<bool>(values.size(), false)};
  std::vector<double> noise;
  std::vector<std::size_t> between;
  std::size_t exact = 0, last = values.size();
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (values[k] != stop) continue;
    ++exact;
    out.row[k] = true;
    if (last < k && time_s[k] - time_s[last] <= kLongest_s)
      for (std::size_t i = last + 1; i < k; ++i)
        if (std::isfinite(values[i])) {
          between.push_back(i);
          noise.push_back(std::abs(values[i] - stop));
        }
    last = k;
  }
  if (static_cast<double>(between.size()) <
      kLeastNoisy * static_cast<double>(exact + between.size()))
    return {std::vector<bool>(values.size(), false)};
  if (noise.empty()) return out;
  // Half of a normal distribution has its median at 0.6745 standard deviations.
  out.noise = base::median(noise) / 0.6745;
  for (const std::size_t i : between) out.row[i] = std::abs(values[i] - stop) <= kFar * out.noise;
  return out;
}

}  // namespace identify
