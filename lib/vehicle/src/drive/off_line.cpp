#include "off_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/laws/tyre_heat.h"

namespace vehicle {

void OffLine::look(const Car<double>& car, const State<double>& state, const Detail<double>& detail,
                   double away_m, double time_s, double step_s, double plan_k) {
  if (!limit_.empty()) return;
  double lifted = 0.0, front = 0.0, rear = 0.0, coldest_k = state[kTyre];
  for (std::size_t i = 0; i < kWheels; ++i) {
    const WheelDetail<double>& w = detail.wheel[i];
    if (w.fz_n <= 0.0) lifted += 1.0 / kWheels;
    (axle_of(i) == 0 ? front : rear) += 0.5 * std::abs(w.tan_alpha);
    coldest_k = std::min(coldest_k, state[kTyre + i]);
  }
  const double share = step_s / 1.0;  // of a second
  lifted_ += share * (lifted - lifted_);
  front_ += share * (front - front_);
  rear_ += share * (rear - rear_);
  if (away_m >= kFar_m)
    limit_ = fmt::format("{:.0f} m off the line first at t = {:.2f} s, u = {:.1f} m: {}", kFar_m,
                         time_s, detail.wheel[0].road.u_m, reason(car, coldest_k, plan_k));
}

std::string OffLine::reason(const Car<double>& car, double coldest_k, double plan_k) const {
  const auto grip = [&](double tyre_k) {
    return laws::tread_factors(car.parameters, car.files->tyre_grip, car.terms[Term::tyre_thermal],
                               tyre_k)
        .grip;
  };
  const double missing = 1.0 - grip(coldest_k) / grip(plan_k);
  if (lifted_ > 0.05)
    return fmt::format(
        "wheels were off the ground for {:.0f} % of the second before, on uneven ground or over "
        "kerbs; a larger --margin-m keeps the line away from the edges",
        100.0 * lifted_);
  if (missing > 0.05)
    return fmt::format(
        "the coldest tyre has {:.0f} K and {:.0f} % less grip than at the {:.0f} K that the plan "
        "reckons with; begin with this --tyre-k",
        coldest_k, 100.0 * missing, plan_k);
  return fmt::format(
      "the {} tyres slid more (slips {:.2f} in front, {:.2f} behind), so the car {}; a smaller "
      "--grip-usage leaves it more",
      rear_ > front_ ? "rear" : "front", front_, rear_,
      rear_ > front_ ? "turned in" : "went straight on");
}

}  // namespace vehicle
