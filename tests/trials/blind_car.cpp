#include "blind_car.h"

#include <algorithm>
#include <cstdio>

#include "stated_electric.h"

namespace trials {

const std::vector<Parameter> kParameters{
    {"parameter.mass", "chassis.mass_kg", false, [](Variant& v, double f) { v.car.mass *= f; }},
    {"parameter.cog", "chassis.cog_behind_front_m", false,
     [](Variant& v, double f) {
       v.car.b -= v.car.a * (f - 1);
       v.car.a *= f;
     }},
    {"parameter.yaw_inertia", "chassis.yaw_inertia_kgm2", false,
     [](Variant& v, double f) { v.car.inertia *= f; }},
    {"parameter.drag", "aero.drag_area_m2", false, [](Variant& v, double f) { v.car.drag *= f; }},
    {"parameter.downforce", "front.lift_area_m2", false,
     [](Variant& v, double f) { v.car.lift_f *= f; }},
    {"parameter.downforce", "rear.lift_area_m2", false,
     [](Variant& v, double f) { v.car.lift_r *= f; }},
    {"parameter.engine_torque", "engine.torque", false,
     [](Variant& v, double f) {
       v.car.torque *= f;
       v.car.engine_drag *= f;
     }},
    {"parameter.brake_gain", "brake.gain", false,
     [](Variant& v, double f) {
       v.car.brake_f *= f;
       v.car.brake_r *= f;
     }},
    {"parameter.tyre_grip", "front.tyre_grip", false,
     [](Variant& v, double f) { v.car.mu_f *= f; }},
    {"parameter.tyre_grip", "rear.tyre_grip", false, [](Variant& v, double f) { v.car.mu_r *= f; }},
    {"parameter.tyre_stiffness", "front.tyre_cornering_stiffness", false,
     [](Variant& v, double f) { v.car.c_f *= f; }},
    {"parameter.tyre_stiffness", "rear.tyre_cornering_stiffness", false,
     [](Variant& v, double f) { v.car.c_r *= f; }},
    {"parameter.wheel_radius", "front wheel radius, share", false,
     [](Variant& v, double f) { v.car.radius_f *= f; }},
    {"parameter.wheel_radius", "rear wheel radius, share", false,
     [](Variant& v, double f) { v.car.radius_r *= f; }},
    {"parameter.steering_ratio", "steering.ratio", true,
     [](Variant& v, double f) { v.steer_gain /= f; }},
    {"parameter.throttle_gain", "throttle.gain", true,
     [](Variant& v, double f) { v.throttle_gain *= f; }}};

namespace {

/// The parameter that makes up for most of an effect, tuned in that direction.
struct Tuned {
  const char *mechanism, *name;
  double share;
};
const std::vector<Tuned> kTuned{{"vehicle.turbo_lag", "engine.torque", 0.05},
                                {"vehicle.brake_friction_temperature", "brake.gain", 0.05},
                                {"vehicle.tyre_thermal", "rear.tyre_grip", 0.05},
                                {"vehicle.fuel_burn", "chassis.mass_kg", 0.04},
                                {"vehicle.aero_ride_height", "rear.lift_area_m2", 0.05}};

std::size_t index_of(const std::string& name) {
  return static_cast<std::size_t>(std::find_if(kParameters.begin(), kParameters.end(),
                                               [&](const Parameter& p) { return p.name == name; }) -
                                  kParameters.begin());
}

/// The terms that a stated car may leave out.
std::string terms_without(const std::vector<Effect>& effects) {
  std::string out;
  for (const std::string term : {"aero_drag", "aero_downforce", "tyre_load_sensitivity",
                                 "tyre_combined_slip", "tyre_relaxation"})
    out += term + (is_about(effects, "vehicle." + term) ? ": 0, " : ": 1, ");
  return out + kTermsOff;
}

}  // namespace

Deviations deviate(const Question& question, const std::vector<Effect>& effects, Random& dice) {
  Deviations out;
  for (const Parameter& p : kParameters)
    out.share.push_back(p.commanded ? 0.0
                                    : dice.in(-0.04, 0.04) *
                                          (std::string(p.id) == "parameter.cog" ? 0.4 : 1.0));
  for (const std::size_t k : question.parameters) {
    const bool inside =
        question.kind == "single" &&
        dice.uniform() < 0.3;  // within the prior width: listed, and nothing is missing
    out.share[k] = inside ? dice.in(0.01, 0.045) : dice.in(0.12, 0.25);
    if (dice.uniform() < 0.5) out.share[k] = -out.share[k];
  }
  // An effect that tuning has hidden.
  for (const Tuned& tuned : kTuned)
    if (question.kind == "single" && !effects.empty() && effects[0].mechanism == tuned.mechanism &&
        dice.uniform() < 0.5) {
      const std::size_t k = index_of(tuned.name);
      out.share[k] = tuned.share;
      out.compensated = kParameters[k].id;
    }
  return out;
}

Variant with_stated(Variant nominal, std::size_t parameter, const Deviations& deviations) {
  kParameters[parameter].scale(nominal, 1 / (1 + deviations.share[parameter]));
  return nominal;
}

StatedCar stated_car(const Variant& nominal, const Deviations& deviations,
                     const std::vector<Effect>& effects, Random& dice) {
  const auto off = [&](double share = 0.04) { return dice.in(1 - share, 1 + share); };
  const auto shape = [&] {
    std::array<double, 8> out{};
    for (double& o : out) o = off();
    return out;
  };
  Variant stated = nominal;
  for (std::size_t k = 0; k < kParameters.size(); ++k) stated = with_stated(stated, k, deviations);
  const TruthCar& t = nominal.car;
  const TruthCar& c = stated.car;
  StatedCar car;
  car.front = {t.load_f,     c.mu_f,     t.mu_load * off(0.2),      c.c_f,
               t.ck * off(), c.radius_f, t.relaxation_f * off(0.2), shape()};
  car.rear = {t.load_r,     c.mu_r,     t.mu_load * off(0.2),      c.c_r,
              t.ck * off(), c.radius_r, t.relaxation_r * off(0.2), shape()};
  car.engine = c;
  car.torque_tilt = dice.in(-0.03, 0.03);
  car.rear_brake_friction = rear_friction(c.brake_r) * off(0.02);
  car.front_brake_friction = front_friction(c.brake_f) * off(0.02);
  car.engine_inertia_kgm2 = t.engine_inertia * off();
  car.cog_height_m = t.h * off();
  car.mass_kg = c.mass;
  car.wheelbase_m = t.a + t.b;
  car.cog_behind_front_m = c.a;
  car.yaw_inertia_kgm2 = c.inertia;
  car.front_track_m = t.track_f;
  car.rear_track_m = t.track_r;
  car.drag_area_m2 = c.drag;
  car.front_lift_area_m2 = c.lift_f;
  car.rear_lift_area_m2 = c.lift_r;
  car.front_roll_share = t.roll_front;
  car.camber_rad = -t.camber;
  char text[300];
  std::snprintf(text, sizeof text,
                "  steering.ratio: %.4f\n  throttle.gain: %.4f\n"
                "  front.tyre_cornering_stiffness: {value: 1, prior: 0.05}\n  "
                "rear.tyre_cornering_stiffness: {value: 1, prior: 0.05}\n",
                1 / stated.steer_gain, stated.throttle_gain);
  car.last_parameters = text;
  car.terms = terms_without(effects);
  if (t.electric) state_electric(car, t, dice, 0.04);
  return car;
}

}  // namespace trials
