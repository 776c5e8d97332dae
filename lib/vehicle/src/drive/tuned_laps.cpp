#include <algorithm>
#include <cmath>

#include "vehicle/lap.h"

namespace vehicle {

TunedLaps drive_laps_tuned(const Car<double>& car, const Road& road, LapOptions options,
                           Margin margin) {
  const auto keeps_its_line = [](const LapResult& r) {
    return r.complete && r.steps_off_road == 0 && r.limit.empty();
  };
  double &usage = options.speed.grip_usage, &margin_m = options.line.margin_m;
  const double first_usage = usage;
  TunedLaps first{drive_laps(car, road, options), usage, margin_m};
  if (keeps_its_line(first.result)) return first;
  // To the hundredth, so that what is printed drives the same to the bit.
  const auto less = [&] { return std::round(100.0 * usage - 10.0) / 100.0; };
  for (usage = less(); usage >= kLeastGripUsage; usage = less()) {
    TunedLaps next{drive_laps(car, road, options), usage, margin_m};
    if (keeps_its_line(next.result)) return next;
  }
  if (margin == Margin::as_given) return first;
  // Farther from kerbs and from what the edges of a mesh throw up.
  const double widest_m = largest_margin_m(*road.surface(), options.line);
  margin_m = std::min(2.0 * margin_m, std::floor(100.0 * widest_m) / 100.0);
  if (margin_m <= first.margin_m) return first;
  for (usage = first_usage; usage >= kLeastGripUsage; usage = less()) {
    TunedLaps next{drive_laps(car, road, options), usage, margin_m};
    if (keeps_its_line(next.result)) return next;
  }
  return first;
}

}  // namespace vehicle
