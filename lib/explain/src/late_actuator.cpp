#include "late_actuator.h"

#include <algorithm>
#include <array>

namespace explain {

const LateActuator* late_actuator(const std::string& mechanism) {
  using P = vehicle::Parameter;
  using vehicle::Term;
  static const std::array<LateActuator, 3> all{
      {{"throttle_actuator", Term::throttle_actuator, kThrottle, P::throttle_gain, P::throttle_dead_time_s, P::throttle_lag_s, P::throttle_damping, P::throttle_lead_s},
       {"brake_actuator", Term::brake_actuator, kBrakeFront, P::brake_gain, P::brake_dead_time_s, P::brake_lag_s, P::brake_damping, P::brake_lead_s},
       {"steering_actuator", Term::steering_actuator, kSteer, P::steering_ratio, P::steering_dead_time_s, P::steering_lag_s, P::steering_damping, P::steering_lead_s}}};
  if (mechanism == "vehicle.throttle_dead_time") return &all[0];
  if (mechanism == "vehicle.brake_dead_time") return &all[1];
  if (mechanism == "vehicle.steering_dead_time" || mechanism == "vehicle.steering_lag") return &all[2];
  return nullptr;
}

bool commanded(const std::vector<Signals>& logs, Channel c) {
  return std::any_of(logs.begin(), logs.end(), [&](const Signals& s) { return s.present[c] && s.commanded[c]; });
}

}  // namespace explain
