#include "disc_temperature.h"

#include <algorithm>
#include <cmath>

#include "not_known.h"
#include "standing_car.h"
#include "vehicle/laws/brake_pads.h"
#include "vehicle/laws/disc_heat.h"

namespace explain {
namespace {

using P = vehicle::Parameter;
using vehicle::Term;
namespace laws = vehicle::laws;

double known(const std::vector<double>& values, std::size_t i) {
  return i < values.size() && std::isfinite(values[i]) ? std::max(0.0, values[i]) : 0.0;
}

/// Torque of one brake whose pads still have `bite` of their friction.
double torque_nm(const vehicle::Vehicle& car, std::size_t axle, double pressure_pa,
                 double surface_k, double bite) {
  const auto of = [&](P front) { return car.parameters.axle(axle, front); };
  double friction = of(P::front_brake_friction);
  if (std::isfinite(surface_k))
    friction = laws::pad_friction(friction, car.terms[Term::brake_friction_temperature],
                                  car.files.pad_friction, pressure_pa, surface_k);
  return laws::brake_torque(friction * bite, pressure_pa, of(P::front_brake_area_m2),
                            of(P::front_brake_radius_m));
}

double bite(const vehicle::Vehicle& car, double pad_heat_j) {
  return laws::pad_bite(car.terms[Term::brake_fade], car.parameters[P::brake_fade_1pmj],
                        pad_heat_j);
}

laws::DiscParameters<double> with(const laws::DiscParameters<double>& stated,
                                  const DiscAmounts& a) {
  laws::DiscParameters<double> d = stated;
  d.disc_share *= std::exp(a[kHeat]);
  d.surface_capacity_jpk *= std::exp(a[kSurface]);
  d.core_capacity_jpk *= std::exp(a[kCore]);
  d.conductance_wpk *= std::exp(a[kConductance]);
  d.conductance_slope_1pk += a[kRise] / laws::kConductanceReference_k;
  d.emissivity *= std::max(0.0, 1 + a[kEmissivity]);
  d.capacity_slope_1pk *= 1 + a[kCapacity];
  return d;
}

}  // namespace

std::vector<double> disc_temperature(const Stop& s, const vehicle::Vehicle& car,
                                     const DiscAmounts& a) {
  const auto& terms = car.terms;
  const auto disc = with(laws::disc_parameters(car.parameters, s.axle), a);
  laws::DiscAmounts<double> amount{terms[Term::brake_heating],    terms[Term::brake_conduction],
                                   terms[Term::brake_convection], terms[Term::brake_vanes],
                                   terms[Term::brake_radiation],  terms[Term::brake_heat_capacity]};
  amount.convection *= std::exp(a[kCooling]);
  const double radius_m = standing_radius_m(car, s.axle);
  double surface_k = kNaN, core_k = kNaN;
  std::vector<double> out(s.disc_k.size(), kNaN);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!std::isfinite(surface_k)) {
      if (!std::isfinite(s.disc_k[i])) continue;
      surface_k = s.disc_k[i];
      core_k = surface_k + 100 * a[kBegin];
    }
    out[i] = surface_k;
    const double speed = known(s.speed_mps, i), pressure = known(s.pressure_pa, i);
    const double brake_nm =
        torque_nm(car, s.axle, pressure, surface_k, bite(car, known(s.pad_heat_j, i)));
    const laws::DiscRates<double> rate =
        laws::disc_heat(disc, amount, surface_k, core_k, -brake_nm, speed / radius_m,
                        laws::disc_air(disc, amount, speed));
    surface_k = std::clamp(surface_k + kDiscStep_s * rate.surface_kps, 200.0, 3000.0);
    core_k = std::clamp(core_k + kDiscStep_s * rate.core_kps, 200.0, 3000.0);
  }
  return out;
}

std::vector<double> disc_pad_heat(const std::array<Stop, 2>& axles, const vehicle::Vehicle& car) {
  const auto& p = car.parameters;
  if (car.terms[Term::brake_fade] * p[P::brake_fade_1pmj] == 0.0) return {};
  const std::array<double, 2> radius_m{standing_radius_m(car, 0), standing_radius_m(car, 1)};
  std::vector<double> out(axles[0].speed_mps.size(), 0.0);
  double heat_j = 0.0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = heat_j;
    double brakes_w = 0.0;
    for (std::size_t k = 0; k < 2; ++k) {
      const double surface_k = i < axles[k].disc_k.size() ? axles[k].disc_k[i] : kNaN;
      brakes_w += 2 *
                  torque_nm(car, k, known(axles[k].pressure_pa, i), surface_k, bite(car, heat_j)) *
                  known(axles[k].speed_mps, i) / radius_m[k];
    }
    heat_j += kDiscStep_s * laws::pad_heat_rate(brakes_w, heat_j, p[P::brake_fade_s]);
  }
  return out;
}

}  // namespace explain
