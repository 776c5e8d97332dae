#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "fmu/instance.h"

namespace fmu {

/// What the solver does for a step of an importer, and how often.
vehicle::StepOptions Instance::solver_steps(double step_s, double& count) const {
  constexpr double kShortest_s = 1e-6, kLongest_s = 3600.0, kRounding = 1e-6;
  const double own_s = start(Start::kSolverStep);
  if (!(step_s >= kShortest_s && step_s <= kLongest_s))
    throw base::Error(fmt::format("a step of {} s was asked for, wanted {} to {} s", step_s,
                                  kShortest_s, kLongest_s));
  vehicle::StepOptions options = options_;
  const double whole = std::round(step_s / own_s);
  if (whole >= 1.0 && std::abs(whole * own_s - step_s) <= kRounding * own_s) {
    count = whole;
    return options;
  }
  count = std::ceil(step_s / own_s);
  options.step_s = step_s / count;
  vehicle::check_step(car_.parameters, options);
  return options;
}

void Instance::step(double time_s, double step_s) {
  if (now_.phase != Phase::kStepping)
    throw base::Error(now_.phase == Phase::kFailed
                          ? "the run has ended with an error; reset the unit"
                          : "a step was asked for before initialisation or after the end");
  const double own_s = start(Start::kSolverStep), now_s = this->time_s();
  constexpr double kSum = 1e-3;  // of a solver step: what sums of an importer's steps are off
  if (!(std::abs(time_s - now_s) < 0.5 * own_s))
    throw base::Error(
        fmt::format("a step from t = {} s was asked for, but the car is at {} s", time_s, now_s));
  if (changed_) build_car();
  changed_ = false;
  double count = 0.0;
  const vehicle::StepOptions options = solver_steps(step_s, count);
  // An importer's clock that runs away slowly counts.
  if (std::abs(time_s - now_s) > kSum * own_s) now_.begin_s += time_s - now_s;
  const vehicle::Controls<double> asked = controls();
  vehicle::Controls<double> with_wake;
  vehicle::Detail<double> detail;
  for (double i = 0.0; i < count; i += 1.0) {
    with_wake = asked;
    look_at_opponents(with_wake);
    const double at_s = this->time_s();
    const vehicle::StepResult result =
        vehicle::step(car_, now_.simulation, with_wake, files_->road, options, detail);
    if (!result.ok()) {
      now_.phase = Phase::kFailed;
      const vehicle::RoadPoint& under = detail.wheel[0].road;
      throw base::Error(vehicle::describe(result, at_s, under.u_m, under.v_m));
    }
    if (options.step_s != own_s) now_.begin_s += options.step_s - own_s;
  }
  show_outputs(detail, with_wake);
}

}  // namespace fmu
