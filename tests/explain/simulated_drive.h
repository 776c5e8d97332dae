// The simulated car on a plane, stopping again and again in gentle bends, as a log of 20 Hz.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "support/places.h"
#include "vehicle/driver.h"
#include "vehicle/step.h"
#include "vehicle/vehicle_file.h"

namespace explain_test {

struct Drive {
  std::vector<double> time_s, vx_mps, yaw_rate_radps, throttle, engine_radps;
  std::vector<double> front_pa, rear_pa, front_disc_k, rear_disc_k;  ///< means of left and right
  std::vector<double> boost, pad_heat_j, tyre_warmth;                ///< that no log has
};

inline vehicle::Vehicle racer() {
  return vehicle::read_vehicle(places::source() + "/vehicles/open_wheel/vehicle.yaml");
}

inline Drive stop_and_go(const vehicle::Vehicle& v, double seconds) {
  const auto car = vehicle::make_car(v.files, v.parameters, v.terms, v.contact);
  const vehicle::Road road;
  vehicle::StartOptions begin;
  begin.speed_mps = 40;
  begin.gear = vehicle::choose_gear(car, 40, 6);
  auto sim = vehicle::start(car, road, begin);
  vehicle::Detail<double> detail{};
  vehicle::Controls<double> c;
  c.gear_command = begin.gear;
  Drive out;
  bool braking = false;
  for (int i = 0; i < static_cast<int>(seconds * 1000); ++i) {
    const double v_mps = sim.state[vehicle::kVx];
    braking = braking ? v_mps > 22 : v_mps > 55;
    c.throttle_command = braking ? 0.0 : 0.8;
    c.brake_command_pa = {};
    if (braking) c.brake_command_pa = {1e6, 1e6, 6e5, 6e5};  // little slip
    c.steer_command_rad = 0.01 * std::sin(1.3 * sim.time_s);
    c.gear_command = vehicle::choose_gear(car, v_mps, c.gear_command);
    const auto s = sim.state;
    if (!vehicle::step(car, sim, c, road, {}, detail).ok()) break;
    if (i % 50 != 0) continue;
    const auto mean = [&](std::size_t first) { return 0.5 * (s[first] + s[first + 1]); };
    out.time_s.push_back(0.001 * i);
    out.vx_mps.push_back(s[vehicle::kVx]);
    out.yaw_rate_radps.push_back(s[vehicle::kYawRate]);
    out.throttle.push_back(detail.inputs.throttle);
    out.engine_radps.push_back(s[vehicle::kEngine]);
    out.front_pa.push_back(detail.inputs.brake_pa[0]);
    out.rear_pa.push_back(detail.inputs.brake_pa[2]);
    out.front_disc_k.push_back(mean(vehicle::kDiscSurface));
    out.rear_disc_k.push_back(mean(vehicle::kDiscSurface + 2));
    out.boost.push_back(s[vehicle::kBoost]);
    out.pad_heat_j.push_back(s[vehicle::kPadHeat]);
    out.tyre_warmth.push_back(s[vehicle::kTyreWarmth]);
  }
  return out;
}

/// Root mean square of the difference of two series of the same length: pressure and throttle jump
/// between two samples of 50 ms, so single ones may be far apart.
inline double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return a.size() == b.size() ? std::sqrt(sum / static_cast<double>(a.size())) : HUGE_VAL;
}

}  // namespace explain_test
