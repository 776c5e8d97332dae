#include "vehicle/poles.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "load_car.h"

namespace crgdrive {

int poles(const PolesCommand& command) {
  const vehicle::Vehicle v = load_vehicle(command.car);
  const auto car = vehicle::make_car(v.files, v.parameters, v.terms, v.contact);
  for (const double speed : command.speeds_mps) {
    const vehicle::Linearisation at = vehicle::linearise(car, speed, command.steps_s);
    terminal.print(fmt::format("{:.1f} m/s: explicit Euler stable up to {:.3f} ms\n", at.speed_mps,
               at.euler_step_s * 1e3));
    for (const auto& radius : at.radii)
      terminal.print(fmt::format(
          "  step {:g} ms: largest eigenvalue of a step {:.4f} explicit, {:.4f} semi-implicit\n",
          radius.step_s * 1e3, radius.explicit_euler, radius.semi_implicit));
    std::size_t shown = 0;
    for (const vehicle::Pole& pole : at.poles) {
      if (pole.imaginary_radps < 0.0 || shown++ >= 8) continue;
      terminal.print(fmt::format("  pole {:10.2f} {:+10.2f}i 1/s ({:.1f} Hz)\n", pole.real_1ps,
                 pole.imaginary_radps,
                 std::hypot(pole.real_1ps, pole.imaginary_radps) / 6.283185307179586));
    }
  }
  return 0;
}

}  // namespace crgdrive
