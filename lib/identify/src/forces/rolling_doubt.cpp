#include "rolling_doubt.h"

#include <algorithm>
#include <cmath>

#include "vehicle/magic_formula.h"

namespace identify {
namespace {

using P = vehicle::Parameter;
// Of a radius over a drive, as the tyre's warmth and pressure change: no tyre file has it.
constexpr double kWarmth = 5e-4;

/// Of an axle's two wheels, over all rows.
double mean_radius_m(const std::vector<double>& left, const std::vector<double>& right) {
  double sum = 0.0, count = 0.0;
  for (const std::vector<double>* wheel : {&left, &right})
    for (const double r : *wheel)
      if (std::isfinite(r)) sum += r, count += 1.0;
  return sum / count;
}

/// By how much the slip of a tyre changes that drives its own rolling resistance too: where it
/// already slips, along and to the side, it yields more than at rest.
double slip_of_resistance(const vehicle::Car<double>& car, std::size_t axle,
                          vehicle::TyreInput<double> in) {
  constexpr double kStep = 1e-4, kLeast = 0.1;  // at a peak: of the stiffness at rest
  in.pressure_pa = car.parameters.axle(axle, P::front_tyre_pressure_pa);
  vehicle::TyreFactors<double> factors;
  factors.stiffness_x = car.parameters.axle(axle, P::front_tyre_slip_stiffness);
  vehicle::TyreOptions options = car.tyre_options;
  options.moments = true;
  const auto tyre = vehicle::tyre_forces(car.files->tyre[axle], in, factors, options);
  const auto force_n = [&](double more) {
    vehicle::TyreInput<double> there = in;
    there.kappa += more;
    return vehicle::tyre_forces(car.files->tyre[axle], there, factors, options).fx_n;
  };
  const double per_slip_n =
      std::max((force_n(kStep) - force_n(-kStep)) / (2.0 * kStep), kLeast * tyre.slip_stiffness_n);
  return per_slip_n > 0.0 ? tyre.my_nm / car.static_radius_m[axle] / per_slip_n : 0.0;
}

}  // namespace

void add_rolling_doubt(const vehicle::Car<double>& car, double share,
                       const std::array<std::vector<double>, vehicle::kWheels>& radius_m,
                       Forces& out) {
  if (!(share > 0.0)) return;
  for (std::size_t i = 0; i < vehicle::kWheels; ++i) {
    const std::size_t a = vehicle::axle_of(i);
    const double mean_m = mean_radius_m(radius_m[2 * a], radius_m[2 * a + 1]);
    WheelForces& w = out.wheel[i];
    for (std::size_t k = 0; k < radius_m[i].size(); ++k) {
      if (!std::isfinite(radius_m[i][k]) || !(w.fz_n.value[k] > 0.0)) continue;
      const double changed = radius_m[i][k] / mean_m - 1.0;
      const double resists = slip_of_resistance(car, a,
                                                {.fz_n = w.fz_n.value[k],
                                                 .kappa = w.kappa.value[k],
                                                 .tan_alpha = std::tan(w.alpha_rad.value[k]),
                                                 .vx_mps = w.vx_mps[k]});
      w.kappa.sd[k] =
          std::hypot(w.kappa.sd[k], share * std::hypot(changed, kWarmth), share * resists);
    }
  }
}

}  // namespace identify
