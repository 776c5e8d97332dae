// Every mechanism there is. A new one is a file of this folder and its name here, twice.
#include <algorithm>

#include "mechanism.h"

namespace explain {

using OneFile = std::vector<Mechanism>();

// Each is defined in the file of its namespace's name.
// clang-format off
namespace stated_parameters { OneFile mechanisms; }
namespace wheel_radius { OneFile mechanisms; }
namespace sensors { OneFile mechanisms; }
namespace road_slopes { OneFile mechanisms; }
namespace road_friction { OneFile mechanisms; }
namespace road_misplaced { OneFile mechanisms; }
namespace contact { OneFile mechanisms; }
namespace turbo_lag { OneFile mechanisms; }
namespace actuators { OneFile late_pedals, late_steering; }
namespace brake_friction_temperature { OneFile mechanisms; }
namespace wind { OneFile mechanisms; }
namespace fuel_burn { OneFile mechanisms; }
namespace tyre_thermal { OneFile mechanisms; }
namespace tyre_terms { OneFile mechanisms; }
namespace aero_ride_height { OneFile mechanisms; }
namespace aero { OneFile mechanisms; }
namespace never_testable { OneFile mechanisms; }
namespace brake_disc_conductance { OneFile mechanisms; }
namespace differential { OneFile mechanisms; }
// clang-format on

const std::vector<Mechanism>& mechanisms() {
  // The order in which findings.json lists what was tested and what not.
  static const std::vector<Mechanism> all = [] {
    std::vector<Mechanism> out;
    for (OneFile* const file : {stated_parameters::mechanisms,
                                wheel_radius::mechanisms,
                                sensors::mechanisms,
                                road_slopes::mechanisms,
                                road_friction::mechanisms,
                                road_misplaced::mechanisms,
                                contact::mechanisms,
                                turbo_lag::mechanisms,
                                actuators::late_pedals,
                                brake_friction_temperature::mechanisms,
                                wind::mechanisms,
                                fuel_burn::mechanisms,
                                actuators::late_steering,
                                tyre_thermal::mechanisms,
                                tyre_terms::mechanisms,
                                aero_ride_height::mechanisms,
                                aero::mechanisms,
                                never_testable::mechanisms,
                                brake_disc_conductance::mechanisms,
                                differential::mechanisms})
      for (const Mechanism& m : file()) out.push_back(m);
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

void add_unlogged_states(recording::Recording& recording, const vehicle::Vehicle& car) {
  for (const Mechanism& m : mechanisms())
    if (m.add_state != nullptr) m.add_state(recording, car);
}

}  // namespace explain
