#include "explain/fuel.h"

#include <algorithm>
#include <cmath>

#include "vehicle/error.h"
#include "vehicle/laws/aero.h"
#include "vehicle/laws/fuel.h"

namespace explain {

using P = vehicle::Parameter;

std::vector<double> useful_power_w(const Signals& s, const vehicle::Vehicle& car) {
  const auto& p = car.parameters;
  const double drag = vehicle::laws::air_forces(p, 1.0, 1.0).drag_nspm *
                      car.terms[vehicle::Term::aero_drag];  // at 1 m/s
  std::vector<double> out(s.n, 0.0);
  for (std::size_t i = 0; i < s.n; ++i) {
    const double speed = s.x[kVx][i],
                 power = (p[P::chassis_mass_kg] * s.dx[kVx][i] + drag * speed * speed) * speed /
                         p[P::gearbox_efficiency];
    if (s.x[kThrottle][i] > 0.05 && power > 0) out[i] = power;
  }
  return out;
}

void add_fuel(recording::Table& log, Mapping& mapping, const Signals& s,
              const vehicle::Vehicle& car, double fuel_kg) {
  const auto time = std::find_if(mapping.columns.begin(), mapping.columns.end(),
                                 [](const ColumnMapping& m) { return m.channel == "time_s"; });
  const auto* const stamps = time == mapping.columns.end() ? nullptr : log.find(time->column);
  if (stamps == nullptr || stamps->empty() || s.n == 0)
    throw vehicle::Error(s.name + ": no time to burn fuel over");
  if (s.present[kFuel])
    throw vehicle::Error(s.name +
                         ": its fuel is logged, and another would be given; leave --fuel-kg out");
  const auto& p = car.parameters;
  const double amount = car.terms[vehicle::Term::fuel_burn];
  const std::vector<double> power = useful_power_w(s, car);
  std::vector<double> left(s.n, fuel_kg), column;
  for (std::size_t i = 1; i < s.n; ++i)
    left[i] = std::max(0.0, left[i - 1] - Signals::kStep_s * amount *
                                              (p[P::fuel_idle_kgps] +
                                               vehicle::laws::fuel_for_work(p, power[i - 1])));
  for (const double t : *stamps) {
    const double place = std::clamp(time->scale * (t - stamps->front()) / Signals::kStep_s, 0.0,
                                    static_cast<double>(s.n - 1));
    column.push_back(std::isfinite(place) ? left[static_cast<std::size_t>(place)] : NAN);
  }
  const std::string name = "fuel_kg of the simulated car";
  log.add(name, std::move(column));
  mapping.columns.push_back({name, "fuel_kg"});
}

}  // namespace explain
