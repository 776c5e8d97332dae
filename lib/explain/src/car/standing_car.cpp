#include "standing_car.h"

#include "vehicle/magic_formula.h"

namespace explain {

using P = vehicle::Parameter;

double standing_load_n(const vehicle::Vehicle& car, std::size_t axle) {
  const auto& p = car.parameters;
  const double wheelbase = p[P::chassis_wheelbase_m], ahead = p[P::chassis_cog_behind_front_m];
  return p[P::chassis_mass_kg] * p[P::environment_gravity_mps2] *
         (axle == 0 ? wheelbase - ahead : ahead) / (2 * wheelbase);
}

double standing_radius_m(const vehicle::Vehicle& car, std::size_t axle) {
  return vehicle::standing_rolling_radius(car.files.tyre[axle], standing_load_n(car, axle),
                                          car.parameters.axle(axle, P::front_tyre_pressure_pa));
}

}  // namespace explain
