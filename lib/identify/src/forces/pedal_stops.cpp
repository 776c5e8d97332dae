#include "pedal_stops.h"

#include <cmath>
#include <cstddef>

#include "base/statistics.h"

namespace identify {
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
