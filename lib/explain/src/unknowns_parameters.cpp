// What the vehicle file states, and the curves that nobody knows exactly.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "late_actuator.h"
#include "unknowns_listing.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

// `form`: share of the value.
Unknown& parameter(const Listing& l, const char* id, const char* name, P which, double form) {
  Unknown u;
  u.id = id;
  u.kind = "parameter";
  u.name = name;
  u.role = Role::kParameter;
  const auto index = static_cast<std::size_t>(which);
  const double value = l.car.parameters.value[index];
  u.stated = value;
  u.assumed = l.car.assumed[index];
  u.unit = std::string(vehicle::parameter_list()[index].unit);
  u.width = l.car.prior[index] * (value != 0 ? std::abs(value) : 1.0);
  u.step = 0.02 * std::abs(value) + 1e-9;
  u.form = form * std::abs(value);
  u.physics = fmt::format("the stated {} is off", name);
  u.equation = fmt::format("{} = stated + change", name);
  u.set = [which, value](Setting& s, double amount) { s.p[which] *= 1.0 + amount / value; };
  return l.out.unknowns.emplace_back(std::move(u));
}

void curve(const Listing& l, const char* name, double width,
           std::function<void(Setting&, double)> set) {
  Unknown u;
  u.id = "curve";
  u.kind = "curve";
  u.name = name;
  u.unit = "1";
  u.role = Role::kCurve;
  u.width = width;
  u.step = 0.02;
  u.set = std::move(set);
  l.out.unknowns.push_back(std::move(u));
}

void mass(const Listing& l) {
  if (!l.engine && !l.lateral) {
    untestable(l, {"parameter.mass"}, "neither throttle nor steering with lateral speed is logged");
    return;
  }
  Unknown& u = parameter(l, "parameter.mass", "chassis.mass_kg", P::chassis_mass_kg, 0.015);
  if (has(l, kLoadFront) || has(l, kLoadRear)) return;
  // Nothing else gives forces a scale: torque, brakes and drag that are off alike are the same, and
  // less likely.
  u.held = 0.01 * l.car.parameters[P::chassis_mass_kg];
  u.stays_held = !l.lateral;  // forwards alone, any error that they share would pass for it
  untestable(l, {"parameter.mass"},
             "held near its stated value: without wheel loads only torque, brakes and drag that "
             "are off alike would speak for another mass");
}

void drive_and_brakes(const Listing& l) {
  if (l.engine) {
    parameter(l, "parameter.drag", "aero.drag_area_m2", P::aero_drag_area_m2, 0.018);
    parameter(l, "parameter.engine_torque", "engine.torque", P::engine_torque, 0.01);
    parameter(l, "parameter.throttle_gain", "throttle.gain", P::throttle_gain, 0.01);
  } else {
    untestable(l, {"parameter.drag", "parameter.engine_torque", "parameter.throttle_gain"},
               "no throttle in the log");
  }
  if (l.brake && l.engine)
    parameter(l, "parameter.brake_gain", "brake.gain", P::brake_gain, 0.015);
  else
    untestable(l, {"parameter.brake_gain"}, "no brake pressure or no throttle in the log");
}

void handling(const Listing& l) {
  if (!l.lateral) {
    untestable(l,
               {"parameter.cog", "parameter.yaw_inertia", "parameter.downforce",
                "parameter.tyre_grip", "parameter.tyre_stiffness", "parameter.steering_ratio"},
               "side slip or steering is not logged");
    return;
  }
  parameter(l, "parameter.cog", "chassis.cog_behind_front_m", P::chassis_cog_behind_front_m, 0.01);
  Unknown& inertia = parameter(l, "parameter.yaw_inertia", "chassis.yaw_inertia_kgm2",
                               P::chassis_yaw_inertia_kgm2, 0.1);
  // What curves of tyres get wrong in transients is more than what it would move.
  inertia.held = 0.005 * l.car.parameters[P::chassis_yaw_inertia_kgm2];
  inertia.stays_held = true;
  untestable(l, {"parameter.yaw_inertia"},
             "held near its stated value: errors of the tyre curves in transients are larger than "
             "its effect");
  parameter(l, "parameter.downforce", "front.lift_area_m2", P::front_lift_area_m2, 0.04);
  parameter(l, "parameter.downforce", "rear.lift_area_m2", P::rear_lift_area_m2, 0.04);
  // What the stated tyre's shape gets wrong, and what drive takes away where the stated car says
  // that it takes nothing.
  const double grip_form = l.car.terms[Term::tyre_combined_slip] > 0 ? 0.045 : 0.1;
  parameter(l, "parameter.tyre_grip", "front.tyre_grip", P::front_tyre_grip, grip_form);
  parameter(l, "parameter.tyre_grip", "rear.tyre_grip", P::rear_tyre_grip, grip_form);
  parameter(l, "parameter.tyre_stiffness", "front.tyre_cornering_stiffness",
            P::front_tyre_cornering_stiffness, 0.012);
  parameter(l, "parameter.tyre_stiffness", "rear.tyre_cornering_stiffness",
            P::rear_tyre_cornering_stiffness, 0.02);
  if (commanded(l.logs, kSteer))
    parameter(l, "parameter.steering_ratio", "steering.ratio", P::steering_ratio, 0.02);
  else
    untestable(l, {"parameter.steering_ratio"},
               "the log has the road wheels' angle itself: see sensor.gain of it");
}

}  // namespace

void list_parameters(const Listing& l) {
  mass(l);
  drive_and_brakes(l);
  handling(l);
}

void list_wheel_radii(const Listing& l) {
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
    if (!has(l, k == 0 ? kWheelFront : kWheelRear)) continue;
    Unknown u;
    u.id = "parameter.wheel_radius";
    u.kind = "parameter";
    u.name = k == 0 ? "front wheel radius, share" : "rear wheel radius, share";
    u.unit = "1";
    u.role = Role::kParameter;
    u.stated = 1.0;
    u.width = 0.05;
    u.step = 0.01;
    u.form = k == 0 ? 0.0006 : 0.001;
    u.physics = "the rolling radius is not the stated one";
    u.equation = "v = omega * radius";
    u.set = [k](Setting& s, double amount) { s.wheel_radius[k] += amount; };
    l.out.unknowns.push_back(std::move(u));
  }
  if (!has(l, kWheelFront) && !has(l, kWheelRear))
    untestable(l, {"parameter.wheel_radius"}, "no wheel speeds in the log");
}

void list_curves(const Listing& l) {
  // On the body it leans with it; some loggers take that out.
  if (has(l, kAx) || has(l, kAy) || has(l, kAz)) {
    curve(l, kLevelAccelerometer, 1.0, [](Setting& s, double amount) { s.level += amount; });
    l.out.unknowns.back().step = 0.2;
  }
  if (l.engine) {
    for (std::size_t k = 0; k < 4; ++k)
      curve(l, "engine map", 0.02, [k](Setting& s, double amount) { s.engine_shape[k] += amount; });
    // Geometry of the suspension, which carries a part of them past the springs.
    curve(l, "torques of the wheels on the body", 1.0,
          [](Setting& s, double amount) { s.reaction += amount; });
    curve(l, "rolling resistance", 0.1, [](Setting& s, double amount) { s.rolling += amount; });
    if (has(l, kWheelRear)) {
      if (!l.car.files.tyre[1].states_rolling_radius)  // a rule of thumb
        curve(l, "rolling radius over load", 0.5,
              [](Setting& s, double amount) { s.radius_by_load += amount; });
      curve(l, "slip stiffness", 0.5, [](Setting& s, double amount) { s.slip += amount; });
    }
  }
  if (!l.lateral) return;
  if (l.car.terms[Term::tyre_combined_slip] > 0)
    curve(l, "combined slip", 0.1, [](Setting& s, double amount) { s.combined += amount; });
  if (l.car.terms[Term::tyre_relaxation] > 0)
    curve(l, "relaxation length", 0.2, [](Setting& s, double amount) { s.relaxation += amount; });
  for (std::size_t k = 0; k < 2; ++k) {
    curve(l, "tyre curve", 0.02, [k](Setting& s, double amount) { s.curve[k] += amount; });
    curve(l, "tyre curve", 0.02, [k](Setting& s, double amount) { s.curve2[k] += amount; });
    curve(l, "tyre load", 0.02, [k](Setting& s, double amount) { s.load_curve[k] += amount; });
    curve(l, "side force", 0.01, [k](Setting& s, double amount) { s.drop[k] += amount; });
  }
}

}  // namespace explain
