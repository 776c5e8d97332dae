#include "rolling_doubt.h"

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

/// Slip at which a tyre under this load drives its own rolling resistance.
double free_slip(const vehicle::Car<double>& car, std::size_t axle, double fz_n, double vx_mps) {
  vehicle::TyreInput<double> in;
  in.fz_n = fz_n;
  in.vx_mps = vx_mps;
  in.pressure_pa = car.parameters.axle(axle, P::front_tyre_pressure_pa);
  vehicle::TyreFactors<double> factors;
  factors.stiffness_x = car.parameters.axle(axle, P::front_tyre_slip_stiffness);
  const auto tyre = vehicle::tyre_forces(car.files->tyre[axle], in, factors, {.moments = true});
  const double force_n = tyre.my_nm / car.static_radius_m[axle];
  return tyre.slip_stiffness_n > 0.0 ? force_n / tyre.slip_stiffness_n : 0.0;
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
      const double resists = free_slip(car, a, w.fz_n.value[k], w.vx_mps[k]);
      w.kappa.sd[k] =
          std::hypot(w.kappa.sd[k], share * std::hypot(changed, kWarmth), share * resists);
    }
  }
}

}  // namespace identify
