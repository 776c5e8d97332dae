#include "car_changes.h"

namespace explain {

std::string name_of(vehicle::Parameter p) {
  return std::string(vehicle::parameter_list()[static_cast<std::size_t>(p)].name);
}

std::string name_of(vehicle::Term t) {
  return std::string(vehicle::term_list()[static_cast<std::size_t>(t)].name);
}

bool CarChanges::none() const {
  return parameters.empty() && terms.empty() && tyre[0].empty() && tyre[1].empty() &&
         maps.empty() && !strip && remarks.empty();
}

double CarChanges::now(vehicle::Parameter p) const {
  const auto at = parameters.find(name_of(p));
  return at == parameters.end() ? car.parameters[p] : at->second;
}

void CarChanges::set_constants(const Finding& f) {
  for (std::size_t k = 1; k < f.parameters.size(); ++k)
    parameters[f.parameters[k].name] = f.parameters[k].value;
}

}  // namespace explain
