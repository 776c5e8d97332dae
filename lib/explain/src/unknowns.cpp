#include "explain/unknowns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace explain {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

bool any(const std::vector<Signals>& logs, Channel c) {
  return std::any_of(logs.begin(), logs.end(), [&](const Signals& s) { return s.present[c]; });
}
bool commanded(const std::vector<Signals>& logs, Channel c) {
  return std::any_of(logs.begin(), logs.end(), [&](const Signals& s) { return s.present[c] && s.commanded[c]; });
}
const std::string& column(const std::vector<Signals>& logs, Channel c) {
  for (const Signals& s : logs)
    if (s.present[c]) return s.column[c];
  return logs.front().column[c];
}

}  // namespace

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
      "sensor.low_pass", "sensor.misalignment", "sensor.lever_arm", "parameter.mass", "parameter.cog",
      "parameter.yaw_inertia", "parameter.drag", "parameter.downforce", "parameter.engine_torque",
      "parameter.throttle_gain", "parameter.brake_gain", "parameter.tyre_grip",
      "parameter.tyre_stiffness", "parameter.wheel_radius", "parameter.steering_ratio"};
  return ids;
}

Inventory inventory(const std::vector<Signals>& logs, const vehicle::Vehicle& car) {
  Inventory out;
  const auto no = [&](const char* id, std::string reason) { out.untestable.push_back({id, std::move(reason)}); };
  const bool engine = any(logs, kThrottle), brake = any(logs, kBrakeFront);
  const bool lateral = any(logs, kVy) && any(logs, kSteer);

  // Parameters of the stated car.
  const auto parameter = [&](const char* id, const char* name, std::vector<P> which, double form_share) {
    Unknown u;
    u.id = id;
    u.kind = "parameter";
    u.name = name;
    u.role = Role::kParameter;
    const auto index = static_cast<std::size_t>(which.front());
    const double value = car.parameters.value[index];
    u.stated = value;
    u.assumed = car.assumed[index];
    u.unit = std::string(vehicle::parameter_list()[index].unit);
    u.width = car.prior[index] * (value != 0 ? std::abs(value) : 1.0);
    u.step = 0.02 * std::abs(value) + 1e-9;
    u.form = form_share * std::abs(value);
    u.physics = fmt::format("the stated {} is off", name);
    u.equation = fmt::format("{} = stated + change", name);
    // The others change by the same share as the first.
    u.set = [which, value](Setting& s, double amount) {
      for (const P p : which) s.p[p] *= 1.0 + amount / value;
    };
    out.unknowns.push_back(u);
  };
  if (engine || lateral) {
    parameter("parameter.mass", "chassis.mass_kg", {P::chassis_mass_kg}, 0.015);
    if (!any(logs, kLoadFront) && !any(logs, kLoadRear)) {
      // Nothing else gives forces a scale: torque, brakes and drag that are off alike are the same, and less likely.
      out.unknowns.back().held = 0.01 * car.parameters[P::chassis_mass_kg];
      no("parameter.mass", "held near its stated value: without wheel loads only torque, brakes and drag that are off alike would speak for another mass");
    }
  }
  else no("parameter.mass", "neither throttle nor steering with lateral speed is logged");
  if (engine) {
    parameter("parameter.drag", "aero.drag_area_m2", {P::aero_drag_area_m2}, 0.025);
    parameter("parameter.engine_torque", "engine.torque", {P::engine_torque}, 0.01);
    parameter("parameter.throttle_gain", "throttle.gain", {P::throttle_gain}, 0.01);
  } else {
    for (const char* id : {"parameter.drag", "parameter.engine_torque", "parameter.throttle_gain"}) no(id, "no throttle in the log");
  }
  if (brake && engine) parameter("parameter.brake_gain", "brake.gain", {P::brake_gain}, 0.015);
  else no("parameter.brake_gain", "no brake pressure or no throttle in the log");
  if (lateral) {
    parameter("parameter.cog", "chassis.cog_behind_front_m", {P::chassis_cog_behind_front_m}, 0.01);
    parameter("parameter.yaw_inertia", "chassis.yaw_inertia_kgm2", {P::chassis_yaw_inertia_kgm2}, 0.1);
    // What curves of tyres get wrong in transients is more than what it would move.
    out.unknowns.back().held = 0.005 * car.parameters[P::chassis_yaw_inertia_kgm2];
    out.unknowns.back().stays_held = true;
    no("parameter.yaw_inertia", "held near its stated value: errors of the tyre curves in transients are larger than its effect");
    parameter("parameter.downforce", "front.lift_area_m2", {P::front_lift_area_m2}, 0.04);
    parameter("parameter.downforce", "rear.lift_area_m2", {P::rear_lift_area_m2}, 0.04);
    // What the stated tyre's shape gets wrong, and what drive takes away where the stated car says that it takes nothing.
    const double grip_form = car.terms[Term::tyre_combined_slip] > 0 ? 0.045 : 0.1;
    parameter("parameter.tyre_grip", "front.tyre_grip", {P::front_tyre_grip}, grip_form);
    parameter("parameter.tyre_grip", "rear.tyre_grip", {P::rear_tyre_grip}, grip_form);
    parameter("parameter.tyre_stiffness", "front.tyre_cornering_stiffness", {P::front_tyre_cornering_stiffness}, 0.012);
    parameter("parameter.tyre_stiffness", "rear.tyre_cornering_stiffness", {P::rear_tyre_cornering_stiffness}, 0.02);
    if (commanded(logs, kSteer)) parameter("parameter.steering_ratio", "steering.ratio", {P::steering_ratio}, 0.02);
    else no("parameter.steering_ratio", "the log has the road wheels' angle itself: see sensor.gain of it");
  } else {
    for (const char* id : {"parameter.cog", "parameter.yaw_inertia", "parameter.downforce", "parameter.tyre_grip", "parameter.tyre_stiffness", "parameter.steering_ratio"})
      no(id, "side slip or steering is not logged");
  }
  const auto add = [&](Unknown u) { out.unknowns.push_back(std::move(u)); };
  const auto curve = [&](const char* name, double width, std::function<void(Setting&, double)> set) {
    Unknown u;
    u.id = "curve";
    u.kind = "curve";
    u.name = name;
    u.unit = "1";
    u.role = Role::kCurve;
    u.width = width;
    u.step = 0.02;
    u.set = std::move(set);
    add(u);
  };
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
    if (any(logs, k == 0 ? kWheelFront : kWheelRear)) {
      Unknown u;
      u.id = "parameter.wheel_radius";
      u.kind = "parameter";
      u.name = k == 0 ? "front wheel radius, share" : "rear wheel radius, share";
      u.unit = "1";
      u.role = Role::kParameter;
      u.stated = 1.0;
      u.width = 0.05;
      u.step = 0.01;
      u.physics = "the rolling radius is not the stated one";
      u.equation = "v = omega * radius";
      u.set = [k](Setting& s, double amount) { s.wheel_radius[k] += amount; };
      add(u);
    }
  }
  if (!any(logs, kWheelFront) && !any(logs, kWheelRear)) no("parameter.wheel_radius", "no wheel speeds in the log");
  if (engine) {
    for (std::size_t k = 0; k < 4; ++k)
      curve("engine map", 0.02, [k](Setting& s, double amount) { s.engine_shape[k] += amount; });
    curve("rolling resistance", 0.1, [](Setting& s, double amount) { s.rolling += amount; });
    if (any(logs, kWheelRear)) {
      curve("slip stiffness", 0.5, [](Setting& s, double amount) { s.slip += amount; });
      curve("slip stiffness, left to right", 0.5, [](Setting& s, double amount) { s.slip_across += amount; });
      curve("slip stiffness in turns", 1.0, [](Setting& s, double amount) { s.slip_turning += amount; });
    }
  }
  if (lateral && car.terms[Term::tyre_combined_slip] > 0)
    curve("combined slip", 0.1, [](Setting& s, double amount) { s.combined += amount; });
  if (lateral && engine) curve("slip angle under drive", 1.0, [](Setting& s, double amount) { s.rolling_slip += amount; });
  if (lateral && car.terms[Term::tyre_relaxation] > 0)
    curve("relaxation length", 0.2, [](Setting& s, double amount) { s.relaxation += amount; });
  if (lateral)
    for (std::size_t k = 0; k < 2; ++k) {
      curve("tyre curve", 0.02, [k](Setting& s, double amount) { s.curve[k] += amount; });
      curve("tyre curve", 0.02, [k](Setting& s, double amount) { s.curve2[k] += amount; });
      curve("tyre load", 0.02, [k](Setting& s, double amount) { s.load_curve[k] += amount; });
      curve("side force", 0.01, [k](Setting& s, double amount) { s.drop[k] += amount; });
    }

  // Sensors: whatever a redundant relation sees.
  const bool yaw = any(logs, kYaw), rate = any(logs, kYawRate), vy = any(logs, kVy);
  const auto sensor = [&](Channel c, const char* unit, double bias_step, double bias_least, bool gain, bool timing) {
    const auto one = [&](const char* what, const char* name, const char* u_unit, double step, double least, bool one_sided,
                         const char* equation, std::function<void(Setting&, double)> set) {
      Unknown u;
      u.id = std::string("sensor.") + what;
      u.kind = "sensor";
      u.channel = column(logs, c);
      u.name = name;
      u.unit = u_unit;
      u.step = step;
      u.least = least;
      u.one_sided = one_sided;
      u.physics = fmt::format("the column {} carries an error of its own; other channels with the same physics do not show it", column(logs, c));
      u.equation = equation;
      u.separating = "drive the same laps with a second, independent sensor of this quantity";
      u.set = std::move(set);
      add(u);
    };
    if (bias_step > 0)
      one("bias", "bias", unit, bias_step, bias_least, false, "logged = true + bias", [c](Setting& s, double v) { s.sensor[c].bias += v; });
    if (gain) one("gain", "gain error", "1", 0.01, 0.007, false, "logged = (1 + gain error) * true", [c](Setting& s, double v) { s.sensor[c].gain += v; });
    if (timing) {
      one("delay", "delay", "s", 0.02, 0.0015, true, "logged(t) = true(t - delay)", [c](Setting& s, double v) { s.sensor[c].delay_s += v; });
      one("low_pass", "time constant", "s", 0.05, 0.0015, true, "T d(logged)/dt = true - logged", [c](Setting& s, double v) { s.sensor[c].low_pass_s += v; });
      for (std::size_t k = out.unknowns.size() - 2; k < out.unknowns.size(); ++k)
        out.unknowns[k].separating = "swing the quantity ever faster, for steering 0.5 to 2 Hz: a delay keeps the amplitude, a filter does not";
    }
  };
  if (rate) sensor(kYawRate, "rad/s", 0.005, 0.0015, true, true);
  if (any(logs, kAx)) sensor(kAx, "m/s2", 0.1, 0.04, true, true);
  if (any(logs, kAy) && vy) sensor(kAy, "m/s2", 0.1, 0.04, true, true);
  if (yaw) sensor(kYaw, "rad", 0.005, 0.002, false, false);
  if (vy) sensor(kVy, "m/s", 0.05, 0.03, false, false);
  sensor(kVx, "m/s", 0.1, 0.08, true, true);
  if (any(logs, kWheelFront)) sensor(kWheelFront, logs.front().wheels_in_mps ? "m/s" : "rad/s", 0, 0, false, true);
  // Slip has to build up before a wheel follows the car, and the road wheel before the tyre.
  const auto at_least = [&](Channel c, double seconds) {
    for (Unknown& u : out.unknowns)
      if ((u.id == "sensor.delay" || u.id == "sensor.low_pass") && u.channel == column(logs, c)) u.least = seconds;
  };
  at_least(kWheelFront, 0.02);
  at_least(kVx, 0.015);
  if (lateral && !commanded(logs, kSteer)) {
    sensor(kSteer, "rad", 0.002, 0.002, true, true);
    for (Unknown& u : out.unknowns)
      if (u.id == "sensor.gain" && u.channel == column(logs, kSteer)) u.least = 0.06;
    at_least(kSteer, 0.05);
  }
  if (brake && engine && !commanded(logs, kBrakeFront)) {
    // Both circuits have one clock.
    Unknown u;
    u.id = "sensor.delay";
    u.kind = "sensor";
    u.channel = column(logs, kBrakeFront);
    u.name = "delay";
    u.unit = "s";
    u.step = 0.02;
    u.least = 0.01;
    u.one_sided = true;
    u.physics = "the brake pressure is logged late";
    u.equation = "logged(t) = true(t - delay)";
    u.set = [](Setting& s, double v) { s.sensor[kBrakeFront].delay_s += v; s.sensor[kBrakeRear].delay_s += v; };
    add(u);
  }
  if (!any(logs, kAx)) no("sensor.bias", "of ax: not logged");
  if (!any(logs, kAy) || !vy) no("sensor.bias", "of ay: ay or the lateral speed is not logged");
  if (any(logs, kAx) && any(logs, kAy) && vy) {
    Unknown u;
    u.id = "sensor.misalignment";
    u.kind = "sensor";
    u.channel = column(logs, kAx) + "," + column(logs, kAy);
    u.name = "angle";
    u.unit = "rad";
    u.step = 0.01;
    u.least = 0.005;
    u.physics = "the accelerometer is turned about the vertical against the car";
    u.equation = "ax, ay logged = true ax, ay turned by -angle";
    u.separating = "park the car on a known slope, twice, turned by 90 degrees";
    u.set = [](Setting& s, double v) { s.imu_yaw += v; };
    add(u);
    u.id = "sensor.lever_arm";
    u.name = "ahead of the centre of mass";
    u.unit = "m";
    u.step = 0.3;
    u.least = 0.15;
    u.physics = "the accelerometer does not sit in the centre of mass";
    u.equation = "ay logged = ay + l dr/dt, ax logged = ax - l r^2";
    u.separating = "measure where it is mounted";
    u.set = [](Setting& s, double v) { s.imu_ahead += v; };
    add(u);
  } else {
    no("sensor.misalignment", "needs ax, ay and the lateral speed");
    no("sensor.lever_arm", "needs ax, ay and the lateral speed");
  }

  // Road.
  const auto road = [&](const char* id, const char* name, const char* unit, double step, double least, const char* physics,
                        const char* equation, const char* separating, std::function<void(Setting&, double)> set) {
    Unknown u;
    u.id = id;
    u.kind = "road";
    u.name = name;
    u.unit = unit;
    u.step = step;
    u.least = least;
    u.physics = physics;
    u.equation = equation;
    u.separating = separating;
    u.along_road = true;
    u.set = std::move(set);
    add(u);
  };
  if (vy || any(logs, kAy))
    road("road.banking", "banking added", "m/m", 0.01, vy && any(logs, kAy) ? 0.006 : 0.015, "the road leans more (or less) than the file says",
         "dvy/dt + r vx = Fy/m - g bank", "survey the cross slope with a level at the place", [](Setting& s, double v) { s.bank += v; });
  else no("road.banking", "needs the lateral speed");
  if (engine || any(logs, kAx))
    road("road.grade", "grade added", "m/m", 0.01, 0.005, "the road climbs more (or less) than the file says",
         "dvx/dt - r vy = Fx/m - g grade", "drive the place in both directions, or coast through it", [](Setting& s, double v) { s.grade += v; });
  else no("road.grade", "needs throttle or ax");
  if (any(logs, kAz) || any(logs, kLoadFront))
    road("road.vertical_curvature", "curvature added", "1/m", 0.0005, 0.0002, "a crest or dip that the file does not have",
         "az = g + curvature v^2", "pass the place at another speed", [](Setting& s, double v) { s.vertical += v; });
  else no("road.vertical_curvature", "needs az or wheel loads");
  if (lateral)
    road("road.friction", "grip added", "1", 0.03, 0.1, "the road has more (or less) grip here", "mu = mu_tyre (1 + change)",
         "brake hard at the place and beside it", [](Setting& s, double v) { s.friction += v; });
  else no("road.friction", "side slip or steering is not logged");
  double relief = 0.0;
  for (const Signals& s : logs)
    for (std::size_t i = 0; i < s.n; ++i)
      if (std::isfinite(s.grade[i])) relief = std::max(relief, std::abs(s.grade[i]) + std::abs(s.bank[i]));
  if (relief > 0.01) {
    Unknown u;
    u.id = "road.misplaced";
    u.kind = "road";
    u.name = "shift along u";
    u.unit = "m";
    u.step = 2.0;
    u.least = 1.5;
    u.physics = "the road file lies shifted along the track";
    u.equation = "z(u) -> z(u + shift)";
    u.separating = "survey two fixed points of the track";
    u.set = [](Setting& s, double v) { s.shift_u += v; };
    add(u);
  } else {
    no("road.misplaced", "the road file has no slopes whose place could be compared");
  }
  no("road.kerb_or_roughness", "outside what means of 0.3 s show");
  no("vehicle.multi_point_contact", "outside what means of 0.3 s show");

  // Car.
  const auto physics = [&](const char* id, const char* kind, const char* name, const char* unit, double step, double least, bool one_sided,
                           const char* text, const char* equation, const char* separating, std::function<void(Setting&, double)> set) {
    Unknown u;
    u.id = id;
    u.kind = kind;
    u.name = name;
    u.unit = unit;
    u.step = step;
    u.least = least;
    u.one_sided = one_sided;
    u.physics = text;
    u.equation = equation;
    u.separating = separating;
    u.set = std::move(set);
    add(u);
  };
  if (engine) {
    if (car.terms[Term::turbo_lag] == 0.0) {
      for (const double rise : {0.12, 0.2, 0.35, 0.55, 0.9}) {
        physics("vehicle.turbo_lag", "vehicle", "turbo.share", "1", 0.2, 0.085, true, "torque waits for boost after tip-in",
                "d(boost)/dt = (throttle - boost) flow / rise; torque *= 1 - share (throttle - boost)", "tip in at two engine speeds and compare the delay",
                [rise](Setting& s, double v) { s.turbo += v; s.turbo_rise_s = rise; });
        out.unknowns.back().equation += fmt::format("; rise {} s", rise);
      }
    } else {
      no("vehicle.turbo_lag", "the stated car has it; its parameters are not refitted");
    }
    physics("vehicle.throttle_dead_time", "vehicle", "throttle.dead_time_s", "s", 0.04, 0.013, true, "torque follows the throttle late",
            "torque(t) = map(throttle(t - T))", "short throttle pulses at constant speed", [](Setting& s, double v) { s.throttle_s += v; });
    if (brake)
      physics("vehicle.brake_dead_time", "vehicle", "brake.dead_time_s", "s", 0.04, 0.013, true, "deceleration follows the pressure late",
              "force(t) = k p(t - T)", "short brake pulses on a straight", [](Setting& s, double v) { s.brake_s += v; });
    else no("vehicle.brake_dead_time", "no brake pressure in the log");
    if (brake && car.terms[Term::brake_fade] * car.parameters[P::brake_fade_1pmj] != 0.0)
      no("vehicle.brake_friction_temperature", "the stated car has it; its parameters are not refitted");
    else if (brake)
      for (const double time : {2.5, 10.0, 40.0})
        physics("vehicle.brake_friction_temperature", "vehicle", "friction lost per 0.75 MJ of heat", "1", 0.1, 0.02, true,
                "the pads' friction changes with their heat", "mu = mu0 (1 - k heat); d(heat)/dt = power - heat/T",
                "repeat equal stops with short and long pauses, or log the disc temperature", [time](Setting& s, double v) { s.fade += v; s.fade_s = time; }),
            out.unknowns.back().equation += fmt::format("; T {} s", time);
    else no("vehicle.brake_friction_temperature", "no brake pressure in the log");
    for (const double angle : {0.0, 90.0})
      physics("environment.wind", "environment", angle == 0 ? "wind towards +x" : "wind towards +y", "m/s", 1.5, 0.8, false,
              "the air moves over the ground", "drag = k |v - w| (v - w)", "drive the straight in both directions, or log the wind",
              [angle](Setting& s, double v) { (angle == 0 ? s.wind_x : s.wind_y) += v; });
    physics("vehicle.fuel_burn", "vehicle", "mass lost", "kg/s", 0.05, 0.03, true, "the car becomes lighter", "m(t) = m0 - k t",
            "weigh the car before and after", [](Setting& s, double v) { s.burn += v; });
  } else {
    for (const char* id : {"vehicle.turbo_lag", "vehicle.throttle_dead_time", "vehicle.brake_dead_time", "vehicle.brake_friction_temperature", "environment.wind", "vehicle.fuel_burn"})
      no(id, "no throttle in the log");
  }
  if (lateral) {
    physics("vehicle.steering_dead_time", "vehicle", "steering.dead_time_s", "s", 0.03, 0.01, true, "the wheels follow the steering late",
            "delta(t) = command(t - T)", "step steer at constant speed", [](Setting& s, double v) { s.steer_s += v; });
    physics("vehicle.steering_lag", "vehicle", "steering.lag_s", "s", 0.05, 0.01, true, "the wheels follow the steering through a lag",
            "T d(delta)/dt = command - delta", "sine steer at two frequencies", [](Setting& s, double v) { s.steer_lag_s += v; });
    if (car.terms[Term::tyre_thermal] == 0.0 && car.terms[Term::tyre_warm_up] * car.parameters[P::tyre_warm_up_loss] == 0.0)
      for (const double time : {25.0, 80.0, 250.0})
        physics("vehicle.tyre_thermal", "vehicle", "grip missing when cold", "1", 0.1, 0.025, false, "the tyres' grip and stiffness change as they warm up",
                "grip = 1 - k (1 - warmth); d(warmth)/dt = work / T", "log the tyre temperature, or repeat the first laps on warm tyres",
                [time](Setting& s, double v) { s.thermal += v; s.thermal_s = time; });
    else no("vehicle.tyre_thermal", "the stated car has it; its parameters are not refitted");
    const auto term = [&](const char* id, Term t, const char* name, double step, double least, const char* text, std::function<void(Setting&, double)> set) {
      if (car.terms[t] == 0.0) physics(id, "vehicle", name, "1", step, least, true, text, "as in the Magic Formula of the stated tyre", "constant-radius cornering at several speeds", std::move(set));
      else no(id, "the stated car has it; what may be wrong about its curve is absorbed as uncertain");
    };
    term("vehicle.tyre_load_sensitivity", Term::tyre_load_sensitivity, "tyre_load_sensitivity", 0.3, 0.3, "grip per load falls with load", [](Setting& s, double v) { s.load_sensitivity += v; });
    term("vehicle.tyre_camber", Term::tyre_camber, "tyre_camber", 0.3, 0.3, "inclined tyres push sideways", [](Setting& s, double v) { s.camber += v; });
    term("vehicle.tyre_combined_slip", Term::tyre_combined_slip, "tyre_combined_slip", 0.3, 0.3, "braking and driving take side force away", [](Setting& s, double v) { s.combined += v; });
    term("vehicle.tyre_relaxation", Term::tyre_relaxation, "tyre_relaxation", 0.3, 0.4, "side force builds up over a distance", [](Setting& s, double v) { s.relaxation += v; });
    if (car.terms[Term::aero_ride_height] == 0.0)
      physics("vehicle.aero_ride_height", "vehicle", "downforce lost per kPa", "1", 0.05, 0.08, false, "downforce changes as the car sinks",
              "A = A0 (1 - k q)", "constant-speed runs at two ride heights", [](Setting& s, double v) { s.ride += v; });
    else no("vehicle.aero_ride_height", "the stated car has it; see parameter.downforce");
  } else {
    for (const char* id : {"vehicle.steering_dead_time", "vehicle.steering_lag", "vehicle.tyre_thermal", "vehicle.tyre_load_sensitivity",
                           "vehicle.tyre_camber", "vehicle.tyre_combined_slip", "vehicle.tyre_relaxation", "vehicle.aero_ride_height"})
      no(id, "side slip or steering is not logged");
  }
  if (car.terms[Term::aero_drag] != 0.0) no("vehicle.aero_drag", "the stated car has drag: see parameter.drag");
  else if (!engine) no("vehicle.aero_drag", "no throttle in the log");
  else
    physics("vehicle.aero_drag", "vehicle", "aero_drag", "1", 0.1, 0.03, true, "the air holds the car back, which the simulation leaves out", "F = -q A",
            "coast down from high speed", [](Setting& s, double v) { s.drag += v; });
  if (car.terms[Term::aero_downforce] != 0.0) no("vehicle.aero_downforce", "the stated car has downforce: see parameter.downforce");
  else if (!lateral && !any(logs, kLoadFront)) no("vehicle.aero_downforce", "neither wheel loads nor side slip are logged");
  else
    physics("vehicle.aero_downforce", "vehicle", "aero_downforce", "1", 0.1, 0.05, true, "the air presses the car down, which the simulation leaves out", "Fz += q A",
            "constant-radius cornering at several speeds", [](Setting& s, double v) { s.down += v; });
  no("vehicle.mass", "the same change as parameter.mass: see there");
  no("vehicle.aero_slipstream", "the log names no opponent");
  no("vehicle.brake_disc_conductance", "outside what means of 0.3 s show");
  if (!any(logs, kWheelRearDifference)) no("vehicle.differential", "the rear wheels' speeds are not both logged");
  else if (car.terms[Term::locked_differential] != 0.0 || car.terms[Term::limited_slip] != 0.0)
    no("vehicle.differential", "the stated car has a limited-slip or locked differential; only an open one is tested");
  else
    physics("vehicle.differential", "vehicle", "locked share", "1", 0.2, 0.08, true, "the driven wheels are coupled",
            "omega_l - omega_r = -(1 - k) track r / R", "slow tight circles, power on and off", [](Setting& s, double v) { s.lock += v; });
  static const std::vector<std::pair<std::string, double>> kMost{
      {"sensor.gain", 0.5}, {"sensor.delay", 1.0}, {"sensor.low_pass", 5.0}, {"sensor.misalignment", 0.3}, {"sensor.lever_arm", 4.0},
      {"road.banking", 0.3}, {"road.grade", 0.2}, {"road.friction", 0.6}, {"vehicle.turbo_lag", 0.95}, {"vehicle.throttle_dead_time", 0.5},
      {"vehicle.brake_dead_time", 0.5}, {"vehicle.steering_dead_time", 0.3}, {"vehicle.steering_lag", 0.5}, {"vehicle.tyre_thermal", 0.6},
      {"vehicle.tyre_load_sensitivity", 6.0}, {"vehicle.tyre_camber", 10.0}, {"vehicle.tyre_combined_slip", 3.0}, {"vehicle.tyre_relaxation", 15.0},
      {"vehicle.aero_drag", 3.0}, {"vehicle.aero_downforce", 3.0}, {"vehicle.aero_ride_height", 0.8},
      {"vehicle.brake_friction_temperature", 0.9}, {"environment.wind", 25.0}, {"vehicle.fuel_burn", 0.6}, {"vehicle.differential", 1.3}};
  for (Unknown& u : out.unknowns)
    for (const auto& [id, most] : kMost)
      if (u.id == id) u.most = most;
  // One lap shows every place once: nothing comes back there.
  std::ptrdiff_t whole = 0;
  bool closed = false;
  for (const Signals& s : logs) whole += std::count(s.whole.begin(), s.whole.end(), true), closed = closed || s.closed;
  if (closed && whole < 2) {
    for (const Unknown& u : out.unknowns)
      if (u.along_road) no(u.id.c_str(), "less than two whole laps");
    std::erase_if(out.unknowns, [](const Unknown& u) { return u.along_road; });
  }
  return out;
}

}  // namespace explain
