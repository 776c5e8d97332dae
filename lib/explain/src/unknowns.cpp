#include "explain/unknowns.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "plausible.h"
#include "unknowns_listing.h"

namespace explain {
namespace {

bool any(const std::vector<Signals>& logs, Channel c) {
  return std::any_of(logs.begin(), logs.end(), [&](const Signals& s) { return s.present[c]; });
}

void limit_amounts(std::vector<Unknown>& unknowns) {
  static const std::vector<std::pair<std::string, double>> kMost{
      {"sensor.gain", 0.5},
      {"sensor.delay", 1.0},
      {"sensor.low_pass", 5.0},
      {"sensor.misalignment", 0.3},
      {"sensor.lever_arm", 4.0},
      {"sensor.derived", 1.4},
      {"road.banking", 0.7},
      {"road.grade", 0.2},
      {"road.friction", 0.6},
      {"vehicle.turbo_lag", 1.25},
      {"vehicle.throttle_dead_time", 0.5},
      {"vehicle.brake_dead_time", 0.5},
      {"vehicle.steering_dead_time", 0.3},
      {"vehicle.steering_lag", 0.5},
      {"vehicle.tyre_thermal", 0.6},
      {"vehicle.tyre_load_sensitivity", 6.0},
      {"vehicle.tyre_camber", 10.0},
      {"vehicle.tyre_combined_slip", 3.0},
      {"vehicle.tyre_relaxation", 15.0},
      {"vehicle.aero_drag", 3.0},
      {"vehicle.aero_downforce", 3.0},
      {"vehicle.aero_ride_height", 0.8},
      {"vehicle.brake_friction_temperature", 0.9},
      {"environment.wind", 25.0},
      {"vehicle.fuel_burn", 0.6},
      {"vehicle.differential", 1.3}};
  for (Unknown& u : unknowns)
    for (const auto& [id, most] : kMost)
      if (u.id == id) u.most = most;
}

// One lap shows every place once: nothing comes back there.
void drop_places_seen_once(const Listing& l) {
  double rounds = 0.0;
  bool closed = false;
  for (const Signals& s : l.logs) {
    rounds += s.rounds;
    closed = closed || s.closed;
  }
  if (!closed || rounds >= kTwoRounds) return;
  for (const Unknown& u : l.out.unknowns)
    if (u.along_road) untestable(l, {u.id.c_str()}, "less than two laps");
  std::erase_if(l.out.unknowns, [](const Unknown& u) { return u.along_road; });
}

}  // namespace

bool has(const Listing& l, Channel c) { return any(l.logs, c); }

const std::string& column(const Listing& l, Channel c) {
  for (const Signals& s : l.logs)
    if (s.present[c]) return s.column[c];
  return l.logs.front().column[c];
}

void untestable(const Listing& l, std::initializer_list<const char*> ids,
                const std::string& reason) {
  for (const char* id : ids) l.out.untestable.push_back({id, reason});
}

Unknown& candidate(const Listing& l, const std::string& id, const Amount& amount,
                   const Physics& physics, std::function<void(Setting&, double)> set) {
  Unknown u;
  u.id = id;
  u.kind = id.substr(0, id.find('.'));
  u.name = amount.name;
  u.unit = amount.unit;
  u.step = amount.step;
  u.least = amount.least;
  u.one_sided = amount.one_sided;
  u.physics = physics.text;
  u.equation = physics.equation;
  u.separating = physics.separating;
  u.set = std::move(set);
  return l.out.unknowns.emplace_back(std::move(u));
}

const std::vector<std::string>& mechanism_ids() {
  static const std::vector<std::string> ids{
      "road.banking", "road.grade", "road.vertical_curvature", "road.kerb_or_roughness", "road.friction",
      "road.misplaced", "vehicle.turbo_lag", "vehicle.throttle_dead_time", "vehicle.brake_dead_time",
      "vehicle.steering_dead_time", "vehicle.steering_lag", "vehicle.tyre_thermal",
      "vehicle.tyre_load_sensitivity", "vehicle.tyre_camber", "vehicle.tyre_combined_slip",
      "vehicle.tyre_relaxation", "vehicle.aero_drag", "vehicle.aero_downforce", "vehicle.aero_ride_height",
      "vehicle.aero_slipstream", "environment.wind", "vehicle.brake_friction_temperature",
      "vehicle.brake_disc_conductance", "vehicle.multi_point_contact", "vehicle.differential",
      "vehicle.mass", "vehicle.fuel_burn", "sensor.bias", "sensor.gain", "sensor.delay",
      "sensor.low_pass", "sensor.misalignment", "sensor.lever_arm", "sensor.derived", "parameter.mass", "parameter.cog",
      "parameter.yaw_inertia", "parameter.drag", "parameter.downforce", "parameter.engine_torque",
      "parameter.throttle_gain", "parameter.brake_gain", "parameter.tyre_grip",
      "parameter.tyre_stiffness", "parameter.wheel_radius", "parameter.steering_ratio"};
  return ids;
}

Inventory inventory(const std::vector<Signals>& logs, const vehicle::Vehicle& car) {
  Inventory out;
  const Listing l{.logs = logs,
                  .car = car,
                  .engine = any(logs, kThrottle),
                  .brake = any(logs, kBrakeFront),
                  .lateral = any(logs, kVy) && any(logs, kSteer),
                  .out = out};
  list_parameters(l);
  list_wheel_radii(l);
  list_curves(l);
  list_sensors(l);
  list_road(l);
  list_physics(l);
  limit_amounts(out.unknowns);
  drop_places_seen_once(l);
  return out;
}

}  // namespace explain
