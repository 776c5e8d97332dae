#include "write_trial.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "stated_electric.h"

namespace trials {
namespace {

using Json = nlohmann::ordered_json;

/// Springs and dampers as stated, in lines of a vehicle file.
std::string suspension(const Ride& ride, const auto& off) {
  std::string out;
  for (const std::size_t k : {0u, 1u}) {
    const double unsprung_kg = ride.unsprung[k] * off(), bar_npm = ride.bar[k] * off(),
                 rebound_nspm = ride.damping[k] * off(), bump_nspm = ride.damping[k] * off(),
                 spring_npm = ride.spring[k] * off();
    const char* axle = k == 0 ? "front" : "rear";
    char text[250];
    std::snprintf(text, sizeof text,
                  "  %s.spring_npm: %.0f\n  %s.bump_damping_nspm: %.0f\n  %s.rebound_damping_nspm: "
                  "%.0f\n  %s.anti_roll_npm: %.0f\n  %s.unsprung_mass_kg: %.2f\n",
                  axle, spring_npm, axle, bump_nspm, axle, rebound_nspm, axle, bar_npm, axle,
                  unsprung_kg);
    out += text;
  }
  return out;
}

/// A few per cent off everywhere.
StatedCar stated_car(const Trial& trial, Random& dice) {
  const auto off = [&](double share = 1.0) {
    return dice.in(1 - share * trial.off, 1 + share * trial.off);
  };
  const TruthCar& t = trial.nominal;
  StatedCar car;
  car.front = {t.load_f,     t.mu_f * off(), t.mu_load * off(5), t.c_f * off(),
               t.ck * off(), t.radius_f,     t.relaxation_f};
  car.rear = {t.load_r,     t.mu_r * off(), t.mu_load * off(5), t.c_r * off(),
              t.ck * off(), t.radius_r,     t.relaxation_r};
  car.engine = t;
  car.torque_tilt = dice.in(-0.75, 0.75) * trial.off;
  car.torque_scale = off();
  car.rear_brake_friction = rear_friction(t.brake_r) * off();
  car.front_brake_friction = front_friction(t.brake_f) * off();
  car.engine_inertia_kgm2 = t.engine_inertia * off();
  car.rear_lift_area_m2 = t.lift_r * off();
  car.front_lift_area_m2 = t.lift_f * off();
  car.drag_area_m2 = t.drag * off();
  car.rear_track_m = t.track_r;
  car.front_track_m = t.track_f;
  car.yaw_inertia_kgm2 = t.inertia * off();
  car.cog_height_m = t.h * off();
  car.cog_behind_front_m = t.a * off(0.375);
  car.wheelbase_m = t.a + t.b;
  car.mass_kg = t.mass * off();
  car.camber_rad = t.camber;
  for (const std::string& term : trial.without) car.terms += ", " + term + ": 0";
  car.front_roll_share = t.roll_front;
  if (trial.ride) car.first_parameters = suspension(*trial.ride, off);
  if (t.electric) state_electric(car, t, dice, trial.off);
  return car;
}

Json truth_of(const Trial& trial) {
  const std::vector<Effect>& effects = trial.truth.car.effects;
  Json truth{{"id", trial.id},
             {"class", trial.kind},
             {"laps", trial.style.laps},
             {"hz", trial.hz},
             {"length_m", trial.track.length_m},
             {"effects", Json::array()},
             {"alike", trial.alike}};
  for (std::size_t k = 0; k < effects.size(); ++k)
    truth["effects"].push_back(truth_of(effects[k], trial.sizes[k]));
  for (const auto& [name, value] : trial.notes) truth[name] = value;
  return truth;
}

}  // namespace

Json truth_of(const Effect& e, double size_sd) {
  Json item{{"mechanism", e.mechanism},
            {"channel", e.channel},
            {"amount", e.amount},
            {"extra", e.extra},
            {"size_sd", size_sd}};
  if (e.end_m > 0) item["where"] = {e.begin_m, e.end_m};
  return item;
}

bool write_trial(const Trial& trial, Random& dice, const std::filesystem::path& folder) {
  const Track& track = trial.track;
  const TruthCar& car = trial.truth.car;
  Drive d = drive(trial.truth, track, trial.style, nullptr);
  if (trial.discs) heat(d, car, *trial.discs);
  if (trial.ride) shake(d, track, car, *trial.ride);
  if (d.row.size() < kShortestDrive) {
    std::fprintf(stderr, "trial %s: no drive\n", trial.name.c_str());
    return false;
  }

  const std::filesystem::path here = folder / trial.name;
  std::filesystem::create_directories(here);
  // The road as the simulation knows it, and as it is.
  write_road(track, trial.stated_track ? *trial.stated_track : track, TruthCar{},
             here / "track.crg");
  if (trial.kind == "proof")
    write_road(track, track, car, folder / "sealed" / (trial.name + ".crg"));
  const StatedCar stated = stated_car(trial, dice);
  write_car(stated, here);

  const std::vector<Column> all = columns({.ax = trial.accelerometers,
                                           .ay = trial.accelerometers,
                                           .az = trial.accelerometers,
                                           .commands = trial.commands,
                                           .reached = car.electric.has_value(),
                                           .body = trial.ride.has_value(),
                                           .discs = trial.discs.has_value()});
  const auto log = car.electric ? csv_by_channel : csv;
  write(here / "run.csv", log(d.row, all, trial.hz, car.effects, dice));
  if (trial.experiment)
    write(here / "experiment.csv", log(drive(trial.truth, track, *trial.experiment, nullptr).row,
                                       all, trial.hz, car.effects, dice));
  Json truth = truth_of(trial);
  // Stated torque over true, near the bottom and the top of the speeds that are driven.
  if (trial.kind == "fleet")
    truth["stated_torque"] = {torque_factor(stated, car.electric ? 600.0 : 400.0),
                              torque_factor(stated, car.electric ? 1600.0 : 800.0)};
  write(folder / "sealed" / (trial.name + ".json"), truth.dump(1) + "\n");
  return true;
}

}  // namespace trials
