// Pads whose friction changes with their heat.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "car_changes.h"
#include "effect.h"
#include "listing.h"
#include "standing_car.h"
#include "vehicle/laws/brake_pads.h"

namespace explain::brake_friction_temperature {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;
namespace laws = vehicle::laws;

constexpr const char* kId = "vehicle.brake_friction_temperature";

/// The heat of the pads of all wheels per which a fade is told: three quarters of a megajoule,
/// about one stop of the stated racer from 45 m/s. brake.fade_1pmj counts per megajoule.
constexpr double kFadeHeat_j = 0.75e6;
constexpr double fade_1pmj(double per_fade_heat) { return per_fade_heat * 1e6 / kFadeHeat_j; }

/// What counts of it. Cars with nothing missing in their brakes show up to 0.01 on MF tyres, and
/// 0.02 to 0.08 beside another effect on the brush tyres of the trials' third car.
constexpr double kLeastFade = 0.09;

/// Amount: friction lost per kFadeHeat_j; constant: time of cooling, s.
constexpr Effect kFade{[](vehicle::Car<double>& car, const Acting& a) {
  const double stated = car.terms[Term::brake_fade] * car.parameters[P::brake_fade_1pmj];
  if (stated == 0) car.parameters[P::brake_fade_s] = a.constant[0];
  car.parameters[P::brake_fade_1pmj] = stated + fade_1pmj(a.amount[0]);
  car.terms[Term::brake_fade] = 1.0;
}};

void list(const Listing& l) {
  if (!l.engine || !l.brake)
    return untestable(l, kId, l.engine ? "no brake pressure in the log" : kNoThrottle);
  if (l.car.terms[Term::brake_fade] * l.car.parameters[P::brake_fade_1pmj] != 0.0)
    return untestable(l, kId, kStatedToo);
  static const std::string lost = fmt::format("friction lost per {} MJ of heat", kFadeHeat_j / 1e6);
  for (const double time : {2.5, 10.0, 40.0})
    candidate(l, kId, {lost.c_str(), "1", 0.1, kLeastFade, true},
              {"the pads' friction changes with their heat",
               fmt::format("mu = mu0 (1 - k heat); d(heat)/dt = power - heat/T; T {} s", time),
               "repeat equal stops with short and long pauses, or log the disc temperature"},
              [time](Setting& s, double v) {
                s.act(kFade, v, {time, 0.0});
              })
        .constants = {{"brake.fade_s", time}};
}

/// Force of all brakes before they fade, by recorded pressures; wheels roll as the standing car's.
std::vector<double> cold_force_n(const recording::Recording& recording,
                                 const vehicle::Vehicle& car) {
  const auto& p = car.parameters;
  const std::vector<double>& time = *recording.table.find("time_s");
  std::vector<double> out(time.size(), 0.0);
  constexpr std::array<const char*, vehicle::kWheels> kBrake{"brake_fl", "brake_fr", "brake_rl",
                                                             "brake_rr"};
  for (std::size_t wheel = 0; wheel < vehicle::kWheels; ++wheel)
    for (const bool commanded : {false, true}) {
      const auto* const column =
          recording.table.find(std::string(kBrake[wheel]) + (commanded ? "_command_pa" : "_pa"));
      if (column == nullptr) continue;
      const std::size_t axle = vehicle::axle_of(wheel);
      const double friction =
          p.axle(axle, P::front_brake_friction) * (commanded ? p[P::brake_gain] : 1.0);
      const double radius_m = standing_radius_m(car, axle);
      const std::vector<double> pressure = recording::fill_gaps(time, *column);
      for (std::size_t i = 0; i < time.size(); ++i)
        out[i] += laws::brake_torque(friction, std::max(0.0, pressure[i]),
                                     p.axle(axle, P::front_brake_area_m2),
                                     p.axle(axle, P::front_brake_radius_m)) /
                  radius_m;
      break;
    }
  return out;
}

/// `pad_heat_j`, the heat of the pads of a car whose brakes fade, by recorded pressures and speed;
/// cold at the log's begin. The pads' friction is the constant one.
void add_pad_heat(recording::Recording& recording, const vehicle::Vehicle& car) {
  const auto& p = car.parameters;
  const double amount = car.terms[Term::brake_fade];
  if (amount * p[P::brake_fade_1pmj] == 0.0) return;
  const std::vector<double>& time = *recording.table.find("time_s");
  const std::vector<double> speed = recording::fill_gaps(time, *recording.table.find("vx_mps"));
  const std::vector<double> cold_n = cold_force_n(recording, car);
  std::vector<double> heat(time.size(), 0.0);
  for (std::size_t i = 1; i < time.size(); ++i) {
    const double step_s = time[i] - time[i - 1];
    const double bite = laws::pad_bite(amount, p[P::brake_fade_1pmj], heat[i - 1]);
    // Over a gap nobody knows whether it braked.
    heat[i] = step_s > 1
                  ? heat[i - 1] * std::exp(-step_s / p[P::brake_fade_s])
                  : heat[i - 1] + step_s * laws::pad_heat_rate(
                                               bite * cold_n[i - 1] * std::max(0.0, speed[i - 1]),
                                               heat[i - 1], p[P::brake_fade_s]);
  }
  if (std::isfinite(heat.back())) recording.table.add("pad_heat_j", heat);
}

void write(CarChanges& out, const Finding& f) {
  out.set(Term::brake_fade, 1);
  out.set(P::brake_fade_1pmj, fade_1pmj(f.parameters[0].value));
  out.set_constants(f);
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kId, .list = list, .most = 0.9, .add_state = add_pad_heat, .write_car = write}};
}

}  // namespace explain::brake_friction_temperature
