#include "blind.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "blind_car.h"
#include "truth_car_electric.h"
#include "write_trial.h"

namespace trials {
namespace {

using Json = nlohmann::ordered_json;

const std::array<const char*, 8> kKinds{"none",   "none", "single",  "single",
                                        "single", "two",  "outside", "alike"};
/// Terms of the tyre that truth and stated car may both lack.
const std::vector<std::string> kLacking{"vehicle.tyre_load_sensitivity", "vehicle.tyre_camber",
                                        "vehicle.tyre_combined_slip"};

Track draw_track(Random& dice) {
  const double phase = dice.in(0, 6), a5 = dice.in(0.02, 0.05), a3 = dice.in(0.06, 0.16),
               a2 = dice.in(0.12, 0.28), radius_m = dice.in(160, 300);
  Track t = make_track(radius_m, a2, a3, a5, phase);
  for (std::size_t k = 0; k < 3; ++k)
    t.hill[k] = dice.in(0, 4.0 / static_cast<double>((k + 1) * (k + 1))),
    t.hill_phase[k] = dice.in(0, 6);
  t.bank_base = dice.in(0, 0.02);
  return t;
}

/// Dice of their own, so that the second car's trials stay what they are.
bool is_third(int id, unsigned long long seed, double share) {
  Random dice{seed * 7368787ull + 104729ull * static_cast<unsigned long long>(id) + 11};
  dice.uniform();
  return dice.uniform() < share;
}

/// What else the third car has, 10 % about its middle; half of them have each law of tyre.
TruthCar draw_electric(Random& dice) {
  TruthCar car = electric_car(dice.uniform() < 0.5 ? TyreLaw::kBrush : TyreLaw::kTable);
  Electric& e = *car.electric;
  for (double* p : {&e.spring[0], &e.spring[1], &e.bar[0], &e.bar[1], &e.damping[0], &e.damping[1],
                    &e.drag_height, &e.base_radps, &car.ck})
    *p *= dice.in(0.9, 1.1);
  e.levelled = dice.uniform() < 0.5;
  e.steer_s = dice.in(0.01, 0.05);
  e.throttle_s = dice.in(0.02, 0.1);
  e.brake_s = dice.in(0.02, 0.08);
  return car;
}

Variant draw_car(bool third, Random& dice) {
  Variant v;
  if (third) v.car = draw_electric(dice);
  for (double* p : {&v.car.mass, &v.car.inertia, &v.car.mu_f, &v.car.mu_r, &v.car.c_f, &v.car.c_r,
                    &v.car.drag, &v.car.lift_f, &v.car.lift_r, &v.car.torque})
    *p *= dice.in(0.9, 1.1);
  return v;
}

/// A term that the stated car leaves out need not be missing: here and there the truth lacks it
/// too.
std::string draw_lacking(const std::vector<Effect>& effects, Variant& nominal, Random& dice) {
  if (dice.uniform() >= 0.2) return "";
  const std::string lacking = kLacking[dice.below(kLacking.size())];
  if (is_about(effects, lacking)) return "";
  if (lacking == "vehicle.tyre_camber") nominal.car.camber = dice.in(0.02, 0.05);
  return lacking;
}

/// The third car has neither a turbo nor fuel.
Question choose_for(bool third, const std::string& kind, Random& dice) {
  const auto fits = [&](const Question& q) {
    return !third || std::none_of(q.chosen.begin(), q.chosen.end(), [](const Choice& c) {
      const std::string mechanism = c.mechanism;
      return mechanism == "vehicle.turbo_lag" || mechanism == "vehicle.fuel_burn";
    });
  };
  Question q = choose(kind, dice);
  while (!fits(q)) q = choose(kind, dice);
  return q;
}

/// Some logs lack channels; what a trial is about stays in.
Logged draw_logged(const Question& question, const std::vector<Effect>& effects, bool third,
                   Random& dice) {
  const auto needs = [&](const char* column) {
    return std::any_of(effects.begin(), effects.end(), [&](const Effect& e) {
      return e.channel.find(column) != std::string::npos;
    });
  };
  const bool nothing = effects.empty() && question.parameters.empty();
  const bool commanded = std::any_of(question.parameters.begin(), question.parameters.end(),
                                     [](std::size_t k) { return kParameters[k].commanded; });
  Logged logged;
  logged.axle_loads = dice.uniform() < 0.3;
  logged.az = dice.uniform() < 0.5 || is_about(effects, "road.vertical_curvature");
  logged.engine = dice.uniform() < 0.6;
  logged.gear = dice.uniform() < 0.85;
  logged.engine |= !logged.gear;
  logged.ax = dice.uniform() < 0.85 || needs("ax_mps2");
  logged.ay = dice.uniform() < 0.8 || needs("ay_mps2");
  logged.vy = dice.uniform() < 0.92 || !nothing;  // side slip is rarely logged in earnest
  logged.commands = dice.uniform() < 0.4 || commanded || question.kind == "alike" ||
                    is_about(effects, "vehicle.steering_dead_time") ||
                    is_about(effects, "vehicle.steering_lag");
  if (third) {
    // What acts before an actuator is not seen behind it.
    logged.commands = logged.commands || is_about(effects, "vehicle.throttle_dead_time") ||
                      is_about(effects, "vehicle.brake_dead_time");
    logged.reached = !logged.commands || dice.uniform() < 0.5;
  }
  return logged;
}

}  // namespace

void draw_blind(int id, unsigned long long seed, double third_share,
                const std::filesystem::path& folder) {
  Random dice{seed * 1000003ull + static_cast<unsigned long long>(id)};
  for (int k = 0; k < 5; ++k) dice.uniform();
  const Track track = draw_track(dice);
  const bool third = is_third(id, seed, third_share);
  Variant nominal = draw_car(third, dice);
  const int laps = 2 + static_cast<int>(dice.below(7));
  const double hz = std::array{25.0, 50.0, 100.0}[dice.below(3)];
  const Style style{.laps = laps, .seed = seed * 7919 + static_cast<unsigned long long>(id)};
  const Style one_lap{.laps = 1, .seed = style.seed};

  const Question question =
      choose_for(third, kKinds[static_cast<std::size_t>(id) % kKinds.size()], dice);
  const Sized sized = size_effects(question, track, style, hz, nominal, dice);
  const std::string lacking = draw_lacking(sized.effects, nominal, dice);
  std::vector<Effect> as_driven = sized.effects;
  if (!lacking.empty()) as_driven.push_back({lacking, "", 0.0});
  Track moved = track;
  moved.shift_m = sized.shift_m;
  const Drive real = drive(with(nominal, as_driven, moved), track, style, nullptr);
  if (real.row.size() < kShortestDrive) {
    std::fprintf(stderr, "trial %d: no drive\n", id);
    return;
  }

  char name[16];
  std::snprintf(name, sizeof name, "%04d", id);
  const std::filesystem::path here = folder / name, sealed = folder / "sealed";
  std::filesystem::create_directories(here);
  write_road(track, track, TruthCar{}, here / "track.crg");  // as the simulation knows it
  const Deviations deviations = deviate(question, sized.effects, dice);
  write_car(stated_car(nominal, deviations, as_driven, dice), here);

  const std::vector<Column> logged = columns(draw_logged(question, sized.effects, third, dice));
  const auto log = third ? csv_by_channel : csv;
  Random noise = dice, same_noise = dice;
  write(here / "run.csv", log(real.row, logged, hz, sized.effects, noise));
  if (!sized.effects.empty() && question.kind != "alike") {
    const Drive clean = drive(without(nominal, as_driven, track), track, style, nullptr);
    if (clean.row.size() >= kShortestDrive)
      write(sealed / (std::string(name) + ".csv"), log(clean.row, logged, hz, {}, same_noise));
  }

  Json truth{{"id", id},
             {"class", question.kind},
             {"car", third ? "third" : "second"},
             {"third_share", third_share},
             {"laps", laps},
             {"hz", hz},
             {"length_m", track.length_m},
             {"effects", Json::array()},
             {"alike", Json::array()},
             {"apart_sd", sized.apart_sd},
             {"compensated", deviations.compensated},
             {"lacking", lacking},
             {"parameters", Json::array()}};
  if (third) {
    truth["tyre"] = nominal.car.electric->tyre == TyreLaw::kBrush ? "brush" : "table";
    truth["accelerometers"] = nominal.car.electric->levelled ? "levelled" : "leaning";
  }
  if (question.kind == "alike") truth["alike"] = {question.pair.one, question.pair.other};
  for (std::size_t k = 0; k < sized.effects.size(); ++k)
    truth["effects"].push_back(truth_of(sized.effects[k], sized.sizes_sd[k]));
  for (const std::size_t k : question.parameters) {
    const Variant as_stated = with_stated(nominal, k, deviations);
    const double size_sd = drive(nominal, track, one_lap, &as_stated).size;
    truth["effects"].push_back({{"mechanism", kParameters[k].id},
                                {"name", kParameters[k].name},
                                {"channel", ""},
                                {"amount", deviations.share[k]},
                                {"size_sd", size_sd}});
  }
  for (std::size_t k = 0; k < kParameters.size(); ++k)
    truth["parameters"].push_back(
        {{"name", kParameters[k].name}, {"deviation", deviations.share[k]}});
  write(sealed / (std::string(name) + ".json"), truth.dump(1) + "\n");
}

}  // namespace trials
