#include "stated_electric.h"

#include <cstdio>

namespace trials {
namespace {

// Over loads of 0.35 to 1.7 of the nominal and slips up to 0.14, weighted towards small ones. The
// forces differ by 2.1 % of the peak (RMS); brush and formula begin 5 % apart at small slips.
constexpr TyreFit kBrushFit{1.179,  0.908, 0.2008, 1.029, 0.2093, 1.117, 0.9263, 2.579, 1.041,
                            0.1956, 1.153, 12.63,  12.94, 0.9757, 13.52, 11.82,  0.9839};
constexpr TyreFit kTableFit{1.061,   0.9851, 0.1824, 1.403, -0.369, 1.004, 1.005, 2.642, 1.438,
                            -0.3541, 1.064,  9.728,  9.557, 1.137,  10.97, 8.921, 1.116};

std::string line(const std::string& name, double value) {
  char text[100];
  std::snprintf(text, sizeof text, "  %s: %.6g\n", name.c_str(), value);
  return text;
}

}  // namespace

const TyreFit& electric_fit(TyreLaw law) { return law == TyreLaw::kBrush ? kBrushFit : kTableFit; }

void state_electric(StatedCar& car, const TruthCar& truth, Random& dice, double share) {
  const Electric& e = *truth.electric;
  const auto off = [&](double times = 1.0) {
    return dice.in(1 - times * share, 1 + times * share);
  };
  car.front.fit = car.rear.fit = &electric_fit(e.tyre);
  car.drag_height_m = e.drag_height * off();
  std::string& posts = car.first_parameters;
  posts.clear();
  for (const std::size_t axle : {0u, 1u}) {
    const std::string name = axle == 0 ? "front." : "rear.";
    posts += line(name + "spring_npm", e.spring[axle] * off());
    posts += line(name + "anti_roll_npm", e.bar[axle] * off());
    posts += line(name + "bump_damping_nspm", e.damping[axle] * off(5));
    posts += line(name + "rebound_damping_nspm", e.damping[axle] * off(5));
    posts += line(name + "damper_fast_share", 1);
  }
  posts += line("chassis.roll_inertia_kgm2", e.roll_inertia * off(5)) +
           line("chassis.pitch_inertia_kgm2", e.pitch_inertia * off(5));
  // A pole twice and a zero on one of them: one pole.
  const auto pole = [&](const std::string& name, double time_s) {
    time_s *= off();
    posts += line(name + ".dead_time_s", 0) + line(name + ".lag_s", time_s) +
             line(name + ".damping", 1) + line(name + ".lead_s", time_s);
  };
  pole("steering", e.steer_s);
  pole("throttle", e.throttle_s);
  pole("brake", e.brake_s);
  car.drivetrain = line("engine.limit_radps", 2100) + line("engine.idle_radps", 10) +
                   line("engine.idle_gain_nms", 0) +
                   line("front.wheel_inertia_kgm2", truth.wheel_inertia) +
                   line("rear.wheel_inertia_kgm2", truth.wheel_inertia) +
                   line("gearbox.efficiency", truth.efficiency) +
                   line("gearbox.final", truth.final_drive) + line("gearbox.ratio_1", 1);
  for (int gear = 2; gear <= 6; ++gear)
    car.drivetrain += line("gearbox.ratio_" + std::to_string(gear), 0);
  car.terms += ", bump_stop: 0";
  for (const std::string name : {"steering", "throttle", "brake"}) {
    const std::string was = name + "_actuator: 0";
    car.terms.replace(car.terms.find(was), was.size(), name + "_actuator: 1");
  }
}

}  // namespace trials
