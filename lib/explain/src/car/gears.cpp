#include "gears.h"

#include <algorithm>
#include <cmath>

#include "vehicle/car.h"
#include "vehicle/driver.h"

namespace explain {

Gears gears_of(const Signals& s, const vehicle::Vehicle& car, double radius_m) {
  const auto has = [&](Channel c) { return s.present[c]; };
  const vehicle::Parameters<double>& p = car.parameters;
  Gears out;
  out.gear.assign(s.n, 1);
  out.shifting.assign(s.n, false);
  vehicle::Car<double> shell;  // only for choose_gear
  shell.files = &car.files;
  shell.parameters = p;
  shell.terms = car.terms;
  shell.static_radius_m = {radius_m, radius_m};
  int now = 1;
  for (std::size_t i = 0; i < s.n; ++i) {
    const double speed = s.x[kVx][i];
    if (has(kGear)) {
      const double gear = s.x[kGear][i];
      bool shifting = !(gear >= 1 && gear <= vehicle::kMostGears);
      for (std::size_t k = i > 5 ? i - 5 : 0; k < std::min(s.n, i + 4); ++k)
        shifting = shifting || s.x[kGear][k] != gear;
      if (gear >= 1 && gear <= vehicle::kMostGears) now = static_cast<int>(gear);
      out.shifting[i] = shifting;
    } else if (has(kEngine) && std::isfinite(speed)) {
      // Between two gears the clutch is open.
      const double wheel = has(kWheelRear) ? s.x[kWheelRear][i] / (s.wheels_in_mps ? radius_m : 1.0)
                                           : speed / radius_m;
      const double ratio = s.x[kEngine][i] / std::max(1.0, wheel);
      double nearest = 1e300;
      int gear = now;
      for (int k = 1; k <= vehicle::kMostGears; ++k) {
        const double stated = vehicle::overall_ratio(p, k);
        const double off = stated > 0 ? std::abs(std::log(ratio / stated)) : 1e300;
        if (off < nearest) nearest = off, gear = k;
      }
      out.shifting[i] = !(nearest < 0.05);
      if (!out.shifting[i]) now = gear;
    } else if (std::isfinite(speed)) {
      now = vehicle::choose_gear(shell, speed, now);
    }
    out.gear[i] = now;
  }
  return out;
}

}  // namespace explain
