// Residuals at one setting and at many: first what needs no car, then with the car that is led.
#include "relations.h"

namespace explain {

Residuals residuals(const Signals& s, const vehicle::Vehicle& car, const Setting& set,
                    const Drives& drives) {
  Relations c(s, car, set);
  c.compare_commands();
  c.compare_motion();
  if (drives.none) {
    c.compare_accelerometer(drives.known != nullptr ? drives.known->led : Led{});
    if (drives.known != nullptr) c.compare_force_along(drives.known->led);
    return std::move(c).out();
  }
  // What lib/vehicle's car would do there.
  const bool known = drives.known != nullptr && same_drive(*drives.known, set, c.by());
  const Guided one{&set, &c.by()};
  const Led led = known ? drives.known->led : lead(s, car, std::span(&one, 1), drives.tick).front();
  if (drives.keep != nullptr) *drives.keep = {set, c.by(), led};
  c.compare_accelerometer(led);
  c.compare_forces(led);
  return std::move(c).out();
}

bool needs_drive(const Signals& s, const vehicle::Vehicle& car, const Setting& set,
                 const KnownDrive& known) {
  Relations c(s, car, set);
  c.compare_motion();
  return !same_drive(known, set, c.by());
}

std::vector<Residuals> residuals(const Signals& s, const vehicle::Vehicle& car,
                                 std::span<const Setting* const> settings, const KnownDrive& known,
                                 const std::function<void()>& tick) {
  std::vector<Residuals> out(settings.size());
  std::vector<Relations> on_the_way;
  on_the_way.reserve(settings.size());
  std::vector<std::size_t> place;
  std::vector<const Setting*> driven;
  for (std::size_t k = 0; k < settings.size(); ++k) {
    Relations c(s, car, *settings[k]);
    c.compare_commands();
    c.compare_motion();
    if (same_drive(known, *settings[k], c.by())) {
      c.compare_accelerometer(known.led);
      c.compare_forces(known.led);
      out[k] = std::move(c).out();
      continue;
    }
    on_the_way.push_back(std::move(c));
    place.push_back(k);
    driven.push_back(settings[k]);
  }
  for (const std::vector<std::size_t>& convoy : convoys(s, car, driven)) {
    std::vector<Guided> cars;
    cars.reserve(convoy.size());
    for (const std::size_t k : convoy) cars.push_back({driven[k], &on_the_way[k].by()});
    const std::vector<Led> led = lead(s, car, cars, tick);
    for (std::size_t n = 0; n < convoy.size(); ++n) {
      Relations& c = on_the_way[convoy[n]];
      c.compare_accelerometer(led[n]);
      c.compare_forces(led[n]);
      out[place[convoy[n]]] = std::move(c).out();
    }
  }
  return out;
}

}  // namespace explain
