// What may be wrong with the road, and what car and air may do that the simulation leaves out.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "unknowns_listing.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

constexpr const char* kStatedToo = "the stated car has it; its parameters are not refitted";

void slopes(const Listing& l) {
  const bool vy = has(l, kVy), ay = has(l, kAy);
  if (vy || ay)
    candidate(l, "road.banking", {"banking added", "m/m", 0.01, vy && ay ? 0.006 : 0.015},
              {"the road leans more (or less) than the file says", "dvy/dt + r vx = Fy/m - g bank",
               "survey the cross slope with a level at the place"},
              [](Setting& s, double v) { s.bank += v; })
        .along_road = true;
  else
    untestable(l, {"road.banking"}, "needs the lateral speed");
  if (l.engine || has(l, kAx))
    candidate(
        l, "road.grade", {"grade added", "m/m", 0.01, 0.005},
        {"the road climbs more (or less) than the file says", "dvx/dt - r vy = Fx/m - g grade",
         "drive the place in both directions, or coast through it"},
        [](Setting& s, double v) { s.grade += v; })
        .along_road = true;
  else
    untestable(l, {"road.grade"}, "needs throttle or ax");
  if (has(l, kAz) || has(l, kLoadFront))
    candidate(l, "road.vertical_curvature", {"curvature added", "1/m", 0.0005, 0.0002},
              {"a crest or dip that the file does not have", "az = g + curvature v^2",
               "pass the place at another speed"},
              [](Setting& s, double v) { s.vertical += v; })
        .along_road = true;
  else
    untestable(l, {"road.vertical_curvature"}, "needs az or wheel loads");
}

void road_grip(const Listing& l) {
  if (l.lateral)
    candidate(l, "road.friction", {"grip added", "1", 0.03, 0.1},
              {"the road has more (or less) grip here", "mu = mu_tyre (1 + change)",
               "brake hard at the place and beside it"},
              [](Setting& s, double v) { s.friction += v; })
        .along_road = true;
  else
    untestable(l, {"road.friction"}, "side slip or steering is not logged");
}

void road_place(const Listing& l) {
  double relief = 0.0;
  for (const Signals& s : l.logs)
    for (std::size_t i = 0; i < s.n; ++i)
      if (std::isfinite(s.grade[i]))
        relief = std::max(relief, std::abs(s.grade[i]) + std::abs(s.bank[i]));
  if (relief > 0.01)
    candidate(l, "road.misplaced", {"shift along u", "m", 2.0, 1.5},
              {"the road file lies shifted along the track", "z(u) -> z(u + shift)",
               "survey two fixed points of the track"},
              [](Setting& s, double v) { s.shift_u += v; });
  else
    untestable(l, {"road.misplaced"}, "the road file has no slopes whose place could be compared");
}

void engine(const Listing& l) {
  if (!l.engine) {
    untestable(l, {"vehicle.turbo_lag", "vehicle.throttle_dead_time"}, "no throttle in the log");
    return;
  }
  const double reference = std::clamp(std::round(typical_engine_radps(l.logs, l.car)), 10.0, 3000.0);
  if (l.car.terms[Term::turbo_lag] == 0.0)
    for (const double rise : {0.02, 0.028, 0.036, 0.044, 0.054, 0.066, 0.08, 0.1, 0.13, 0.17, 0.23, 0.3, 0.4, 0.5})
      candidate(l, "vehicle.turbo_lag", {"turbo.share", "1", 0.2, 0.12, true},
                {"torque waits for boost after tip-in",
                 fmt::format("d(boost)/dt = (throttle - boost) flow / rise; torque *= 1 - share "
                             "(throttle - boost); rise {} s at {:.0f} rad/s",
                             rise, reference),
                 "tip in at two engine speeds and compare the delay"},
                [rise, reference](Setting& s, double v) {
                  s.turbo += v;
                  s.turbo_rise_s = rise;
                  s.turbo_reference_radps = reference;
                })
          .constants = {{"turbo.rise_s", rise}, {"turbo.reference_radps", reference}};
  else
    untestable(l, {"vehicle.turbo_lag"}, kStatedToo);
  candidate(l, "vehicle.throttle_dead_time", {"throttle.dead_time_s", "s", 0.04, 0.008, true},
            {"torque follows the throttle late", "torque(t) = map(throttle(t - T))",
             "short throttle pulses at constant speed"},
            [](Setting& s, double v) { s.throttle_s += v; });
}

void brakes(const Listing& l) {
  if (!l.engine || !l.brake) {
    untestable(l, {"vehicle.brake_dead_time", "vehicle.brake_friction_temperature"},
               l.engine ? "no brake pressure in the log" : "no throttle in the log");
    return;
  }
  candidate(l, "vehicle.brake_dead_time", {"brake.dead_time_s", "s", 0.04, 0.008, true},
            {"deceleration follows the pressure late", "force(t) = k p(t - T)",
             "short brake pulses on a straight"},
            [](Setting& s, double v) { s.brake_s += v; });
  if (l.car.terms[Term::brake_fade] * l.car.parameters[P::brake_fade_1pmj] != 0.0) {
    untestable(l, {"vehicle.brake_friction_temperature"}, kStatedToo);
    return;
  }
  static const std::string lost =
      fmt::format("friction lost per {} MJ of heat", kFadeHeat_j / 1e6);
  for (const double time : {2.5, 10.0, 40.0})
    candidate(l, "vehicle.brake_friction_temperature",
              {lost.c_str(), "1", 0.1, 0.012, true},
              {"the pads' friction changes with their heat",
               fmt::format("mu = mu0 (1 - k heat); d(heat)/dt = power - heat/T; T {} s", time),
               "repeat equal stops with short and long pauses, or log the disc temperature"},
              [time](Setting& s, double v) {
                s.fade += v;
                s.fade_s = time;
              })
        .constants = {{"brake.fade_s", time}};
}

void wind_and_fuel(const Listing& l) {
  if (!l.engine) {
    untestable(l, {"environment.wind", "vehicle.fuel_burn"}, "no throttle in the log");
    return;
  }
  const Physics wind{"the air moves over the ground", "drag = k |v - w| (v - w)",
                     "drive the straight in both directions, or log the wind"};
  candidate(l, "environment.wind", {"wind towards +x", "m/s", 1.5, 0.8}, wind,
            [](Setting& s, double v) { s.wind_x += v; });
  candidate(l, "environment.wind", {"wind towards +y", "m/s", 1.5, 0.8}, wind,
            [](Setting& s, double v) { s.wind_y += v; });
  candidate(l, "vehicle.fuel_burn", {"mass lost", "kg/s", 0.05, 0.004, true},
            {"the car becomes lighter", "m(t) = m0 - k t", "weigh the car before and after"},
            [](Setting& s, double v) { s.burn += v; });
}

void steering(const Listing& l) {
  if (!l.lateral) {
    untestable(l, {"vehicle.steering_dead_time", "vehicle.steering_lag"},
               "side slip or steering is not logged");
    return;
  }
  candidate(l, "vehicle.steering_dead_time", {"steering.dead_time_s", "s", 0.03, 0.006, true},
            {"the wheels follow the steering late", "delta(t) = command(t - T)",
             "step steer at constant speed"},
            [](Setting& s, double v) { s.steer_s += v; });
  candidate(l, "vehicle.steering_lag", {"steering.lag_s", "s", 0.05, 0.006, true},
            {"the wheels follow the steering through a lag", "T d(delta)/dt = command - delta",
             "sine steer at two frequencies"},
            [](Setting& s, double v) { s.steer_lag_s += v; });
}

// What the Magic Formula of the stated tyre has and the stated car may leave out.
void tyre_term(const Listing& l, Term t, const Amount& amount, const char* text,
               std::function<void(Setting&, double)> set) {
  const std::string id = fmt::format("vehicle.{}", amount.name);
  if (l.car.terms[t] == 0.0)
    candidate(l, id, amount,
              {text, "as in the Magic Formula of the stated tyre",
               "constant-radius cornering at several speeds"},
              std::move(set));
  else
    untestable(l, {id.c_str()},
               "the stated car has it; what may be wrong about its curve is absorbed as uncertain");
}

void tyres(const Listing& l) {
  if (!l.lateral) {
    untestable(l,
               {"vehicle.tyre_thermal", "vehicle.tyre_load_sensitivity", "vehicle.tyre_camber",
                "vehicle.tyre_combined_slip", "vehicle.tyre_relaxation"},
               "side slip or steering is not logged");
    return;
  }
  if (l.car.terms[Term::tyre_thermal] == 0.0 &&
      l.car.terms[Term::tyre_warm_up] * l.car.parameters[P::tyre_warm_up_loss] == 0.0)
    for (const double time : {25.0, 80.0, 250.0})
      candidate(l, "vehicle.tyre_thermal", {"grip missing when cold", "1", 0.1, 0.025},
                {"the tyres' grip and stiffness change as they warm up",
                 "grip = 1 - k (1 - warmth); d(warmth)/dt = work / T",
                 "log the tyre temperature, or repeat the first laps on warm tyres"},
                [time](Setting& s, double v) {
                  s.thermal += v;
                  s.thermal_s = time;
                })
          .constants = {{"tyre.warm_up_s", time}};
  else
    untestable(l, {"vehicle.tyre_thermal"}, kStatedToo);
  tyre_term(l, Term::tyre_load_sensitivity, {"tyre_load_sensitivity", "1", 0.3, 0.3, true},
            "grip per load falls with load", [](Setting& s, double v) { s.load_sensitivity += v; });
  tyre_term(l, Term::tyre_camber, {"tyre_camber", "1", 0.3, 0.3, true},
            "inclined tyres push sideways", [](Setting& s, double v) { s.camber += v; });
  tyre_term(l, Term::tyre_combined_slip, {"tyre_combined_slip", "1", 0.3, 0.3, true},
            "braking and driving take side force away",
            [](Setting& s, double v) { s.combined += v; });
  tyre_term(l, Term::tyre_relaxation, {"tyre_relaxation", "1", 0.3, 0.4, true},
            "side force builds up over a distance",
            [](Setting& s, double v) { s.relaxation += v; });
}

void ride_height(const Listing& l) {
  if (!l.lateral)
    untestable(l, {"vehicle.aero_ride_height"}, "side slip or steering is not logged");
  else if (l.car.terms[Term::aero_ride_height] != 0.0)
    untestable(l, {"vehicle.aero_ride_height"}, "the stated car has it; see parameter.downforce");
  else
    candidate(l, "vehicle.aero_ride_height", {"downforce lost per kPa", "1", 0.05, 0.08},
              {"downforce changes as the car sinks", "A = A0 (1 - k q)",
               "constant-speed runs at two ride heights"},
              [](Setting& s, double v) { s.ride += v; });
}

void drag(const Listing& l) {
  if (l.car.terms[Term::aero_drag] != 0.0)
    untestable(l, {"vehicle.aero_drag"}, "the stated car has drag: see parameter.drag");
  else if (!l.engine)
    untestable(l, {"vehicle.aero_drag"}, "no throttle in the log");
  else
    candidate(l, "vehicle.aero_drag", {"aero_drag", "1", 0.1, 0.03, true},
              {"the air holds the car back, which the simulation leaves out", "F = -q A",
               "coast down from high speed"},
              [](Setting& s, double v) { s.drag += v; });
}

void downforce(const Listing& l) {
  if (l.car.terms[Term::aero_downforce] != 0.0)
    untestable(l, {"vehicle.aero_downforce"},
               "the stated car has downforce: see parameter.downforce");
  else if (!l.lateral && !has(l, kLoadFront))
    untestable(l, {"vehicle.aero_downforce"}, "neither wheel loads nor side slip are logged");
  else
    candidate(l, "vehicle.aero_downforce", {"aero_downforce", "1", 0.1, 0.05, true},
              {"the air presses the car down, which the simulation leaves out", "Fz += q A",
               "constant-radius cornering at several speeds"},
              [](Setting& s, double v) { s.down += v; });
}

void differential(const Listing& l) {
  if (!has(l, kWheelRearDifference))
    untestable(l, {"vehicle.differential"}, "the rear wheels' speeds are not both logged");
  else if (l.car.terms[Term::locked_differential] != 0.0)
    candidate(l, "vehicle.differential", {"locked_differential", "1", -0.2, 0.08},
              {"the driven wheels are coupled otherwise than stated",
               "torque = amount lock_nms (omega_l - omega_r)", "slow tight circles, power on and off"},
              [](Setting& s, double v) { s.locked += v; });
  else if (l.car.terms[Term::limited_slip] != 0.0)
    candidate(l, "vehicle.differential", {"limited_slip", "1", -0.2, 0.08},
              {"the driven wheels are coupled otherwise than stated",
               "torque = amount (preload + ramp torque)", "slow tight circles, power on and off"},
              [](Setting& s, double v) { s.limited_slip += v; });
  else
    candidate(l, "vehicle.differential", {"locked share", "1", 0.2, 0.08, true},
              {"the driven wheels are coupled", "omega_l - omega_r = -(1 - k) track r / R",
               "slow tight circles, power on and off"},
              [](Setting& s, double v) { s.lock += v; });
}

}  // namespace

void list_road(const Listing& l) {
  slopes(l);
  road_grip(l);
  road_place(l);
  untestable(l, {"road.kerb_or_roughness", "vehicle.multi_point_contact"},
             "outside what means of 0.3 s show");
}

void list_physics(const Listing& l) {
  engine(l);
  brakes(l);
  wind_and_fuel(l);
  steering(l);
  tyres(l);
  ride_height(l);
  drag(l);
  downforce(l);
  untestable(l, {"vehicle.mass"}, "the same change as parameter.mass: see there");
  untestable(l, {"vehicle.aero_slipstream"}, "the log names no opponent");
  untestable(l, {"vehicle.brake_disc_conductance"}, "outside what means of 0.3 s show");
  differential(l);
}

}  // namespace explain
