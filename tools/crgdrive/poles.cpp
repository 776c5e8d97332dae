#include "vehicle/poles.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "load_car.h"
#include "vehicle/step_swing.h"

namespace crgdrive {

int poles(const PolesCommand& command, Terminal& terminal) {
  const vehicle::Vehicle v = load_vehicle(command.car);
  const auto car = vehicle::make_car(v.files, v.parameters, v.terms, v.contact);
  std::string text;
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const double speed : command.speeds_mps) {
    const vehicle::Linearisation at = vehicle::linearise(car, speed, command.steps_s);
    nlohmann::ordered_json radii = nlohmann::ordered_json::array(),
                           poles = nlohmann::ordered_json::array();
    text += fmt::format("{:.1f} m/s: explicit Euler stable up to {:.3f} ms\n", at.speed_mps,
                        at.euler_step_s * 1e3);
    for (const auto& radius : at.radii) {
      text += fmt::format(
          "  step {:g} ms: largest eigenvalue of a step {:.4f} explicit, {:.4f} semi-implicit\n",
          radius.step_s * 1e3, radius.explicit_euler, radius.semi_implicit);
      const auto say = [&](const char* integrator, double swing) {
        if (swing > vehicle::StepSwing::kWorthSaying)
          text +=
              fmt::format("    {}: {}\n", integrator,
                          std::isfinite(swing)
                              ? fmt::format("swings from step to step by {:.2g} %", 100.0 * swing)
                              : "ends in numbers no car has");
      };
      say("explicit", radius.explicit_swing);
      say("semi-implicit", radius.semi_implicit_swing);
      const auto finite = [](double swing) {
        return std::isfinite(swing) ? nlohmann::ordered_json(swing) : nullptr;
      };
      radii.push_back({{"step_s", radius.step_s},
                       {"explicit", radius.explicit_euler},
                       {"semi_implicit", radius.semi_implicit},
                       {"explicit_swing", finite(radius.explicit_swing)},
                       {"semi_implicit_swing", finite(radius.semi_implicit_swing)}});
    }
    std::size_t shown = 0;
    for (const vehicle::Pole& pole : at.poles) {
      poles.push_back({{"real_1ps", pole.real_1ps}, {"imaginary_radps", pole.imaginary_radps}});
      if (pole.imaginary_radps < 0.0 || shown++ >= 8) continue;
      text += fmt::format("  pole {:10.2f} {:+10.2f}i 1/s ({:.1f} Hz)\n", pole.real_1ps,
                          pole.imaginary_radps,
                          std::hypot(pole.real_1ps, pole.imaginary_radps) / 6.283185307179586);
    }
    all.push_back({{"speed_mps", at.speed_mps},
                   {"euler_step_s", at.euler_step_s},
                   {"radii", radii},
                   {"poles", poles}});
  }
  terminal.print(terminal.json ? base::json_text(all) : text);
  return kOk;
}

}  // namespace crgdrive
