#include "vehicle/step_swing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "wheel_names.h"

namespace vehicle {
namespace {

constexpr std::array<const char*, 4> kOfWheel{"load", "longitudinal force", "side force", "speed"};
constexpr std::array<const char*, 4> kOfCar{"longitudinal acceleration", "lateral acceleration",
                                            "vertical acceleration", "engine speed"};

}  // namespace

void StepSwing::look(const Car<double>& car, const State<double>& state,
                     const Detail<double>& detail) {
  for (std::size_t k = 0; k < kQuantities; ++k) {
    double value = 0.0, scale = 9.81;
    if (k < 4 * kWheels) {
      const std::size_t i = k / 4;
      const WheelDetail<double>& w = detail.wheel[i];
      const bool is_speed = k % 4 == 3;
      value = k % 4 == 0 ? w.fz_n : k % 4 == 1 ? w.fx_n : k % 4 == 2 ? w.fy_n : w.spin_radps;
      scale = is_speed ? std::max(kSlow_radps, std::abs(value)) : car.static_load_n[axle_of(i)];
    } else {
      const Vec3<double>& a = detail.specific_force_mps2;
      const std::size_t i = k - 4 * kWheels;
      value = i == 0 ? a.x : i == 1 ? a.y : i == 2 ? a.z : state[kEngine];
      if (i == 3) scale = std::max(kSlow_radps, std::abs(value));
    }
    Quantity& q = quantities_[k];
    const double change = value - q.value;
    q.value = value;
    q.run = change * q.changes[q.next] < 0.0 ? q.run + 1 : 0;
    q.next = (q.next + 1) % kRun;
    q.changes[q.next] = change;
    if (q.run < kRun) continue;
    double least = std::abs(change);
    for (const double one : q.changes) least = std::min(least, std::abs(one));
    if (least / scale > largest_) {
      largest_ = least / scale;
      which_ = k;
    }
  }
}

std::string StepSwing::warning(const StepOptions& options) const {
  if (!(largest_ > kWorthSaying)) return {};
  const std::string what =
      which_ < 4 * kWheels
          ? fmt::format("the {} of the {} wheel", kOfWheel[which_ % 4], kWheelNames[which_ / 4])
          : fmt::format("the {}", kOfCar[which_ - 4 * kWheels]);
  return fmt::format(
      "{} swings from step to step by {:.2g} % (of its size, the static load or gravity): a step "
      "of "
      "{:g} ms does not resolve these parameters; crgdrive poles tells which step does",
      what, 100.0 * largest_, 1e3 * options.step_s);
}

}  // namespace vehicle
