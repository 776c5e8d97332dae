#include "explain/gyro_or_banking.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace explain {
namespace {

/// The lean that takes so much of the yaw rate.
double lean_of(double gain) {
  const double cosine = std::clamp(1 + gain, 0.1, 1.0);
  return std::sqrt(1 - cosine * cosine) / cosine;
}

bool turns_left(const Signals& log) {
  double sum = 0.0;
  for (const double turning : log.x[kYawRate])
    if (std::isfinite(turning)) sum += turning;
  return sum > 0;
}

}  // namespace

void call_banking(Finding& f) {
  f.mechanism = kRoad[0].id;
  f.kind = "road";
  f.channel = "";
  f.physics = "the road leans into its turns more (or less) than the file says";
  f.equation = "yaw rate = d(heading)/dt cos(banking)";
}

void add_gain_as_equal(Finding& f, const std::string& column, double gain, double cv_gain) {
  f.rivals.push_back({kSensorGain, column,
                      "survey the cross slope where the road turns, or log lateral acceleration",
                      cv_gain, false});
  f.not_used = fmt::format("a gain of '{}' of {:.1f} % shows the same", column, 100 * gain);
}

void tie_gain_with_banking(const Signals& log, Findings& findings) {
  if (!log.present[kYawRate] || (log.present[kAy] && log.present[kVy])) return;
  for (Finding& f : findings.findings) {
    if (!is_about(f, kSensorGain) || f.channel != log.column[kYawRate] || f.parameters.empty() ||
        f.parameters[0].value >= 0.0)
      continue;
    const FoundParameter gain = f.parameters[0];
    call_banking(f);
    add_gain_as_equal(f, log.column[kYawRate], gain.value, f.cv_gain);
    const double most = lean_of(gain.low), least = lean_of(gain.high), lean = lean_of(gain.value);
    const std::string name = std::string(kRoad[0].name) + ", in the turns";
    if (turns_left(log))
      f.parameters = {{name, kRoad[0].unit, -lean, -most, -least}};
    else
      f.parameters = {{name, kRoad[0].unit, lean, least, most}};
  }
}

}  // namespace explain
