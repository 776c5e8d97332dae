#include "load_car.h"

namespace crgdrive {

vehicle::Vehicle load_vehicle(const CarOptions& options) {
  vehicle::Vehicle v = vehicle::read_vehicle(options.vehicle_path);
  if (!options.setup_path.empty()) vehicle::read_setup(v, options.setup_path);
  for (const std::string& setting : options.settings) vehicle::apply_setting(v, setting, "--set");
  if (options.contact == "single-point") v.contact = vehicle::Contact::kSinglePoint;
  if (options.contact == "four-point") v.contact = vehicle::Contact::kFourPoint;
  if (options.contact == "strip") v.contact = vehicle::Contact::kStrip;
  return v;
}

vehicle::StepOptions step_options(const CarOptions& options) {
  return {options.step_s, options.integrator == "explicit" ? vehicle::Integrator::kExplicitEuler
                                                           : vehicle::Integrator::kSemiImplicit};
}

}  // namespace crgdrive
