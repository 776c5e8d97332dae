#include "engine_and_brakes.h"

#include <algorithm>

namespace explain {

vehicle::Map2 shaped_engine_map(const vehicle::Map2& stated, const std::array<double, 4>& shape,
                                double limit_radps) {
  if (shape == std::array<double, 4>{}) return stated;
  vehicle::Map2 out{stated.x, stated.y, {}};
  // Throttles fine enough to carry a shape.
  for (int i = 0; i <= 8; ++i) out.y.push_back(0.125 * i);
  std::sort(out.y.begin(), out.y.end());
  out.y.erase(std::unique(out.y.begin(), out.y.end()), out.y.end());
  for (const double radps : out.x) {
    const double w = radps / limit_radps - 0.7, full = vehicle::evaluate(stated, radps, 1.0);
    for (const double opening : out.y)
      out.z.push_back(vehicle::evaluate(stated, radps, opening) +
                      full * (shape[0] * 4 * opening * (1 - opening) +
                              opening * (shape[1] * w * 4 + shape[2] * (w * w * 16 - 0.5)) +
                              shape[3] * (1 - opening) * 0.3));
  }
  return out;
}

std::vector<vehicle::Parameter> brake_strength(const vehicle::Vehicle& car) {
  using P = vehicle::Parameter;
  const bool mapped =
      car.terms[vehicle::Term::brake_friction_temperature] > 0 && !car.files.pad_friction.empty();
  return mapped ? std::vector{P::front_brake_area_m2, P::rear_brake_area_m2}
                : std::vector{P::front_brake_friction, P::rear_brake_friction};
}

}  // namespace explain
