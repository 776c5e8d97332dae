#include "unlogged_states.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "vehicle/laws/boost.h"
#include "vehicle/laws/brake_pads.h"
#include "vehicle/laws/tyre_warm_up.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;
namespace laws = vehicle::laws;

}  // namespace

double standing_radius_m(const vehicle::Vehicle& car, std::size_t axle) {
  const auto& p = car.parameters;
  const double wheelbase = p[P::chassis_wheelbase_m], ahead = p[P::chassis_cog_behind_front_m];
  const double load_n = p[P::chassis_mass_kg] * p[P::environment_gravity_mps2] *
                        (axle == 0 ? wheelbase - ahead : ahead) / (2 * wheelbase);
  return vehicle::standing_rolling_radius(car.files.tyre[axle], load_n,
                                          p.axle(axle, P::front_tyre_pressure_pa));
}

void add_boost(vehicle::Recording& recording, const vehicle::Vehicle& car) {
  const std::vector<double>* throttle = recording.table.find("throttle");
  if (throttle == nullptr) throttle = recording.table.find("throttle_command");
  if (car.terms[Term::turbo_lag] == 0.0 || throttle == nullptr ||
      recording.table.find("boost") != nullptr)
    return;
  const laws::BoostParameters<double> turbo = laws::boost_parameters(car.parameters);
  const std::vector<double>& time = *recording.table.find("time_s");
  const std::vector<double> opening = vehicle::fill_gaps(time, *throttle);
  const auto* const engine = recording.table.find("engine_radps");
  const std::vector<double> speed = engine == nullptr
                                        ? std::vector<double>(time.size(), turbo.reference_radps)
                                        : vehicle::fill_gaps(time, *engine);
  std::vector<double> boost(time.size(), opening.front());
  for (std::size_t i = 1; i < time.size(); ++i)
    boost[i] =
        laws::boost_after(turbo, boost[i - 1], speed[i - 1], opening[i - 1], time[i] - time[i - 1]);
  if (std::isfinite(boost.back())) recording.table.add("boost", boost);
}

void add_pad_heat(vehicle::Recording& recording, const vehicle::Vehicle& car) {
  const auto& p = car.parameters;
  const double amount = car.terms[Term::brake_fade];
  if (amount * p[P::brake_fade_1pmj] == 0.0) return;
  const std::vector<double>& time = *recording.table.find("time_s");
  const std::vector<double> speed = vehicle::fill_gaps(time, *recording.table.find("vx_mps"));
  std::vector<double> cold_n(time.size(), 0.0);  // force of all brakes before they fade
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
      const std::vector<double> pressure = vehicle::fill_gaps(time, *column);
      for (std::size_t i = 0; i < time.size(); ++i)
        cold_n[i] += laws::brake_torque(friction, std::max(0.0, pressure[i]),
                                        p.axle(axle, P::front_brake_area_m2),
                                        p.axle(axle, P::front_brake_radius_m)) /
                     radius_m;
      break;
    }
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

void add_warmth(vehicle::Recording& recording, const vehicle::Vehicle& car) {
  const auto& p = car.parameters;
  const auto* const rate = recording.table.find("yaw_rate_radps");
  if (car.terms[Term::tyre_warm_up] * p[P::tyre_warm_up_loss] == 0.0 || rate == nullptr) return;
  const std::vector<double>& time = *recording.table.find("time_s");
  const std::vector<double> speed = vehicle::fill_gaps(time, *recording.table.find("vx_mps"));
  const std::vector<double> turning = vehicle::fill_gaps(time, *rate);
  std::vector<double> warmth(time.size(), 0.0);
  for (std::size_t i = 1; i < time.size(); ++i)
    warmth[i] = laws::warmth_after(warmth[i - 1], p[P::tyre_warm_up_s],
                                   speed[i - 1] * turning[i - 1], time[i] - time[i - 1]);
  if (std::isfinite(warmth.back())) recording.table.add("tyre_warmth", warmth);
}

}  // namespace explain
