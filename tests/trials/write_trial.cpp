#include "write_trial.h"

#include <crg/file.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "stated_tyre.h"

namespace trials {
namespace {

using Json = nlohmann::ordered_json;

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  if (!out) std::fprintf(stderr, "cannot write %s\n", path.c_str()), std::exit(1);
}

/// `line` gives the line, `heights` the heights, `car` its effects on them.
void write_road(const Track& line_of, const Track& heights, const TruthCar& car, const std::filesystem::path& path) {
  // Waves and teeth want a finer grid than hills.
  const std::size_t per_node = line_of.feature.empty() ? 1 : 10;
  const double v_step = line_of.feature.empty() ? 0.5 : 0.25;
  crg::ReferenceLine line;
  crg::Grid grid;
  line.u_step_m = grid.u_step_m = line_of.step_m / static_cast<double>(per_node);
  line.closed = true;
  const int half = static_cast<int>(10 / v_step);
  for (int j = -half; j <= half; ++j) grid.v_m.push_back(v_step * j);
  const std::size_t n = line_of.x.size();
  for (std::size_t i = 0; i <= n * per_node; ++i) {
    const double s = static_cast<double>(i % (n * per_node)) * line.u_step_m;
    if (per_node == 1) {
      line.x_m.push_back(line_of.x[i % n]);
      line.y_m.push_back(line_of.y[i % n]);
      const std::size_t before = (i + n - 1) % n;
      line.heading_rad.push_back(std::atan2(line_of.y[i % n] - line_of.y[before], line_of.x[i % n] - line_of.x[before]));
    } else {
      const Track::Point p = line_of.at(s);
      line.x_m.push_back(p.x);
      line.y_m.push_back(p.y);
      const Track::Point before = line_of.at(s + line_of.length_m - line.u_step_m);
      line.heading_rad.push_back(std::atan2(p.y - before.y, p.x - before.x));
    }
    for (const double v : grid.v_m) grid.z_m.push_back(static_cast<float>(heights.height(s) + v * true_bank(car, heights, s) + heights.rough(s, v)));
  }
  crg::write(crg::make_crg(line, grid), path.string(), crg::Format::KRBI);
}

}  // namespace

bool write_trial(const Trial& trial, Random& dice, const std::filesystem::path& folder) {
  const Track& track = trial.track;
  Drive d = drive(trial.car, track, trial.style, false);
  if (trial.discs) heat(d, trial.car, *trial.discs);
  if (trial.ride) shake(d, track, trial.car, *trial.ride);
  if (d.row.size() < 4000) {
    std::fprintf(stderr, "trial %s: no drive\n", trial.name.c_str());
    return false;
  }

  const std::filesystem::path here = folder / trial.name;
  std::filesystem::create_directories(here);
  // The road as the simulation knows it, and as it is.
  write_road(track, trial.stated_track ? *trial.stated_track : track, TruthCar{}, here / "track.crg");
  if (trial.kind == "proof") write_road(track, track, trial.car, folder / "sealed" / (trial.name + ".crg"));

  // The stated car: a few per cent off everywhere.
  const auto off = [&](double share = 1.0) { return dice.in(1 - share * trial.off, 1 + share * trial.off); };
  const TruthCar& t = trial.nominal;
  write(here / "front.tir", tir({t.load_f, t.mu_f * off(), t.mu_load * off(5), t.c_f * off(), t.ck * off(), 0.325, t.relaxation_f}));
  write(here / "rear.tir", tir({t.load_r, t.mu_r * off(), t.mu_load * off(5), t.c_r * off(), t.ck * off(), 0.328, t.relaxation_r}));
  std::string engine = "engine_radps:throttle,0,0.25,0.5,0.75,1\n";
  const double tilt = dice.in(-0.75, 0.75) * trial.off, scale = off();
  for (int omega = 100; omega <= 850; omega += 50) {
    engine += std::to_string(omega);
    for (const double thr : {0.0, 0.25, 0.5, 0.75, 1.0}) engine += "," + std::to_string(t.engine_nm(omega, thr) * scale * (1 + tilt * (omega - 500) / 300.0));
    engine += "\n";
  }
  write(here / "engine.csv", engine);
  std::string without;
  for (const std::string& term : trial.without) without += ", " + term + ": 0";
  char yaml[4000];
  std::snprintf(yaml, sizeof yaml,
                "name: stated\ntyres: {front: front.tir, rear: rear.tir, alpha: tan}\nmaps: {engine_torque_nm: engine.csv}\ncontact: single_point\nparameters:\n"
                "  chassis.mass_kg: %.2f\n  chassis.wheelbase_m: %.3f\n  chassis.cog_behind_front_m: %.4f\n  chassis.cog_height_m: %.4f\n  chassis.yaw_inertia_kgm2: %.1f\n"
                "  front.track_m: %.3f\n  rear.track_m: %.3f\n  aero.drag_area_m2: %.4f\n  front.lift_area_m2: %.4f\n  rear.lift_area_m2: %.4f\n"
                "  engine.inertia_kgm2: %.4f\n  engine.limit_radps: 830\n  front.wheel_inertia_kgm2: 0.9\n  rear.wheel_inertia_kgm2: 0.9\n  gearbox.efficiency: 0.95\n"
                "  gearbox.final: 3\n  gearbox.ratio_1: 2.9\n  gearbox.ratio_2: 2.1\n  gearbox.ratio_3: 1.65\n  gearbox.ratio_4: 1.36\n  gearbox.ratio_5: 1.16\n  gearbox.ratio_6: 1.02\n"
                "  front.brake_area_m2: 0.004\n  front.brake_radius_m: 0.125\n  front.brake_friction: %.4f\n  rear.brake_area_m2: 0.003\n  rear.brake_radius_m: 0.115\n  rear.brake_friction: %.4f\n"
                "  front.camber_rad: %.4f\n  rear.camber_rad: %.4f\n  front.camber_gain_radpm: 0\n  rear.camber_gain_radpm: 0\n  front.toe_rad: 0\n  rear.toe_rad: 0\n"
                "terms: {aero_ride_height: 0, aero_yaw: 0, turbo_lag: 0, tyre_thermal: 0, tyre_camber: 0, brake_friction_temperature: 0, fuel_burn: 0, limited_slip: 0, locked_differential: 0, "
                "steering_actuator: 0, steering_friction: 0, throttle_actuator: 0, brake_actuator: 0, wind: 0%s}\n",
                t.mass * off(), t.a + t.b, t.a * off(0.375), t.h * off(), t.inertia * off(), t.track_f, t.track_r, t.drag * off(), t.lift_f * off(), t.lift_r * off(),
                t.engine_inertia * off(), t.brake_f / (4 * 0.004 * 0.125) * off(), t.brake_r / (4 * 0.003 * 0.115) * off(), t.camber, t.camber, without.c_str());
  write(here / "vehicle.yaml", yaml);

  if (trial.ride) {
    std::string ride = "parameters:\n";
    char line[200];
    for (const std::size_t k : {0u, 1u}) {
      const char* axle = k == 0 ? "front" : "rear";
      std::snprintf(line, sizeof line, "  %s.spring_npm: %.0f\n  %s.bump_damping_nspm: %.0f\n  %s.rebound_damping_nspm: %.0f\n  %s.anti_roll_npm: %.0f\n  %s.unsprung_mass_kg: %.2f\n", axle,
                    trial.ride->spring[k] * off(), axle, trial.ride->damping[k] * off(), axle, trial.ride->damping[k] * off(), axle, trial.ride->bar[k] * off(), axle,
                    trial.ride->unsprung[k] * off());
      ride += line;
    }
    std::string text = yaml;
    text.replace(text.find("parameters:\n"), 12, ride);
    write(here / "vehicle.yaml", text);
  }

  // The recording. Some logs lack channels; what a trial is about stays in.
  const bool all = trial.every_channel;
  const bool loads = !all && dice.uniform() < 0.3, vertical = all || dice.uniform() < 0.5, engine_speed = all || dice.uniform() < 0.6, gear = all || dice.uniform() < 0.85;
  const auto about = [&](const char* channel) { return std::any_of(trial.car.effects.begin(), trial.car.effects.end(), [&](const Effect& e) { return e.channel == channel; }); };
  const bool ax = all || about("ax_mps2") || dice.uniform() < 0.85, ay = all || about("ay_mps2") || dice.uniform() < 0.8;
  const bool commands = trial.style.dead_steer > 0 || (!all && dice.uniform() < 0.4);
  struct Column { std::string name; int channel; };
  std::vector<Column> columns{{"time_s", kT}, {"x_m", kX}, {"y_m", kY}, {"yaw_rad", kYaw}, {"vx_mps", kVx}, {"vy_mps", kVy}, {"yaw_rate_radps", kR}};
  if (ax) columns.push_back({"ax_mps2", kAx});
  if (ay) columns.push_back({"ay_mps2", kAy});
  if (vertical) columns.push_back({"az_mps2", kAz});
  columns.push_back({commands ? "steer_command_rad" : "steer_rad", kSteer});
  columns.push_back({commands ? "throttle_command" : "throttle", kThrottle});
  for (const char* wheel : {"fl", "fr", "rl", "rr"}) columns.push_back({std::string("brake_") + wheel + (commands ? "_command_pa" : "_pa"), kBrake});
  if (gear) columns.push_back({"gear", kGear});
  if (engine_speed || !gear) columns.push_back({"engine_radps", kEngine});
  for (const auto& [wheel, channel] : {std::pair{"fl", kWfl}, {"fr", kWfr}, {"rl", kWrl}, {"rr", kWrr}}) columns.push_back({std::string("wheel_") + wheel + "_radps", channel});
  if (loads) {
    for (const auto& [wheel, channel] : {std::pair{"fl", kFzF}, {"fr", kFzF}, {"rl", kFzR}, {"rr", kFzR}}) columns.push_back({std::string("fz_") + wheel + "_n", channel});
  }
  if (trial.ride) {
    columns.push_back({"roll_rate_radps", kRollRate});
    columns.push_back({"pitch_rate_radps", kPitchRate});
    int wheel = 0;
    for (const char* name : {"fl", "fr", "rl", "rr"}) {
      columns.push_back({std::string("suspension_") + name + "_m", kTravel + wheel});
      columns.push_back({std::string("fz_") + name + "_n", kLoad + wheel++});
    }
  }
  if (trial.discs) {
    int wheel = 0;
    for (const char* name : {"fl", "fr", "rl", "rr"}) columns.push_back({std::string("brake_disc_") + name + "_k", kDisc + wheel++});
  }
  const auto record = [&](const Drive& drawn, const char* file) {
    std::string csv;
    for (std::size_t k = 0; k < columns.size(); ++k) csv += (k ? "," : "") + columns[k].name;
    csv += "\n";
    const auto every = static_cast<std::size_t>(200.0 / trial.hz);
    for (std::size_t i = 0; i < drawn.row.size(); i += every) {
      for (std::size_t k = 0; k < columns.size(); ++k) {
        const int channel = columns[k].channel;
        double value = sensed(drawn, i, channel, trial.car.effects, columns[k].name);
        if (channel == kFzF || channel == kFzR) value *= 0.5;
        value += kNoise[static_cast<std::size_t>(channel)] * dice.normal();
        if (channel == kBrake || channel == kThrottle) value = std::max(0.0, value);
        if (columns[k].name.ends_with("_command_rad") || columns[k].name.ends_with("_command") || columns[k].name.ends_with("_command_pa")) value = drawn.row[i][static_cast<std::size_t>(channel)];
        char text[40];
        std::snprintf(text, sizeof text, "%s%.7g", k ? "," : "", value);
        csv += text;
      }
      csv += "\n";
    }
    write(here / file, csv);
  };
  record(d, "run.csv");
  if (trial.experiment) record(drive(trial.car, track, *trial.experiment, false), "experiment.csv");

  Json truth{{"id", trial.id}, {"class", trial.kind}, {"laps", trial.style.laps}, {"hz", trial.hz}, {"length_m", track.length_m}, {"effects", Json::array()}, {"alike", trial.alike}};
  for (std::size_t k = 0; k < trial.car.effects.size(); ++k) {
    const Effect& e = trial.car.effects[k];
    Json item{{"mechanism", e.mechanism}, {"channel", e.channel}, {"amount", e.amount}, {"extra", e.extra}, {"size_sd", trial.sizes[k]}};
    if (e.end_m > 0) item["where"] = {e.begin_m, e.end_m};
    truth["effects"].push_back(item);
  }
  for (const auto& [name, value] : trial.notes) truth[name] = value;
  write(folder / "sealed" / (trial.name + ".json"), truth.dump(1) + "\n");
  return true;
}

}  // namespace trials
