// Numbers of the vehicle file that are merely off: refitted with their prior width, and a finding
// beyond it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "car_changes.h"
#include "engine_and_brakes.h"
#include "listing.h"

namespace explain::stated_parameters {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

/// Share of a gain that a command and what was measured of it get wrong: noise of a good logger,
/// averaged over a lap, and its scale.
constexpr double kOfActuator = 0.002;
constexpr const char* kPressureByCommand = "brake pressure over command, share";

/// `form`: share of the value that the simulated car and stated curves get wrong.
Unknown& parameter(const Listing& l, const char* id, P which, double form) {
  Unknown u;
  u.id = id;
  u.kind = "parameter";
  u.name = name_of(which);
  u.role = Role::kParameter;
  const auto index = static_cast<std::size_t>(which);
  const double value = l.car.parameters.value[index];
  u.stated = value;
  u.assumed = l.car.assumed[index];
  u.unit = std::string(vehicle::parameter_list()[index].unit);
  u.width = l.car.prior[index] * (value != 0 ? std::abs(value) : 1.0);
  u.step = 0.02 * std::abs(value) + 1e-9;
  u.form = form * std::abs(value);
  u.physics = fmt::format("the stated {} is off", u.name);
  u.equation = fmt::format("{} = stated + change", u.name);
  u.set = [which, value](Setting& s, double amount) { s.p[which] *= 1.0 + amount / value; };
  return l.out.unknowns.emplace_back(std::move(u));
}

void list_mass(const Listing& l) {
  const char* const id = "parameter.mass";
  if (!l.engine && !l.lateral)
    return untestable(l, id, "neither throttle nor steering with lateral speed is logged");
  Unknown& u = parameter(l, id, P::chassis_mass_kg, 0.01);
  if (has(l, kLoadFront) || has(l, kLoadRear)) return;
  // Nothing else gives forces a scale: torque, brakes and drag that are off alike are the same, and
  // less likely.
  u.held = 0.01 * l.car.parameters[P::chassis_mass_kg];
  u.stays_held = !l.lateral;  // forwards alone, any error that they share would pass for it
  untestable(l, id,
             "held near its stated value: without wheel loads only torque, brakes and drag that "
             "are off alike would speak for another mass");
}

void list_drag(const Listing& l) {
  const char* const id = "parameter.drag";
  if (!l.engine) return untestable(l, id, kNoThrottle);
  parameter(l, id, P::aero_drag_area_m2, 0.018);
}

void list_engine_torque(const Listing& l) {
  const char* const id = "parameter.engine_torque";
  if (!l.engine) return untestable(l, id, kNoThrottle);
  parameter(l, id, P::engine_torque, 0.01);
}

void list_throttle_gain(const Listing& l) {
  const char* const id = "parameter.throttle_gain";
  if (!l.engine) return untestable(l, id, kNoThrottle);
  parameter(l, id, P::throttle_gain, 0.01);
}

void list_brake_gain(const Listing& l) {
  const char* const id = "parameter.brake_gain";
  if (!l.brake || !l.engine)
    return untestable(l, id, "no brake pressure or no throttle in the log");
  parameter(l, id, P::brake_gain, 0.015);
  if (!has(l, kBrakeCommand)) return;
  // What the pressure does, the forces say; what the command makes of it, its own relation.
  Unknown u;
  u.id = id;
  u.kind = "parameter";
  u.name = kPressureByCommand;
  u.unit = "1";
  u.role = Role::kParameter;
  u.stated = 1.0;
  u.width = l.car.prior[static_cast<std::size_t>(P::brake_gain)];
  u.step = 0.01;
  u.form = kOfActuator;
  u.physics = "the brakes answer the command with another pressure than stated";
  u.equation = "pressure = share * stated gain * command";
  u.set = [](Setting& s, double amount) { s.pressure_by_command += amount; };
  l.out.unknowns.push_back(std::move(u));
}

void list_cog(const Listing& l) {
  const char* const id = "parameter.cog";
  if (!l.lateral) return untestable(l, id, kNoSlip);
  parameter(l, id, P::chassis_cog_behind_front_m, 0.014);
}

void list_yaw_inertia(const Listing& l) {
  const char* const id = "parameter.yaw_inertia";
  if (!l.lateral) return untestable(l, id, kNoSlip);
  Unknown& inertia = parameter(l, id, P::chassis_yaw_inertia_kgm2, 0.1);
  // What curves of tyres get wrong in transients is more than what it would move.
  inertia.held = 0.005 * l.car.parameters[P::chassis_yaw_inertia_kgm2];
  inertia.stays_held = true;
  untestable(l, id,
             "held near its stated value: errors of the tyre curves in transients are larger than "
             "its effect");
}

void list_downforce(const Listing& l) {
  const char* const id = "parameter.downforce";
  if (!l.lateral) return untestable(l, id, kNoSlip);
  // Logged loads say it themselves: cars of another simulator came out within 0.5 %.
  const auto by_loads = [&](P which, bool logged) {
    parameter(l, id, which, logged ? 0.01 : 0.04).by_curve_across = !logged;
  };
  by_loads(P::front_lift_area_m2, has(l, kLoadFront));
  by_loads(P::rear_lift_area_m2, has(l, kLoadRear));
}

void list_tyre_grip(const Listing& l) {
  const char* const id = "parameter.tyre_grip";
  if (!l.lateral) return untestable(l, id, kNoSlip);
  // What the stated tyre's shape gets wrong, and what drive takes away where the stated car says
  // that it takes nothing.
  const double form = l.car.terms[Term::tyre_combined_slip] > 0 ? 0.045 : 0.1;
  parameter(l, id, P::front_tyre_grip, form).by_curve_across = true;
  parameter(l, id, P::rear_tyre_grip, form).by_curve_across = true;
}

void list_tyre_stiffness(const Listing& l) {
  const char* const id = "parameter.tyre_stiffness";
  if (!l.lateral) return untestable(l, id, kNoSlip);
  parameter(l, id, P::front_tyre_cornering_stiffness, 0.012);
  parameter(l, id, P::rear_tyre_cornering_stiffness, 0.026);
}

void list_steering_ratio(const Listing& l) {
  const char* const id = "parameter.steering_ratio";
  if (!l.lateral) return untestable(l, id, kNoSlip);
  // Beside its command the wheels' angle says it without tyres.
  if (has(l, kSteerCommand)) {
    parameter(l, id, P::steering_ratio, kOfActuator);
    return;
  }
  if (!commanded(l.logs, kSteer))
    return untestable(l, id, "the log has the road wheels' angle itself: see sensor.gain of it");
  parameter(l, id, P::steering_ratio, 0.02);
}

void write(CarChanges& out, const Finding& f) {
  out.parameters[f.parameters[0].name] = f.parameters[0].value;
}

/// The gain would not act on measured pressures.
void write_brake_gain(CarChanges& out, const Finding& f) {
  if (f.parameters[0].name == kPressureByCommand)
    return out.set(P::brake_gain, f.parameters[0].value * out.car.parameters[P::brake_gain]);
  const double grown = f.parameters[0].value / out.car.parameters[P::brake_gain];
  for (const P p : brake_strength(out.car)) out.set(p, grown * out.car.parameters[p]);
}

/// Behind a measured throttle alone no gain acts: what was found is the engine's torque at part
/// throttle.
void write_throttle_gain(CarChanges& out, const Finding& f) {
  const bool beside = std::any_of(out.logs.begin(), out.logs.end(),
                                  [](const Signals& s) { return s.present[kThrottleCommand]; });
  if (beside || commanded(out.logs, kThrottle)) return write(out, f);
  const auto& p = out.car.parameters;
  out.maps["engine_torque_nm"] = shaped_engine_map(
      out.car.files.engine_torque_nm,
      {0.5 * (f.parameters[0].value / p[P::throttle_gain] - 1), 0, 0, 0}, p[P::engine_limit_radps]);
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {
      {.id = "parameter.mass", .list = list_mass, .write_car = write},
      {.id = "parameter.drag", .list = list_drag, .write_car = write},
      {.id = "parameter.engine_torque", .list = list_engine_torque, .write_car = write},
      {.id = "parameter.throttle_gain",
       .list = list_throttle_gain,
       .write_car = write_throttle_gain},
      {.id = "parameter.brake_gain", .list = list_brake_gain, .write_car = write_brake_gain},
      {.id = "parameter.cog", .list = list_cog, .write_car = write},
      {.id = "parameter.yaw_inertia", .list = list_yaw_inertia, .write_car = write},
      {.id = "parameter.downforce", .list = list_downforce, .write_car = write},
      {.id = "parameter.tyre_grip", .list = list_tyre_grip, .write_car = write},
      {.id = "parameter.tyre_stiffness", .list = list_tyre_stiffness, .write_car = write},
      {.id = "parameter.steering_ratio", .list = list_steering_ratio, .write_car = write},
  };
}

}  // namespace explain::stated_parameters
