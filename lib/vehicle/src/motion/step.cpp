#include "vehicle/step.h"

#include <fmt/format.h>

#include "vehicle/error.h"
#include "wheel_names.h"

namespace vehicle {

std::string describe(const StepResult& result, double time_s, double u_m, double v_m) {
  const std::string place =
      fmt::format("at t = {:.3f} s, u = {:.2f} m, v = {:.2f} m", time_s, u_m, v_m);
  switch (result.problem) {
    case StepResult::Problem::kNotFinite:
      return fmt::format("{} stopped being a number {}", state_name(result.index), place);
    case StepResult::Problem::kRanAway:
      return fmt::format("{} ran away beyond 1000 {}; this car needs a smaller step",
                         state_name(result.index), place);
    case StepResult::Problem::kNoRoad:
      return fmt::format("no road under the {} wheel {}", kWheelNames[result.index], place);
    case StepResult::Problem::kRolledOver:
      return "the car rolled over " + place;
    case StepResult::Problem::kNone:
      break;
  }
  return "no problem " + place;
}

void check_step(const Parameters<double>& p, const StepOptions& options) {
  if (!(options.step_s > 0.0 && options.step_s <= 0.01))
    throw Error(fmt::format("step of {} s, wanted above 0 to 0.01 s", options.step_s));
  const double longest = options.step_s * (laws::Actuator<double>::kCapacity - 2);
  for (const Parameter which : {Parameter::steering_dead_time_s, Parameter::throttle_dead_time_s,
                                Parameter::brake_dead_time_s})
    if (p[which] > longest)
      throw Error(fmt::format("{} = {} s, but a step of {} s keeps only {} s of commands",
                              parameter_list()[static_cast<std::size_t>(which)].name, p[which],
                              options.step_s, longest));
}

template void derivative(const Car<double>&, const State<double>&, const Inputs<double>&,
                         const Road&, RoadCursors&, State<double>&, Detail<double>&);
template StepResult step(const Car<double>&, Simulation<double>&, const Controls<double>&,
                         const Road&, const StepOptions&, Detail<double>&);

}  // namespace vehicle
