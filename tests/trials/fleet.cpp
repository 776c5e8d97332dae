#include "fleet.h"

#include <cstdio>

#include "truth_car_electric.h"
#include "write_trial.h"

namespace trials {
namespace {

/// Another car: the second of the trials, or the third, which shares no equation with it; 10 %
/// about its middle.
TruthCar draw(bool third, Random& dice) {
  TruthCar car;
  if (third) car = electric_car(TyreLaw::kBrush);
  for (double* p : {&car.mass, &car.inertia, &car.mu_f, &car.mu_r, &car.c_f, &car.c_r, &car.drag,
                    &car.lift_f, &car.lift_r, &car.torque})
    *p *= dice.in(0.9, 1.1);
  return car;
}

}  // namespace

bool make_fleet(const std::string& name, int cars, int laps, unsigned long long seed,
                const std::filesystem::path& folder) {
  const bool banking = name == "banking" || name == "both",
             turbo = name == "turbo" || name == "both";
  if (!banking && !turbo && name != "none") {
    std::fprintf(stderr, "make_trials: no fleet %s; there are none banking turbo both\n",
                 name.c_str());
    return false;
  }
  std::filesystem::create_directories(folder / "sealed");
  for (int k = 0; k < cars; ++k) {
    Random dice{seed * 1000003ull + static_cast<unsigned long long>(k)};
    for (int warm = 0; warm < 5; ++warm) dice.uniform();
    Trial t;
    t.name = "car" + std::to_string(k);
    t.kind = "fleet";
    t.id = k;
    t.track = make_track(215, 0.22, 0.12, 0.035, 2.0);
    t.track.hill = {2.5, 0.8, 0.3};
    t.track.hill_phase = {1, 3, 5};
    t.track.bank_base = 0.01;
    t.nominal = t.truth.car = draw(k % 2 == 1, dice);
    if (banking) {
      t.stated_track = t.track;
      t.track.lean_m = kLean_m;
    }
    if (turbo && k == kLateCar)
      t.truth.car.effects.push_back({"vehicle.turbo_lag", "", 0.25, 0, 0, 0.4});
    t.sizes.assign(t.truth.car.effects.size(), 0.0);  // nothing is drawn by it
    t.off = 0.03;
    t.style.laps = laps;
    t.style.seed = seed * 7919 + static_cast<unsigned long long>(k);
    t.style.pace_high = dice.in(0.85, 0.95);
    t.accelerometers = false;
    if (!write_trial(t, dice, folder)) return false;
  }
  return true;
}

}  // namespace trials
