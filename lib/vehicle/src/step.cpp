#include "vehicle/step.h"

#include <fmt/format.h>

#include "vehicle/error.h"

namespace vehicle {
namespace {

constexpr std::string_view kWheelNames[] = {"front left", "front right", "rear left", "rear right"};

constexpr std::array<std::string_view, kStateSize> kStateNames{"x_m",
                                                               "y_m",
                                                               "z_m",
                                                               "roll_rad",
                                                               "pitch_rad",
                                                               "yaw_rad",
                                                               "vx_mps",
                                                               "vy_mps",
                                                               "vz_mps",
                                                               "roll_rate_radps",
                                                               "pitch_rate_radps",
                                                               "yaw_rate_radps",
                                                               "travel_fl_m",
                                                               "travel_fr_m",
                                                               "travel_rl_m",
                                                               "travel_rr_m",
                                                               "travel_rate_fl_mps",
                                                               "travel_rate_fr_mps",
                                                               "travel_rate_rl_mps",
                                                               "travel_rate_rr_mps",
                                                               "wheel_fl_radps",
                                                               "wheel_fr_radps",
                                                               "wheel_rl_radps",
                                                               "wheel_rr_radps",
                                                               "slip_x_fl_m",
                                                               "slip_x_fr_m",
                                                               "slip_x_rl_m",
                                                               "slip_x_rr_m",
                                                               "slip_y_fl_m",
                                                               "slip_y_fr_m",
                                                               "slip_y_rl_m",
                                                               "slip_y_rr_m",
                                                               "tyre_fl_k",
                                                               "tyre_fr_k",
                                                               "tyre_rl_k",
                                                               "tyre_rr_k",
                                                               "disc_surface_fl_k",
                                                               "disc_surface_fr_k",
                                                               "disc_surface_rl_k",
                                                               "disc_surface_rr_k",
                                                               "disc_core_fl_k",
                                                               "disc_core_fr_k",
                                                               "disc_core_rl_k",
                                                               "disc_core_rr_k",
                                                               "engine_radps",
                                                               "boost",
                                                               "fuel_kg",
                                                               "pad_heat_j",
                                                               "tyre_warmth",
                                                               "manifold_pa",
                                                               "charge_pa",
                                                               "exhaust_pa",
                                                               "turbo_radps"};

}  // namespace

std::string_view state_name(std::size_t index) { return kStateNames[index]; }

std::string describe(const StepResult& result, double time_s, double u_m, double v_m) {
  const std::string place =
      fmt::format("at t = {:.3f} s, u = {:.2f} m, v = {:.2f} m", time_s, u_m, v_m);
  switch (result.problem) {
    case StepResult::Problem::kNotFinite:
      return fmt::format("{} stopped being a number {}", kStateNames[result.index], place);
    case StepResult::Problem::kRanAway:
      return fmt::format("{} ran away beyond 1000 {}; this car needs a smaller step",
                         kStateNames[result.index], place);
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
  const double longest = options.step_s * (Actuator<double>::kCapacity - 2);
  for (const Parameter which : {Parameter::steering_dead_time_s, Parameter::throttle_dead_time_s,
                                Parameter::brake_dead_time_s})
    if (p[which] > longest)
      throw Error(fmt::format("{} = {} s, but a step of {} s keeps only {} s of commands",
                              parameter_list()[static_cast<std::size_t>(which)].name, p[which],
                              options.step_s, longest));
}

}  // namespace vehicle
