#include "explain/gyro_or_banking.h"

namespace explain {

void tie_gain_with_banking(const Signals& log, Findings& findings) {
  if (!log.present[kYawRate] || (log.present[kAy] && log.present[kVy])) return;
  for (Finding& f : findings.findings) {
    if (!is_about(f, kSensorGain) || f.channel != log.column[kYawRate] || f.parameters.empty() ||
        f.parameters[0].value >= 0.0)
      continue;
    f.rivals.push_back({kRoad[0].id, "",
                        "survey the cross slope where the road turns, or log lateral acceleration",
                        f.cv_gain, false});
    f.not_used = "a road that leans where it turns shows the same";
  }
}

}  // namespace explain
