// Every mechanism there is. A new one is a file of this folder and its name here, twice.
#include <algorithm>

#include "mechanism.h"

namespace explain {

using Room = std::vector<Mechanism>();

// Each is defined in the file of its name, but for the actuators of pedals and steering, which
// share one.
Room stated_parameters, wheel_radius, sensors, road_slopes, road_friction, road_misplaced, contact,
    turbo_lag, late_pedals, brake_friction_temperature, wind, fuel_burn, late_steering,
    tyre_thermal, tyre_terms, aero_ride_height, aero, never_testable, brake_disc_conductance,
    differential;

const std::vector<Mechanism>& mechanisms() {
  // The order in which findings.json lists what was tested and what not.
  static const std::vector<Mechanism> all = [] {
    std::vector<Mechanism> out;
    for (Room* const room : {stated_parameters,
                             wheel_radius,
                             sensors,
                             road_slopes,
                             road_friction,
                             road_misplaced,
                             contact,
                             turbo_lag,
                             late_pedals,
                             brake_friction_temperature,
                             wind,
                             fuel_burn,
                             late_steering,
                             tyre_thermal,
                             tyre_terms,
                             aero_ride_height,
                             aero,
                             never_testable,
                             brake_disc_conductance,
                             differential})
      for (const Mechanism& m : room()) out.push_back(m);
    return out;
  }();
  return all;
}

const Mechanism* find_mechanism(std::string_view id) {
  const auto& all = mechanisms();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Mechanism& m) { return m.id == id; });
  return found == all.end() ? nullptr : &*found;
}

void join_components(Findings& findings) {
  std::vector<Finding>& all = findings.findings;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Mechanism* const m = find_mechanism(all[k].mechanism);
    if (m == nullptr || !m->by_components) continue;
    for (std::size_t l = all.size(); l-- > k + 1;) {
      Finding &a = all[k], &b = all[l];
      if (a.mechanism != b.mechanism || a.channel != b.channel) continue;
      a.parameters.insert(a.parameters.end(), b.parameters.begin(), b.parameters.end());
      all.erase(all.begin() + static_cast<std::ptrdiff_t>(l));
    }
  }
}

Turn turn_of(const Finding& f) {
  const Mechanism* const m = find_mechanism(f.mechanism);
  return m == nullptr ? Turn::kUsual : m->turn;
}

void forget_untestable(Findings& findings, std::string_view id) {
  std::erase_if(findings.untestable, [&](const Untestable& u) { return u.mechanism == id; });
}

Finding finding_of(const Mechanism& m) {
  Finding out;
  out.mechanism = m.id;
  out.kind = m.kind();
  out.physics = m.physics;
  out.equation = m.equation;
  return out;
}

void add_unlogged_states(vehicle::Recording& recording, const vehicle::Vehicle& car) {
  for (const Mechanism& m : mechanisms())
    if (m.add_state != nullptr) m.add_state(recording, car);
}

}  // namespace explain
