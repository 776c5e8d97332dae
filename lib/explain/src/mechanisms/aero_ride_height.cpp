// Downforce that changes as the car sinks.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "car_changes.h"
#include "effect.h"
#include "listing.h"
#include "vehicle/driver.h"
#include "vehicle/error.h"
#include "vehicle/laws/aero.h"
#include "vehicle/step.h"

namespace explain::aero_ride_height {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;

constexpr const char* kId = "vehicle.aero_ride_height";
constexpr std::array<P, 2> kRide{P::front_ride_height_m, P::rear_ride_height_m};

/// Amount: share of the downforce that is lost per kPa of dynamic pressure.
constexpr Effect kSink{.on_the_way = [](Underway& now, const Acting& a) {
  now.lift *=
      1.0 - a.amount[0] *
                vehicle::laws::dynamic_pressure(now.parameters[P::aero_density_kgpm3], now.vx_mps) /
                1000.0;
}};

void list(const Listing& l) {
  if (!l.lateral) return untestable(l, kId, kNoSlip);
  if (l.car.terms[Term::aero_ride_height] != 0.0)
    return untestable(l, kId, "the stated car has it; see parameter.downforce");
  candidate(l, kId, {"downforce lost per kPa", "1", 0.05, 0.08},
            {"downforce changes as the car sinks", "A = A0 (1 - k q)",
             "constant-speed runs at two ride heights"},
            [](Setting& s, double v) { s.act(kSink, v); });
}

/// Heights of the floor at both axles of the simulated car, straight on at this speed, m.
std::array<double, 2> floor_at(const vehicle::Vehicle& stated,
                               const vehicle::Parameters<double>& parameters, double speed_mps) {
  const auto car = vehicle::make_car(stated.files, parameters, stated.terms);
  const vehicle::Road flat;
  vehicle::StartOptions begin;
  begin.speed_mps = speed_mps;
  begin.fuel_kg = 0;
  begin.gear = vehicle::choose_gear(car, speed_mps, vehicle::kMostGears);
  auto sim = vehicle::start(car, flat, begin);
  vehicle::Detail<double> detail;
  vehicle::Controls<double> controls;
  controls.gear_command = begin.gear;
  std::array<double, 2> sum{};
  constexpr int kSettle = 1500, kMean = 500;
  for (int i = 0; i < kSettle + kMean; ++i) {
    controls.throttle_command =
        std::clamp(0.3 + 0.5 * (speed_mps - sim.state[vehicle::kVx]), 0.0, 1.0);
    if (const auto result = vehicle::step(car, sim, controls, flat, {}, detail); !result.ok())
      throw vehicle::Error(
          "the stated car, straight on: " +
          vehicle::describe(result, sim.time_s, sim.state[vehicle::kX], sim.state[vehicle::kY]));
    if (i < kSettle) continue;
    for (std::size_t wheel = 0; wheel < vehicle::kWheels; ++wheel)
      sum[vehicle::axle_of(wheel)] += detail.wheel[wheel].ride_m / (2 * kMean);
  }
  return sum;
}

/// How far each axle sinks at a speed, and gives way.
struct Floor {
  std::array<double, 2> sink_m{}, give_mpn{};  ///< per newton of a wheel
  double pressed_n() const { return sink_m[0] / give_mpn[0] + sink_m[1] / give_mpn[1]; }
};

Floor sunken(const vehicle::Vehicle& car, const vehicle::Parameters<double>& parameters,
             double speed_mps) {
  Floor out;
  const auto floor = floor_at(car, parameters, speed_mps);
  for (std::size_t k = 0; k < 2; ++k) {
    out.sink_m[k] = parameters[kRide[k]] - floor[k];
    out.give_mpn[k] = 1 / std::max(1e4, parameters.axle(k, P::front_spring_npm)) +
                      1 / car.files.tyre[k].vertical_stiffness_npm;
  }
  return out;
}

/// A factor straight in both heights, weighed by what the axles give, so that pitching alone
/// changes nothing: `left` where the floor lies as found, 1 at the stated heights.
vehicle::Map2 lift_factor(const vehicle::Parameters<double>& parameters, const Floor& floor,
                          double left) {
  const double pressed = floor.pressed_n();
  const std::array<double, 2>& give = floor.give_mpn;
  vehicle::Map2 factor;
  for (std::size_t k = 0; k < 2; ++k) {
    // Far enough for brakes and kerbs; constant beyond.
    const double way = 2 * give[k] *
                       std::max(pressed, 0.5 * parameters[P::chassis_mass_kg] *
                                             parameters[P::environment_gravity_mps2]);
    (k == 0 ? factor.x : factor.y) = {parameters[kRide[k]] - way, parameters[kRide[k]] + way};
  }
  for (const double front : factor.x)
    for (const double rear : factor.y)
      factor.z.push_back(1 - (1 - left) / pressed *
                                 ((parameters[kRide[0]] - front) / give[0] +
                                  (parameters[kRide[1]] - rear) / give[1]));
  return factor;
}

/// Downforce over the heights of the floor, as steep as it takes to lose what was found at the
/// speed where it was mostly found.
void write(CarChanges& out, const Finding& f) {
  double sum = 0, all = 1e-300;
  // In proportion to the square of the force that is missing.
  at_speeds(out.logs, [&](double speed, double, double) {
    sum += std::pow(speed, 9), all += std::pow(speed, 8);
  });
  const double speed = sum / all;
  const double pressure = vehicle::laws::dynamic_pressure(out.now(P::aero_density_kgpm3), speed);
  const double left = 1 - f.parameters[0].value * pressure / 1000;
  vehicle::Parameters<double> parameters = out.car.parameters;
  for (const auto& [name, value] : out.parameters)
    parameters[*vehicle::find_parameter(name)] = value;
  for (const P lift : {P::front_lift_area_m2, P::rear_lift_area_m2}) parameters[lift] *= left;
  std::optional<Floor> floor;
  if (left > 0.3) try {
      floor = sunken(out.car, parameters, speed);
    } catch (const vehicle::Error& error) {
      out.remarks.push_back(fmt::format("{}: {}", f.mechanism, error.what()));
      return;
    }
  if (!floor || !(floor->pressed_n() > 100)) {
    out.remarks.push_back(fmt::format(
        "{}: {:.4g} per kPa; at {:.3g} m/s the floor does not sink in a way that could tell: not "
        "switched on",
        f.mechanism, f.parameters[0].value, speed));
    return;
  }
  vehicle::Map2 factor = lift_factor(parameters, *floor, left);
  out.maps["front_lift_factor"] = out.maps["rear_lift_factor"] = factor;
  if (!out.car.files.front_lift_factor.empty())
    out.remarks.push_back(fmt::format(
        "{}: the maps over ride heights that the stated car has switched off are replaced",
        f.mechanism));
  std::fill(factor.z.begin(), factor.z.end(), 1.0);
  out.maps["drag_factor"] = factor;
  out.set(Term::aero_ride_height, 1);
}

}  // namespace

std::vector<Mechanism> mechanisms() {
  return {{.id = kId, .list = list, .most = 0.8, .write_car = write, .turn = Turn::kLast}};
}

}  // namespace explain::aero_ride_height
